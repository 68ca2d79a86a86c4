// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/flat_triangles.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include "packMesh/core/poll.h"
#include "packMesh/mesh/predicates.h"

namespace packmesh {
namespace {

/// Flips per flat triangle: a flip next to a triangle that is not flat removes one; flips between flat ones
/// only shorten their longest sides, and take place where many corners lie on one line. Random triangulations
/// of 10^4 collinear corners need 20.
constexpr std::size_t flipsPerTriangle = 200;

std::uint64_t keyOf(int a, int b) {
  return std::uint64_t(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
}

/// Sides of all triangles, by directed edge.
class SideTable {
 public:
  explicit SideTable(const TriangleMesh& mesh) {
    triangleOf_.reserve(3 * mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add(mesh.triangles[t], static_cast<int>(t));
  }

  void add(const Triangle& t, int number) {
    for (int k = 0; k < 3; ++k) triangleOf_[keyOf(t[k], t[(k + 1) % 3])] = number;
  }
  void remove(const Triangle& t) {
    for (int k = 0; k < 3; ++k) triangleOf_.erase(keyOf(t[k], t[(k + 1) % 3]));
  }
  /// The triangle with an edge from a to b, -1 if there is none.
  int find(int a, int b) const {
    const auto found = triangleOf_.find(keyOf(a, b));
    return found == triangleOf_.end() ? -1 : found->second;
  }

 private:
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

/// Flips in rounds: each tries the triangles that are flat at its beginning, in ascending order. A triangle
/// is tried again only when something has changed that decides whether it can be flipped: it, a neighbour, or
/// the edge that would be created twice.
class Flattening {
 public:
  Flattening(TriangleMesh& mesh, double flatness, std::vector<int> flat)
      : mesh_(mesh), flatness_(flatness), sides_(mesh), listed_(mesh.triangles.size(), 0) {
    for (const int t : flat) {
      listed_[t] = 1;
      next_.insert(next_.end(), t);
      stuck_.insert(stuck_.end(), t);
    }
  }

  void operator()(std::size_t mostFlips) {
    while (flips_ < mostFlips && !stuck_.empty()) {
      const std::size_t before = flips_;
      round();
      relist();
      if (flips_ == before && !flipOfTwoFlat()) return;
    }
  }

 private:
  bool flat(int t) const { return isFlat(mesh_, t, flatness_); }

  void round() {
    now_ = std::exchange(next_, {});
    while (!now_.empty()) {
      current_ = *now_.begin();
      now_.erase(now_.begin());
      pollAt(steps_++);
      if (flat(current_)) flip(current_, false);
    }
    current_ = -1;
  }

  /// The first one for which that is possible. @return false if there is none
  bool flipOfTwoFlat() {
    while (!stuck_.empty()) {
      const int t = *stuck_.begin();
      pollAt(steps_++);
      if (flat(t) && flip(t, true)) return true;
      stuck_.erase(t);
    }
    return false;
  }

  /// Flips the longest side of a flat triangle t. @return false if that is not possible
  /// @param flatToo flip even if the triangle on the other side is flat
  bool flip(int t, bool flatToo) {
    const int k = middleCorner(mesh_, t);
    const Triangle given = mesh_.triangles[t];
    const int b = given[k], c = given[(k + 1) % 3], a = given[(k + 2) % 3];  // the side runs from c to a
    const int beyond = sides_.find(a, c);
    if (beyond < 0 || (!flatToo && flat(beyond))) return false;
    const Triangle other = mesh_.triangles[beyond];
    int d = -1;
    for (const int v : other)
      if (v != a && v != c) d = v;
    if (d == b) return false;
    if (sides_.find(b, d) >= 0 || sides_.find(d, b) >= 0) {
      waiting_[keyOf(std::min(b, d), std::max(b, d))].push_back(t);
      return false;
    }
    sides_.remove(given);
    sides_.remove(other);
    mesh_.triangles[t] = {a, b, d};
    mesh_.triangles[beyond] = {b, c, d};
    sides_.add(mesh_.triangles[t], t);
    sides_.add(mesh_.triangles[beyond], beyond);
    ++flips_;
    for (const int changed : {t, beyond}) {
      changed_.push_back(changed);
      tryAgain(changed);
      const Triangle corners = mesh_.triangles[changed];
      for (int e = 0; e < 3; ++e)
        if (const int neighbour = sides_.find(corners[(e + 1) % 3], corners[e]); neighbour >= 0)
          tryAgain(neighbour);
    }
    if (const auto found = waiting_.find(keyOf(std::min(a, c), std::max(a, c))); found != waiting_.end()) {
      for (const int blocked : std::exchange(found->second, {})) tryAgain(blocked);
    }
    return true;
  }

  void tryAgain(int t) {
    if (!flat(t)) return;
    stuck_.insert(t);
    (listed_[t] && t > current_ && current_ >= 0 ? now_ : next_).insert(t);
  }

  void relist() {
    for (const int t : std::exchange(changed_, {})) listed_[t] = flat(t);
  }

  TriangleMesh& mesh_;
  double flatness_;
  SideTable sides_;
  std::vector<char> listed_;  ///< flat at the beginning of the round
  std::set<int> now_, next_;  ///< to be tried in this round and in the next one
  std::set<int> stuck_;       ///< to be flipped next to a flat one if nothing else is possible
  std::vector<int> changed_;  ///< in this round
  std::unordered_map<std::uint64_t, std::vector<int>> waiting_;  ///< by the edge that prevents a flip
  int current_ = -1;  ///< the triangle that is being tried in a round
  std::size_t flips_ = 0, steps_ = 0;
};

std::vector<int> flatTriangles(const TriangleMesh& mesh, double flatness) {
  std::vector<int> flat;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    pollAt(t);
    if (isFlat(mesh, static_cast<int>(t), flatness)) flat.push_back(static_cast<int>(t));
  }
  return flat;
}

}  // namespace

std::size_t removeFlatTriangles(TriangleMesh& mesh, double flatness) {
  const std::vector<int> flat = flatTriangles(mesh, flatness);
  const std::size_t given = flat.size();
  if (given == 0 || given == mesh.triangles.size())
    return 0;  // with none that is not flat, flips are in vain
  Flattening(mesh, flatness, flat)(flipsPerTriangle * given);
  return given - std::min(given, flatTriangles(mesh, flatness).size());
}

}  // namespace packmesh
