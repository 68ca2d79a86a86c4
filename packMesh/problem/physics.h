// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is true of a packing, however it is found.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/container/region.h"
#include "packMesh/core/pose.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// A cell of a state or of a running simulation. Numbers such as the residual of a fit are columns beside the
/// cells.
struct Cell {
  std::int64_t id = 0;       ///< among the cells of the file or of the simulation
  std::int32_t species = 0;  ///< index into their kinds or types
  Pose pose;
  /// Of a mesh of its own, in the order and frame of the template [µm]; empty: it has that of the template.
  std::vector<Vec3> vertices = {};
  /// Of these, in a state of a packing: index into Physics::shapes of what was packed; -1: not known.
  std::int32_t shape = -1;
  /// As in a .pos file [degrees], for the rotation with which the cell was certified; NaN: follow from the
  /// pose.
  Vec3 angles = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
};

/// A cell as the numbers written to files place it: certificate and acceptance refer to these, which are not
/// those of a pose to the last bit.
struct PlacedCell {
  std::int32_t species = 0;  ///< index into Physics::species
  std::int32_t shape = 0;    ///< index into Physics::shapes
  Placement placement;
};
static_assert(sizeof(PlacedCell) == 8 + sizeof(Placement), "there are many");

/// Allowed directions of the axis of a cell: the y axis of its mesh, which is the symmetry axis of red cells
/// and platelets. The two ends of an axis are equivalent.
struct AxisCone {
  Vec3 axis = Vec3::UnitY();  ///< unit vector
  double spread = 0.0;        ///< largest angle between the cell's axis and this one [rad]

  /// Angle between the axis of a cell with this orientation and this one [rad], at most π/2.
  double angle(const Quaternion& orientation) const;
  /// `orientation` after the smallest rotation that brings the axis into the cone.
  Quaternion nearest(const Quaternion& orientation) const;
};

/// A layer along a wall that membranes stay out of. It is not part of the certificate: relaxation observes it
/// up to its tolerances and the interpolation of the distance.
struct FreeLayer {
  std::shared_ptr<const Wall> wall;
  double thickness = 0.0;  ///< [µm]
};

/// Constraints on the cells of a species; default: none.
struct Freedom {
  bool fixed = false;  ///< cells stay where they start
  std::optional<AxisCone> cone;
  std::shared_ptr<const Region> region;  ///< cell centres stay inside; nullptr: anywhere
  std::optional<FreeLayer> freeLayer;
  double extraWallClearance = 0.0;  ///< clearance to the wall in addition to that of all cells [µm]

  bool isFree() const { return !fixed && !cone && !region && !freeLayer && extraWallClearance == 0.0; }
};

/// Meshes that cells have: templates, and deformed forms of them.
using Shapes = std::vector<std::shared_ptr<const Shape>>;

/// A cell that has a mesh of its own from the start.
struct DeformedCell {
  int shape = 0;              ///< a deformed form of the template: index into Physics::shapes
  std::optional<Pose> start;  ///< initial pose, scale 1; empty: at random
};

/// Cells with the same constraints, and their number.
struct Species {
  std::string name;
  int shape = 0;  ///< the template, which cells have unless they are deformed: index into Physics::shapes
  std::int64_t count = 0;
  /// The wall for this species; nullptr: the container's own.
  std::shared_ptr<const Wall> wall;
  bool inHematocrit = true;  ///< its volume is part of the hematocrit
  /// The kind of cell, by which results name those of this and of other species; empty: `name`.
  std::string kind = {};
  std::vector<DeformedCell> deformed = {};  ///< the first cells
  /// Initial poses of the next cells, scale 1; the others start at random.
  std::vector<Pose> start = {};
  Freedom freedom = {};  ///< the cells of fixed species all have initial poses
  /// Starts in columns (packMesh/placement/placement.h) instead of at random. At most one species, which is
  /// unconstrained and has no initial poses, in boxes that are periodic along all axes.
  bool inColumns = false;
  /// Requested number before rounding to `count`; 0: the same. If fewer cells are tried, their numbers are
  /// derived from this one, so that larger and smaller requests try the same numbers of every species.
  double asked = 0.0;

  const std::string& kindName() const { return kind.empty() ? name : kind; }
  std::int64_t undeformed() const { return count - std::int64_t(deformed.size()); }
  bool usesTemplate() const { return undeformed() > 0 || deformed.empty(); }
  /// Cells whose initial poses are given.
  std::int64_t placed() const;
  /// Whether the initial pose of a cell is given or that of a column, so that it is not random. Numbered
  /// within the species.
  bool startsAtGivenPose(std::int64_t cell) const;
  /// Leaves the first cells.
  void resize(std::int64_t cells);
  /// Calls visit(shape, cells) for that of each deformed cell, and for the template unless all are deformed.
  template <class Visit>
  void forEachShape(const Visit& visit) const {
    for (const DeformedCell& cell : deformed) visit(cell.shape, std::int64_t(1));
    if (usesTemplate()) visit(shape, undeformed());
  }
  /// Calls visit(shape, pose) for the cells whose initial poses are given.
  template <class Visit>
  void forEachStart(const Visit& visit) const {
    for (const DeformedCell& cell : deformed)
      if (cell.start) visit(cell.shape, *cell.start);
    for (const Pose& pose : start) visit(shape, pose);
  }
};

