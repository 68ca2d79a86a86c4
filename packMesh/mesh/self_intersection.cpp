// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/self_intersection.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "packMesh/core/poll.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/predicates.h"
#include "packMesh/mesh/triangle_pair.h"

namespace packmesh {

bool meetBeyondShared(const std::vector<Vec3>& v, Triangle a, Triangle b) {
  // Move the shared vertices to the front of both.
  int shared = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = shared; j < 3; ++j)
      if (a[i] == b[j]) {
        std::swap(a[i], a[shared]);
        std::swap(b[j], b[shared]);
        ++shared;
        break;
      }
  const Vec3 &a0 = v[a[0]], &a1 = v[a[1]], &a2 = v[a[2]], &b0 = v[b[0]], &b1 = v[b[1]], &b2 = v[b[2]];
  switch (shared) {
    case 0:
      return trianglesMeet(a0, a1, a2, b0, b1, b2);
    case 1:
      // The intersection is convex and contains the vertex; if it contains more, it leaves one triangle
      // through the opposite edge while still inside the other triangle.
      return segmentMeetsTriangle(a1, a2, b0, b1, b2) || segmentMeetsTriangle(b1, b2, a0, a1, a2);
    case 2: {
      if (sideOfPlane(a0, a1, a2, b2) != 0) return false;
      const int drop = axisShowing(a0, a1, a2);
      return turnSeen(drop, a0, a1, a2) == turnSeen(drop, a0, a1, b2);  // folded onto each other
    }
    default:
      return true;
  }
}

std::optional<TrianglePair> findSelfIntersection(const TriangleMesh& mesh) {
  std::optional<TrianglePair> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int n = static_cast<int>(t);
    pollAt(t);
    if (axisShowing(mesh.corner(n, 0), mesh.corner(n, 1), mesh.corner(n, 2)) < 0) return TrianglePair(n, n);
  }
  std::size_t pairs = 0;
  TriangleTree(mesh).forEachPair(mesh, [&](int s, int t) {
    pollAt(pairs++);
    if (meetBeyondShared(mesh.vertices, mesh.triangles[s], mesh.triangles[t])) found = std::minmax(s, t);
    return !found;
  });
  return found;
}

namespace {

constexpr int blockSize = SelfIntersectionFinder::blockSize;
constexpr float infinite = std::numeric_limits<float>::infinity();

/// Products of three lengths of which not more than this part is left may have a wrong sign: they have some
/// tens of roundings.
constexpr double uncertain = 1e-12;

/// A box that contains a triangle or several, in floats.
struct RoughBox {
  float lo[3] = {infinite, infinite, infinite}, hi[3] = {-infinite, -infinite, -infinite};

  void add(const RoughBox& other) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], other.lo[k]);
      hi[k] = std::max(hi[k], other.hi[k]);
    }
  }
  bool meets(const RoughBox& other) const {
    bool all = true;
    for (int k = 0; k < 3; ++k) all = all & (lo[k] <= other.hi[k]) & (other.lo[k] <= hi[k]);
    return all;
  }
};

/// Makes boxes of triangles in coordinates around the first vertex.
class Rounding {
 public:
  explicit Rounding(const std::vector<Vec3>& vertices)
      : origin_(vertices.empty() ? Vec3(Vec3::Zero()) : vertices.front()) {
    double largest = 0.0;
    for (const Vec3& v : vertices) largest = std::max(largest, (v - origin_).cwiseAbs().maxCoeff());
    margin_ = float(2e-7 * largest);  // three roundings to float
  }

  RoughBox box(const Vec3& a, const Vec3& b, const Vec3& c) const {
    RoughBox box;
    for (int k = 0; k < 3; ++k) {
      const float x = float(a[k] - origin_[k]), y = float(b[k] - origin_[k]), z = float(c[k] - origin_[k]);
      box.lo[k] = std::min({x, y, z}) - margin_;
      box.hi[k] = std::max({x, y, z}) + margin_;
    }
    return box;
  }

 private:
  Vec3 origin_;
  float margin_;
};

/// The boxes of the triangles of a block, beside each other.
struct BlockBoxes {
  float lo[3][blockSize], hi[3][blockSize];

