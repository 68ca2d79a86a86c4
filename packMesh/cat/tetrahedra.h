// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Objects, the space between them (thesis 3.1.2.1), and tetrahedra in it, of which CAT cells are
/// composed.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "packMesh/cat/tetgen_run.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

/// TetGen failed on input that passed every check.
class TetrahedraError : public std::runtime_error {
 public:
  explicit TetrahedraError(const std::string& what, int attempts = 1)
      : std::runtime_error(what), attempts_(attempts) {}
  int attempts() const { return attempts_; }  ///< runs of TetGen that failed

 private:
  int attempts_;
};

/// A closed, outward-oriented mesh and its placement.
struct PlacedMesh {
  const MeshHierarchy* mesh = nullptr;
  Placement placement;
};

/// An object, or a periodic image of one, in a tetrahedralisation.
struct TetrahedraBody {
  int object;
  Vec3 shift;          ///< translation from the given position [µm]
  bool primary;        ///< the tetrahedra at it are wanted
  int given = -1;      ///< its index in TetrahedraInput::bodies
  int firstPoint = 0;  ///< its points are numbered from here on, its mesh's vertices first
};

enum class TetrahedraKind {
  constrained,  ///< surfaces are unions of faces of tetrahedra (CDT)
  delaunay,     ///< of the vertices alone: tetrahedra may intersect surfaces. Takes a quarter of the time
};

enum class TetrahedraKept {
  freeSpace,  ///< those outside of all objects and inside the container
  joining,  ///< of these, those that join a primary body to another one or the container: required by growth
};

/// Input of a tetrahedralisation.
struct TetrahedraInput {
  std::vector<PlacedMesh> objects;
  std::vector<std::string> names;  ///< of objects, for messages; those without are referred to by number
  const MeshHierarchy* container =
      nullptr;                 ///< closed surface; nullptr: up to the convex hull, or periodic images
  Vec3 period = Vec3::Zero();  ///< [µm], 0: not periodic along this axis
  Box bounds;                  ///< of one period, needed along periodic axes
  /// Objects and images of them to be tetrahedralised, in any order; only `object`, `shift` and `primary` are
  /// read. Empty: all objects within the bounds, as primary bodies, and their images up to the margin.
  std::vector<TetrahedraBody> bodies;
  /// Per entry of `bodies`, which of its vertices are points, and with them the triangles between these;
  /// empty: all. For TetrahedraKept::joining, where parts of surfaces that face no other within reach can do
  /// without.
  std::vector<std::vector<char>> points;
  /// Images of objects up to this distance outside the bounds are included [µm]; 0: as far as necessary for
  /// the tetrahedra at primary bodies to be those of the infinite periodic arrangement.
  double margin = 0.0;
  TetrahedraKind kind = TetrahedraKind::constrained;
  TetrahedraKept kept = TetrahedraKept::freeSpace;  ///< always `joining` for plain Delaunay tetrahedra
  /// The caller has established, by exact tests, what requireValid() would.
  bool valid = false;
  /// Whether the message names objects that TetGen finds to intersect, which takes another run.
  bool explain = true;
  std::function<bool()> stop = {};  ///< see runTetgen()
  int failingAttempts = 0;          ///< for tests: number of attempts that are treated as failed
};

/// Label of the container's points.
inline constexpr int wallLabel = -1;

struct Tetrahedra {
  std::vector<Vec3> points;             ///< [µm]
  std::vector<int> labels;              ///< per point: number of its body, or wallLabel
  std::vector<int> vertices;            ///< per point: which vertex of its mesh, -1: a Steiner point
  std::vector<Tetrahedron> tetrahedra;  ///< of positive volume
  /// In an order that depends on their positions, not on the numbering of objects. So does everything else.
  std::vector<TetrahedraBody> bodies;
  int attempts = 0;  ///< runs of TetGen that it took, failed ones included

  bool isPrimary(int label) const { return label != wallLabel && bodies[label].primary; }
  const Vec3& corner(int tetrahedron, int k) const { return points[tetrahedra[tetrahedron][k]]; }
};

/// "object 3", or its name if it has one.
std::string nameOf(const TetrahedraInput& input, int object);

/// TetrahedraInput::bodies, or objects translated by whole periods into the bounds and their images up to
/// `margin` outside; sorted by position. Their points are not numbered yet.
std::vector<TetrahedraBody> bodiesAround(const TetrahedraInput& input, double margin);

/// Placement of a body.
Placement placementOf(const TetrahedraInput& input, const TetrahedraBody& body);

/// Surface of the container as far as bodies up to `margin` outside of the bounds can extend; empty without a
/// container.
std::optional<MeshHierarchy> containerAround(const TetrahedraInput& input, double margin);

/// Largest radius of the objects' bounding spheres [µm].
double largestRadius(const TetrahedraInput& input);

/// Closed surface of a container together with `images[k]` images of it on either side along each periodic
/// axis k. The triangles in the planes that bound one period are openings, where images are joined.
/// @param surface closed, of one period; @param bounds of that period [µm]
/// @param period [µm], 0: not periodic
/// @throws InputError if the two ends along an axis are not flat, or do not match vertex by vertex
TriangleMesh repeatedSurface(const TriangleMesh& surface, const Box& bounds, const Vec3& period,
                             const std::array<int, 3>& images);

/// Refuses input that TetGen cannot process: TetGen 1.5 crashes on surfaces that intersect.
/// @throws MeshError naming the object whose mesh is open, intersects itself, is flat ... (see repairClosed)
/// @throws InputError naming the objects that overlap or contain each other (exact, periodic images
///   included), or the one that is not inside the container
void requireValid(const TetrahedraInput& input);

/// The triangles that are not faces of the tetrahedra: indices, ascending. Takes about as long as one pass
/// over the tetrahedra.
/// @param points number of points
std::vector<int> missingTriangles(const std::vector<Triangle>& triangles,
                                  const std::vector<Tetrahedron>& tetrahedra, std::size_t points);

/// The triangles that are, most likely, not faces of the Delaunay tetrahedra of the points: those for which
/// no empty sphere of up to about the triangle's size through their corners was found. Takes a hundredth of
/// the time of a tetrahedralisation.
std::vector<int> likelyMissing(const std::vector<Triangle>& triangles, const std::vector<Vec3>& points);

/// Tetrahedra with vertices on the objects and the container.
///
/// Constrained: edges and triangles that are not present in the Delaunay tetrahedra are enforced by Steiner
/// points on them; a Steiner point has the label of its surface. If periodic and with `freeSpace`, TetGen is
/// run until images of an object have the same Steiner points, so that the tetrahedra are periodic too
/// (Steiner points on the container are not); with `joining` they are, except near a few Steiner points. The
/// result does not depend on the order of the objects, apart from the numbering in it.
/// @throws MeshError, InputError see requireValid()
/// @throws InputError if the program that runs TetGen is missing, see tetgenProgram()
/// @throws TetrahedraError if TetGen fails in every mode
Tetrahedra tetrahedralise(const TetrahedraInput& input);

}  // namespace packmesh
