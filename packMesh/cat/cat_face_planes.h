// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes from the faces of CAT cells, between the parts of surfaces that come within reach.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/cat_settings.h"
#include "packMesh/cat/chord_planes.h"
#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/problem/execution.h"

namespace packmesh {

/// For every object, the planes of its CAT faces, each with the vertex that it constrains (v, q, n of the
/// thesis).
/// @param objects as passed to tetrahedralise()
/// @param minimumCosine excludes faces whose normal is unrelated to the gap: those for which the largest
///   cosine of the angle between the normal and an edge of the tetrahedron that crosses the face is smaller
///   than this. Slivers have such faces, and they lock cells (0.3 is a good value); 0: all faces, as in the
///   thesis
/// @param reach per object, upper bound of the displacement of any of its points [µm]: planes further away
///   are left out; empty: none are
PlaneConstraints planesOfFaces(const Tetrahedra& tetrahedra, const ChordalFaces& faces,
                               const std::vector<PlacedMesh>& objects, double minimumCosine,
                               const std::vector<double>& reach = {});

/// The cells of a request and those that come within their reach, with the images of cells that do.
struct ReachedBodies {
  std::vector<std::int64_t> members;   ///< cells, ascending
  std::vector<TetrahedraBody> bodies;  ///< members are their objects; by member, then by shift
  std::vector<NearPair> pairs;         ///< of cells, at least one of them requested
};

ReachedBodies bodiesWithinReach(const PlaneRequest& request);

/// A mesh of a cell in its body frame, and which of its vertices are points.
struct ReachingMesh {
  MeshHierarchy hierarchy;
  /// Those that are whatever is within reach: corners of triangles so large that they can face another
  /// surface although no corner is within reach of it.
  std::vector<char> always;
  /// Distances from other surfaces up to which they are [µm at scale 1]: those that a coarser level of detail
  /// has, too, are farther.
  std::vector<double> within;
};

/// The meshes of all levels of detail of a shape, finest first.
/// @param size cube root of the volume [µm]
std::vector<std::unique_ptr<const ReachingMesh>> reachingMeshes(const LevelsOfDetail& levels, double size);

/// Which vertices of each body are points: those within reach of the body that it is near to, as far as their
/// level of detail counts, and those that share a triangle with them. A body that is not requested has those
/// near to a requested one.
/// @param meshes of the members
std::vector<std::vector<char>> pointsWithinReach(const PlaneRequest& request, const ReachedBodies& reached,
                                                 const std::vector<const ReachingMesh*>& meshes,
                                                 const ChordPlanes& chords);

/// Statistics of tetrahedralisation on one rank.
struct TetrahedraSums {
  std::int64_t runs = 0;      ///< tetrahedralisations
  std::int64_t attempts = 0;  ///< of TetGen; more than runs if it had to be repeated in other modes
  std::int64_t finer = 0;     ///< runs repeated on a finer level because the coarse ones overlapped
  std::int64_t failures = 0;  ///< TetGen failed: planes were those of ChordPlanes
  std::string lastFailure;    ///< description, of the last request of those with failures
  double tetrahedraSeconds = 0.0, faceSeconds = 0.0;  ///< CPU [s]
};

/// Planes from CAT faces, except for those of slivers: TetGen divides the space between the cells. Planes at
/// walls are those of ChordPlanes: the distance to the wall is exact, a triangulation of it is not.
///
/// Cells that are requested together are tetrahedralised together with what is within their reach,
/// independently of the rank; as many requests at the same time as there are threads. If TetGen fails, their
/// planes are those of ChordPlanes.
class CatFacePlanes : public PlaneFunction {
 public:
  /// References physics, execution and sums, which must outlive this.
  /// @param sums statistics are added to this
  /// @param failingAttempts for tests: the number of attempts of every run that are treated as failed
  CatFacePlanes(const Physics& physics, const Execution& execution, TetrahedraSums& sums,
                int failingAttempts = 0);

  void begin(const std::vector<PlaneRequest>& requests) override;
  /// Pre: begin() was called for the last one of this batch that was `anew`
  void operator()(const PlaneRequest& request, std::vector<CellPlanes>& planes) override;
  std::int64_t cellsAtOnce() const override;
  std::int64_t lifetime() const override;

 private:
  /// The tetrahedra around one group of cells.
  struct Around {
    std::vector<std::int64_t> members;  ///< the cells included
    std::vector<PlacedMesh> objects;    ///< these, at their positions when the points were last moved
    Tetrahedra tetrahedra;
    TetrahedraSums sums;  ///< of this run
  };
  /// The level of detail of a shape that is at most `coarsest`, and fine enough for the request.
  int levelOf(const PlaneRequest& request, int shape, int coarsest) const;
  void tetrahedralise(const PlaneRequest& request, const std::function<bool()>& stop, Around& around) const;
  /// Places the members at a level of detail.
  void place(const PlaneRequest& request, const ReachedBodies& reached, int level,
             TetrahedraInput& input) const;
  void follow(const PlaneRequest& request, Around& around) const;

  const Physics& physics_;
  const Execution& execution_;
  ChordPlanes chords_;
  std::vector<std::vector<std::unique_ptr<const ReachingMesh>>> levels_;  ///< per shape in use, finest first
  TetrahedraInput input_;                                                 ///< what is common to all
  std::vector<Around> around_;                                            ///< per batch
  TetrahedraSums& sums_;
  std::mutex sumsMutex_;  ///< of sums_.faceSeconds
};

/// References physics, execution and sums, which must outlive it.
/// @param sums statistics of tetrahedralisation are added to this
std::unique_ptr<PlaneFunction> makePlaneFunction(PlaneSource planeSource, const Physics& physics,
                                                 const Execution& execution, TetrahedraSums& sums);

}  // namespace packmesh
