// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Tetrahedra between objects (thesis 3.1.2.1): the space that CAT cells are made of.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "packMesh/growth/tetgen_run.h"
#include "packMesh/mesh/mesh_intersection.h"

namespace packmesh {

/// TetGen gave up on input that passed every check.
class TetrahedraError : public std::runtime_error {
 public:
  explicit TetrahedraError(const std::string& what, int attempts = 1)
      : std::runtime_error(what), attempts_(attempts) {}
  int attempts() const { return attempts_; }  ///< runs of TetGen that failed

 private:
  int attempts_;
};

/// A closed, outward-oriented mesh and where it is.
struct PlacedMesh {
  const MeshHierarchy* mesh = nullptr;
  Placement placement;
};

enum class TetrahedraKind {
  constrained,  ///< surfaces are unions of faces of tetrahedra (CDT)
  delaunay,     ///< of the vertices alone: tetrahedra may cut through surfaces. A quarter of the time
};

enum class TetrahedraKept {
  freeSpace,  ///< those outside of all objects and inside the container
  joining,  ///< of these, those that join a primary body with another one or the container: what growth needs
};

/// What the space between is to be cut up.
struct TetrahedraInput {
  std::vector<PlacedMesh> objects;
  std::vector<std::string> names;  ///< of objects, for messages; those without are called by number
  const MeshHierarchy* container =
      nullptr;                 ///< closed surface; nullptr: up to the convex hull, or periodic images
  Vec3 period = Vec3::Zero();  ///< [µm], 0: not periodic along this axis
  Box bounds;                  ///< of one period, needed along periodic axes
  /// Which objects are primary where they were given, all of them inside `region`, with images up to the
  /// margin outside of that taking part; empty: all that are given, within the bounds.
  std::vector<bool> primary;
  Box region;
  /// Images of objects up to this far outside the bounds take part [µm]; 0: as far as it takes for tetrahedra
  /// at primary bodies to be those of the endless periodic arrangement.
  double margin = 0.0;
  TetrahedraKind kind = TetrahedraKind::constrained;
  TetrahedraKept kept = TetrahedraKept::freeSpace;  ///< always `joining` for plain Delaunay tetrahedra
  /// The caller has shown, by exact tests, what requireValid() would.
  bool valid = false;
  /// Whether the message names the objects that TetGen fails on, which takes a run for each.
  bool explain = true;
  std::function<bool()> stop = {};  ///< see runTetgen()
  int failingAttempts = 0;          ///< for tests: so many attempts are taken to have failed
  int failingObject = -1;           ///< for tests: all attempts with this object are taken to have failed
};

/// An object, or a periodic image of one, among tetrahedra.
struct TetrahedraBody {
  int object;
  Vec3 shift;      ///< from where the object was given [µm]
  bool primary;    ///< the one whose bounding sphere has its centre within the bounds; see TetrahedraInput
  int firstPoint;  ///< its points are numbered from here on, first its mesh's vertices
};

/// Label of the container's points.
inline constexpr int wallLabel = -1;

struct Tetrahedra {
  std::vector<Vec3> points;             ///< [µm]
  std::vector<int> labels;              ///< per point: number of its body, or wallLabel
  std::vector<int> vertices;            ///< per point: which vertex of its mesh, -1: a Steiner point
  std::vector<Tetrahedron> tetrahedra;  ///< of positive volume
  /// In an order that depends on where they are, not on how objects are numbered. So does everything else.
  std::vector<TetrahedraBody> bodies;
  int attempts = 0;     ///< runs of TetGen that it took, failed ones included
  double margin = 0.0;  ///< that was used [µm]

  bool isPrimary(int label) const { return label != wallLabel && bodies[label].primary; }
  const Vec3& corner(int tetrahedron, int k) const { return points[tetrahedra[tetrahedron][k]]; }
};

}  // namespace packmesh