/// The cells, the lumen, and what is required of them.
struct Physics {
  std::vector<Species> species;
  Shapes shapes;  ///< to which species and cells refer
  std::shared_ptr<const Container> container;
  /// Least gap between membranes [µm], guaranteed by the certificate. 0, the default, requires that no two
  /// meshes share a point, which is all that HemoCell needs and admits the densest packings; the gap achieved
  /// is reported.
  double clearance = 0.0;
  /// Least gap between membrane and wall [µm], guaranteed by the certificate.
  double wallClearance = 0.0;
  /// Where it is 0, and a wall has a smoothed distance: whether soft cells keep to that.
  bool smoothWalls = false;
  std::uint64_t seed = 1;
  bool rotate = true;  ///< false: every orientation stays the identity
  /// The pose as it will be written, so that the certificate refers to the written numbers; called by several
  /// threads at once. Empty: Pose::placement.
  std::function<Placement(const Pose&)> written = {};

  std::int64_t cellCount() const {
    std::int64_t cells = 0;
    for (const Species& one : species) cells += one.count;
    return cells;
  }
  /// Adds a species with a template of its own.
  Species& add(std::string name, std::shared_ptr<const Shape> shape, std::int64_t count);
  /// The shape of a cell, or the template of a species.
  template <class Cell>
  const Shape& shapeOf(const Cell& cell) const {
    return *shapes[cell.shape];
  }
  /// Whether a cell has another mesh than the template of its species.
  template <class Cell>
  bool isDeformed(const Cell& cell) const {
    return cell.shape != species[cell.species].shape;
  }
  /// Whether there are deformed forms of templates.
  bool hasDeformed() const;
  /// Whether these numbers of a file name a species, and its template or a deformed form of it.
  bool areOfCell(std::int64_t ofSpecies, std::int64_t shape) const;
  /// Numbers of the shapes that the species have, ascending.
  std::vector<int> shapesInUse() const;
  /// The wall for a species; nullptr: none.
  const Wall* wallOf(const Species& one) const { return one.wall ? one.wall.get() : container->wall(); }
  const Wall* wallOf(int s) const { return wallOf(species[s]); }
  /// Least gap between cells of a species and their wall [µm].
  double wallClearanceOf(int s) const { return wallClearance + species[s].freedom.extraWallClearance; }
  /// That of the smoothed distance to which its soft cells keep [µm]; 0: they do not.
  double smoothReachOf(int s) const {
    return smoothWalls && wallOf(s) && wallClearanceOf(s) == 0.0 ? wallOf(s)->smoothReach() : 0.0;
  }
  /// The largest length of the shapes of the species: `&Shape::radius` or `&Shape::reach` [µm].
  double largest(double (Shape::*length)() const) const;
  /// Contains all cells while they are moved: samples of distances are for this region [µm].
  Box surroundings() const { return container->surroundings(3.0 * largest(&Shape::radius)); }
  /// A cell as it will be written if it is of full size.
  Placement placement(const Pose& pose) const {
    return written && pose.scale == 1.0 ? written(pose) : pose.placement();
  }
};

/// Mean volume of the cells of a species [µm³].
double meanVolume(const Species& species, const Shapes& shapes);

/// Gives cells of this rank meshes of their own. All ranks call; the new shapes are appended on each of them.
/// @param cells of this rank
/// @param vertices by index of the cell, in the order and frame of the template [µm]. Pre: with its triangles
///   they are closed, outward-oriented surfaces
/// @param shapes of the cells
void deform(std::vector<PlacedCell>& cells, const std::map<std::size_t, std::vector<Vec3>>& vertices,
            Shapes& shapes, const Communicator& ranks);

/// Distance beyond the least that a wall demands, or a lower bound of it, and its gradient. Called by several
/// threads.
using WallGap = std::function<WallDistance(const Vec3&)>;

/// That of a species to its wall and its layer without cells; nothing if it has neither.
/// @param physics must outlive the result
std::optional<WallGap> wallGapOf(const Physics& physics, int species);

/// The physics of undeformed cells at a scale, apart from those that do not grow. They keep so far from a
/// wall that its WallGap is positive, apart from smoothed ones.
/// @param gap added to the clearances [µm]
/// @param ofSmoothed distance that is kept from the wall where they keep to smoothed ones [their reach]
Physics scaledPhysics(const Physics& physics, const std::vector<char>& grows, double scale, double gap,
                      double ofSmoothed);

}  // namespace packmesh
