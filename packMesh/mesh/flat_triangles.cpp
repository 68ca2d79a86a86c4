// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/flat_triangles.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "packMesh/mesh/predicates.h"

namespace packmesh {
namespace {

/// Sides of all triangles, by directed edge.
class SideTable {
 public:
  explicit SideTable(const TriangleMesh& mesh) {
    triangleOf_.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add(mesh.triangles[t], static_cast<int>(t));
  }

  void add(const Triangle& t, int number) {
    for (int k = 0; k < 3; ++k) triangleOf_[key(t[k], t[(k + 1) % 3])] = number;
  }
  void remove(const Triangle& t) {
    for (int k = 0; k < 3; ++k) triangleOf_.erase(key(t[k], t[(k + 1) % 3]));
  }
  /// The triangle with an edge from a to b, -1 if there is none.
  int find(int a, int b) const {
    const auto found = triangleOf_.find(key(a, b));
    return found == triangleOf_.end() ? -1 : found->second;
  }

 private:
  static std::uint64_t key(int a, int b) {
    return std::uint64_t(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
  }
  std::unordered_map<std::uint64_t, int> triangleOf_;
};

/// The corner opposite the longest side of a triangle without area; it lies between the other two.
int middleCorner(const TriangleMesh& mesh, int t) {
  int middle = 0;
  double longest = -1.0;
  for (int k = 0; k < 3; ++k) {
    const double side = (mesh.corner(t, (k + 2) % 3) - mesh.corner(t, (k + 1) % 3)).squaredNorm();
    if (side > longest) {
      longest = side;
      middle = k;
    }
  }
  return middle;
}

bool isFlat(const TriangleMesh& mesh, int t, double flatness) {
  if (axisShowing(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)) < 0) return true;
  if (flatness == 0.0) return false;
  const int k = middleCorner(mesh, t);
  const Vec3 side = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, (k + 1) % 3);
  const Vec3 across = side.cross(mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3));
  return across.norm() <= flatness * side.squaredNorm();
}

class Flips {
 public:
  Flips(TriangleMesh& mesh, double flatness) : mesh_(mesh), flatness_(flatness), sides_(mesh) {}

  /// Flips the longest side of a flat triangle t. @return false if that is not possible
  /// @param flatToo flip even if the triangle on the other side is flat
  bool flip(int t, bool flatToo) {
    const int k = middleCorner(mesh_, t);
    const Triangle flat = mesh_.triangles[t];
    const int b = flat[k], c = flat[(k + 1) % 3], a = flat[(k + 2) % 3];  // the side runs from c to a
    const int beyond = sides_.find(a, c);
    if (beyond < 0 || (!flatToo && isFlat(mesh_, beyond, flatness_))) return false;
    const Triangle other = mesh_.triangles[beyond];
    int d = -1;
    for (const int v : other)
      if (v != a && v != c) d = v;
    if (d == b || sides_.find(b, d) >= 0 || sides_.find(d, b) >= 0) return false;
    sides_.remove(flat);
    sides_.remove(other);
    mesh_.triangles[t] = {a, b, d};
    mesh_.triangles[beyond] = {b, c, d};
    sides_.add(mesh_.triangles[t], t);
    sides_.add(mesh_.triangles[beyond], beyond);
    return true;
  }

 private:
  TriangleMesh& mesh_;
  double flatness_;
  SideTable sides_;
};

std::vector<int> flatTriangles(const TriangleMesh& mesh, double flatness) {
  std::vector<int> flat;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (isFlat(mesh, static_cast<int>(t), flatness)) flat.push_back(static_cast<int>(t));
  return flat;
}

}  // namespace

std::size_t removeFlatTriangles(TriangleMesh& mesh, double flatness) {
  std::vector<int> flat = flatTriangles(mesh, flatness);
  if (flat.empty()) return 0;
  const std::size_t given = flat.size();
  Flips flips(mesh, flatness);
  // A flip next to a triangle that is not flat removes one flat triangle. A flip between two flat ones
  // shortens the longest side of both, so the number of such flips is bounded by the number of pairs of
  // corners on their line.
  const std::size_t most = given * given + given;
  for (std::size_t done = 0; !flat.empty() && done < most;) {
    const std::size_t before = done;
    for (const int t : flat)
      if (isFlat(mesh, t, flatness)) done += flips.flip(t, false);
    flat = flatTriangles(mesh, flatness);
    if (done > before) continue;
    for (const int t : flat)
      if (done == before) done += flips.flip(t, true);
    if (done == before) break;
  }
  return given - std::min(given, flat.size());
}

}  // namespace packmesh