  void set(int lane, const RoughBox& box) {
    for (int k = 0; k < 3; ++k) {
      lo[k][lane] = box.lo[k];
      hi[k][lane] = box.hi[k];
    }
  }
  /// 1 for those that meet a box, in a loop that the compiler does in lanes.
  void meet(const RoughBox& box, std::uint8_t (&found)[blockSize]) const {
    for (int lane = 0; lane < blockSize; ++lane)
      found[lane] = (lo[0][lane] <= box.hi[0]) & (box.lo[0] <= hi[0][lane]) & (lo[1][lane] <= box.hi[1]) &
                    (box.lo[1] <= hi[1][lane]) & (lo[2][lane] <= box.hi[2]) & (box.lo[2] <= hi[2][lane]);
  }
};

}  // namespace

SelfIntersectionFinder::SelfIntersectionFinder(const TriangleMesh& mesh)
    : triangles_(mesh.triangles), order_(mesh.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  std::vector<Vec3> middle;
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    middle.push_back((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0);
  sortIntoBlocks(0, int(order_.size()), middle);
  findFans(mesh.vertices.size());
  findNeighbours();
}

/// Divides triangles again and again along their longest extent, so that those of a block are near each
/// other.
void SelfIntersectionFinder::sortIntoBlocks(int first, int count, const std::vector<Vec3>& middle) {
  if (count <= blockSize) return;
  const auto begin = order_.begin() + first;
  Box box;
  std::for_each(begin, begin + count, [&](int t) { box.add(middle[t]); });
  int axis = 0;
  box.size().maxCoeff(&axis);
  const int half = (count / 2 + blockSize - 1) / blockSize * blockSize;
  std::nth_element(begin, begin + half, begin + count, [&](int s, int t) {
    return middle[s][axis] != middle[t][axis] ? middle[s][axis] < middle[t][axis] : s < t;
  });
  sortIntoBlocks(first, half, middle);
  sortIntoBlocks(first + half, count - half, middle);
}

void SelfIntersectionFinder::findFans(std::size_t vertices) {
  std::vector<std::vector<int>> around(vertices);
  for (std::size_t t = 0; t < triangles_.size(); ++t)
    for (const int v : triangles_[t]) around[v].push_back(int(t));
  for (std::size_t v = 0; v < vertices; ++v) {
    std::vector<int>& fan = around[v];
    // The two other corners of a triangle, in its sense.
    const auto others = [&](int t) {
      const Triangle& c = triangles_[t];
      const int k = c[0] == int(v) ? 0 : c[1] == int(v) ? 1 : 2;
      return std::pair(c[(k + 1) % 3], c[(k + 2) % 3]);
    };
    bool ring = fan.size() > 2;
    for (std::size_t i = 0; ring && i + 1 < fan.size(); ++i) {
      const auto next = std::find_if(fan.begin() + std::ptrdiff_t(i) + 1, fan.end(),
                                     [&](int t) { return others(t).first == others(fan[i]).second; });
      ring = next != fan.end();
      if (ring) std::iter_swap(fan.begin() + std::ptrdiff_t(i) + 1, next);
    }
    ring = ring && others(fan.back()).second == others(fan.front()).first;
    const int begin = int(fanTriangles_.size());
    for (const int t : fan) {
      fanTriangles_.push_back(t);
      ring_.push_back(others(t).first);
    }
    fans_.push_back({begin, int(fanTriangles_.size()), ring});
  }
}

/// Which triangles of each block have a vertex in common with a triangle.
void SelfIntersectionFinder::findNeighbours() {
  std::vector<int> placeOf(order_.size());
  for (std::size_t k = 0; k < order_.size(); ++k) placeOf[order_[k]] = int(k);
  firstNeighbours_.push_back(0);
  for (const int t : order_) {
    std::vector<int> near;
    for (const int v : triangles_[t])
      for (int i = fans_[v].begin; i < fans_[v].end; ++i) near.push_back(placeOf[fanTriangles_[i]]);
    std::sort(near.begin(), near.end());
    for (const int k : near) {
      if (int(neighbours_.size()) == firstNeighbours_.back() || neighbours_.back().block != k / blockSize)
        neighbours_.push_back({k / blockSize, {}});
      neighbours_.back().has[k % blockSize] = 1;
    }
    firstNeighbours_.push_back(int(neighbours_.size()));
  }
}

std::optional<TrianglePair> SelfIntersectionFinder::operator()(const std::vector<Vec3>& vertices) const {
  for (std::size_t v = 0; v < fans_.size(); ++v)
    if (!isFlatEnough(fans_[v], int(v), vertices))
      if (auto found = inFan(fans_[v], vertices)) return found;
  return apart(vertices);
}

/// Whether the triangles around a vertex certainly have only it, and the edges between successive ones, in
/// common: seen along the sum of their normals each turns to the left, and all of them together turn once.
bool SelfIntersectionFinder::isFlatEnough(const Fan& fan, int vertex,
                                          const std::vector<Vec3>& vertices) const {
  if (!fan.ring) return false;
  const Vec3 apex = vertices[vertex];
  const auto edge = [&](int i) -> Vec3 { return vertices[ring_[i]] - apex; };
  Vec3 axis = Vec3::Zero();
  const Vec3 first = edge(fan.begin);
  Vec3 before = first;
  double longest = before.squaredNorm();
  for (int i = fan.begin + 1; i < fan.end; ++i) {
    const Vec3 next = edge(i);
    axis += before.cross(next);
    longest = std::max(longest, next.squaredNorm());
    before = next;
  }
  axis += before.cross(first);
  const double least = uncertain * axis.cwiseAbs().sum() * longest;
  // Half a turn begins where the edges pass a direction between the first two of them.
  const Vec3 across = axis.cross(first + edge(fan.begin + 1));
  bool left = false;  // of that direction
  int begun = 0;
  before = first;
  for (int i = fan.begin + 1; i <= fan.end; ++i) {
    const Vec3 next = i < fan.end ? edge(i) : first;
    if (!(axis.dot(before.cross(next)) > least)) return false;
    const double side = across.dot(next);
    if (!(std::abs(side) > 2.0 * least)) return false;
    begun += side > 0.0 && !left;
    left = side > 0.0;
    before = next;
  }
  return begun == 1 && !left;
}

std::optional<TrianglePair> SelfIntersectionFinder::inFan(const Fan& fan,
                                                          const std::vector<Vec3>& vertices) const {
  for (int i = fan.begin; i < fan.end; ++i) {
    const Triangle& t = triangles_[fanTriangles_[i]];
    if (axisShowing(vertices[t[0]], vertices[t[1]], vertices[t[2]]) < 0)
      return TrianglePair(fanTriangles_[i], fanTriangles_[i]);
  }
  for (int i = fan.begin; i < fan.end; ++i)
    for (int j = i + 1; j < fan.end; ++j)
      if (meetBeyondShared(vertices, triangles_[fanTriangles_[i]], triangles_[fanTriangles_[j]]))
        return std::minmax(fanTriangles_[i], fanTriangles_[j]);
  return {};
}

/// Two triangles without a common vertex that meet.
std::optional<TrianglePair> SelfIntersectionFinder::apart(const std::vector<Vec3>& vertices) const {
  const int count = int(order_.size()), blocks = (count + blockSize - 1) / blockSize;
  std::vector<RoughBox> boxes(count), around(blocks);
  std::vector<BlockBoxes> beside(blocks);
  const Rounding rounding(vertices);
  for (int k = 0; k < blocks * blockSize; ++k) {
    RoughBox box;
    if (k < count) {
      const Triangle& t = triangles_[order_[k]];
      box = boxes[k] = rounding.box(vertices[t[0]], vertices[t[1]], vertices[t[2]]);
    }
    around[k / blockSize].add(box);
    beside[k / blockSize].set(k % blockSize, box);
  }
  for (int j = 0; j < blocks; ++j)
    for (int i = 0; i <= j; ++i) {
      if (!around[i].meets(around[j])) continue;
      for (int k = blockSize * i; k < std::min(blockSize * (i + 1), count); ++k) {
        if (i < j && !boxes[k].meets(around[j])) continue;
        std::uint8_t found[blockSize];
        beside[j].meet(boxes[k], found);
        if (!leaveOutNeighbours(k, j, found)) continue;
        for (int lane = 0; lane < blockSize; ++lane) {
          if (!found[lane] || blockSize * j + lane < k) continue;
          const int s = order_[k], t = order_[blockSize * j + lane];
          if (meetBeyondShared(vertices, triangles_[s], triangles_[t])) return std::minmax(s, t);
        }
      }
    }
  return {};
}

/// @return whether any are left
bool SelfIntersectionFinder::leaveOutNeighbours(int place, int block,
                                                std::uint8_t (&found)[blockSize]) const {
  for (int n = firstNeighbours_[place]; n < firstNeighbours_[place + 1]; ++n)
    if (neighbours_[n].block == block)
      for (int lane = 0; lane < blockSize; ++lane) found[lane] &= std::uint8_t(1 - neighbours_[n].has[lane]);
  std::uint8_t any = 0;
  for (const std::uint8_t one : found) any |= one;
  return any != 0;
}

}  // namespace packmesh
