// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/geometry/signed_distances.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "packMesh/geometry/triangle_kernel.h"
#include "packMesh/tolerances.h"

namespace packmesh {
namespace {

constexpr int lanes = 16;

/// Points along the edge of a block that is searched together.
constexpr int blockEdge = 5;

/// A block with no more points than this has no parts that are worth a look of their own.
constexpr int smallBlock = 16;

/// With more triangles that can be nearest than this, a block is cut; with no more than that, its parts are not
/// worth a look of their own either.
constexpr int mostCandidates = 100, fewCandidates = 6;

/// Squared distances in floats err by less than this [µm].
constexpr float rounding = 1e-4f;

/// A block this many times its radius inside of the surface is not measured point by point.
constexpr double farInside = 4.0;

/// A triangle, seen from `middle`.
TriangleFacts factsOf(const ClosestPoint& surface, int triangle, const Vec3& middle) {
  const Vec3 corner[3] = {surface.corner(triangle, 0) - middle, surface.corner(triangle, 1) - middle,
                          surface.corner(triangle, 2) - middle};
  const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
  TriangleFacts facts;
  for (int e = 0; e < 3; ++e) {
    const Vec3 edge = corner[(e + 1) % 3] - corner[e], inward = normal.cross(edge);
    const double square = edge.squaredNorm();
    for (int k = 0; k < 3; ++k) {
      facts.corner[e][k] = static_cast<float>(corner[e][k]);
      facts.edge[e][k] = static_cast<float>(edge[k]);
      facts.inward[e][k] = static_cast<float>(inward[k]);
    }
    facts.perSquare[e] = square > 0.0 ? static_cast<float>(1.0 / square) : 0.0f;
    facts.normal[e] = static_cast<float>(normal[e]);
  }
  return facts;
}

/// Neighbouring points: first[k] ... first[k] + count[k] - 1 along each axis.
struct Block {
  int first[3], count[3];
  int points() const { return count[0] * count[1] * count[2]; }

  /// Its part `k` of two along `axis`.
  Block half(int axis, int k) const {
    Block part = *this;
    const int low = (count[axis] + 1) / 2;
    part.first[axis] += k * low;
    part.count[axis] = k == 0 ? low : count[axis] - low;
    return part;
  }
};

class Search {
 public:
  Search(const ClosestPoint& surface, const std::array<std::vector<double>, 3>& coordinates, bool rough,
         float* distances)
      : surface_(surface), coordinates_(coordinates), rough_(rough), distance_(distances) {
    slab_ = coordinates[0].size() * coordinates[1].size();
    nearest_.resize(slab_ * coordinates[2].size());
  }

  void operator()() {
    Block block;
    int n[3];
    for (int k = 0; k < 3; ++k) n[k] = static_cast<int>(coordinates_[k].size());
    for (block.first[2] = 0; block.first[2] < n[2]; block.first[2] += blockEdge)
      for (block.first[1] = 0; block.first[1] < n[1]; block.first[1] += blockEdge)
        for (block.first[0] = 0; block.first[0] < n[0]; block.first[0] += blockEdge) {
          for (int k = 0; k < 3; ++k) block.count[k] = std::min(blockEdge, n[k] - block.first[k]);
          search(block);
        }
    giveSigns();
  }

 private:
  static constexpr int inside = -1;  ///< in place of a nearest triangle: not measured, inside for sure

  std::size_t indexOf(int i, int j, int k) const { return i + coordinates_[0].size() * j + slab_ * k; }
  Vec3 position(int i, int j, int k) const {
    return {coordinates_[0][i], coordinates_[1][j], coordinates_[2][k]};
  }
  Box boxOf(const Block& b) const {
    return {position(b.first[0], b.first[1], b.first[2]),
            position(b.first[0] + b.count[0] - 1, b.first[1] + b.count[1] - 1, b.first[2] + b.count[2] - 1)};
  }
  template <class Visit>
  void forEach(const Block& b, Visit&& visit) const {
    for (int k = b.first[2]; k < b.first[2] + b.count[2]; ++k)
      for (int j = b.first[1]; j < b.first[1] + b.count[1]; ++j)
        for (int i = b.first[0]; i < b.first[0] + b.count[0]; ++i) visit(indexOf(i, j, k), position(i, j, k));
  }

  void search(const Block& block) {
    const Box box = boxOf(block);
    const Vec3 middle = box.center();
    const double radius = 0.5 * box.size().norm();
    const ClosestPoint::Nearest atMiddle = surface_.nearest(middle, hint_);
    hint_ = atMiddle.triangle;
    if (rough_ && farInside * radius <= atMiddle.distance && surface_.side(middle, atMiddle) < 0) {
      forEach(block, [&](std::size_t n, const Vec3& p) {
        distance_[n] = static_cast<float>(atMiddle.distance - (p - middle).norm());
        nearest_[n] = inside;
      });
      return;
    }
    if (block.points() == 1) {
      forEach(block, [&](std::size_t n, const Vec3&) {
        distance_[n] = static_cast<float>(atMiddle.distance);
        nearest_[n] = atMiddle.triangle;
      });
      return;
    }
    const double furthest = atMiddle.distance + 2.0 * radius + tolerance::culling;
    std::vector<int> near;
    surface_.forEachNear(middle, furthest, [&](int t) {
      if (surface_.onTriangle(t, middle).distance <= furthest) near.push_back(t);
      return static_cast<int>(near.size()) <= mostCandidates;
    });
    if (static_cast<int>(near.size()) > mostCandidates) {
      int axis = 0;
      box.size().maxCoeff(&axis);
      if (block.count[axis] == 1) axis = block.count[0] > 1 ? 0 : block.count[1] > 1 ? 1 : 2;
      for (int k = 0; k < 2; ++k) search(block.half(axis, k));
      return;
    }
    middle_ = middle;
    facts_.clear();
    for (const int t : near) facts_.push_back(factsOf(surface_, t, middle));
    compareParts(block, near);
  }

  /// Of the candidates of a block only some can be nearest in each of its parts.
  void compareParts(const Block& block, const std::vector<int>& triangles) {
    const int candidates = static_cast<int>(facts_.size());
    if (candidates <= fewCandidates || block.points() <= smallBlock) {
      chosen_.resize(candidates);
      std::iota(chosen_.begin(), chosen_.end(), 0);
      compare(block, triangles);
      return;
    }
    Block parts[8];
    PointLanes middles{};
    float radius[8], nearest[8];
    int count = 0;
    for (int p = 0; p < 8; ++p) {
      const Block part = block.half(0, p & 1).half(1, p >> 1 & 1).half(2, p >> 2);
      if (part.points() == 0) continue;
      const Box box = boxOf(part);
      setLane(middles, count, box.center());
      radius[count] = static_cast<float>(0.5 * box.size().norm());
      nearest[count] = 1e30f;
      parts[count++] = part;
    }
    toParts_.resize(lanes * candidates);
    kernels_.distances(middles, facts_.data(), candidates, toParts_.data());
    for (int c = 0; c < candidates; ++c)
      for (int p = 0; p < count; ++p) nearest[p] = std::min(nearest[p], toParts_[lanes * c + p]);
    for (int p = 0; p < count; ++p) {
      const float furthest = std::sqrt(nearest[p]) + 2.0f * radius[p] + rounding;
      chosen_.clear();
      for (int c = 0; c < candidates; ++c)
        if (toParts_[lanes * c + p] <= furthest * furthest) chosen_.push_back(c);
      compare(parts[p], triangles);
    }
  }

  void setLane(PointLanes& points, int lane, const Vec3& p) const {
    const Vec3 from = p - middle_;
    points.x[lane] = static_cast<float>(from.x());
    points.y[lane] = static_cast<float>(from.y());
    points.z[lane] = static_cast<float>(from.z());
  }

  void compare(const Block& block, const std::vector<int>& triangles) {
    std::size_t index[lanes];
    PointLanes points{};
    int used = 0;
    const auto compareLanes = [&] {
      float squared[lanes], nearest[lanes];
      kernels_.nearest(points, facts_.data(), chosen_.data(), static_cast<int>(chosen_.size()), squared, nearest);
      for (int lane = 0; lane < used; ++lane) {
        distance_[index[lane]] = std::sqrt(squared[lane]);
        nearest_[index[lane]] = triangles[chosen_[static_cast<int>(nearest[lane])]];
      }
      used = 0;
    };
    forEach(block, [&](std::size_t n, const Vec3& p) {
      setLane(points, used, p);
      index[used++] = n;
      if (used == lanes) compareLanes();
    });
    if (used > 0) compareLanes();
  }

  /// Between neighbours on different sides lies the surface: both together are no further from it than they
  /// are from each other.
  void giveSigns() {
    const int n[3] = {static_cast<int>(coordinates_[0].size()), static_cast<int>(coordinates_[1].size()),
                      static_cast<int>(coordinates_[2].size())};
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i) {
          const std::size_t here = indexOf(i, j, k);
          if (nearest_[here] == inside || isInside(here, i, j, k)) distance_[here] = -distance_[here];
        }
  }
  bool isInside(std::size_t here, int i, int j, int k) const {
    const int axis = i > 0 ? 0 : j > 0 ? 1 : 2, at = axis == 0 ? i : axis == 1 ? j : k;
    if (at > 0) {
      const std::size_t before = here - (axis == 0 ? 1 : axis == 1 ? coordinates_[0].size() : slab_);
      const double apart = coordinates_[axis][at] - coordinates_[axis][at - 1];
      if (std::abs(distance_[before]) + distance_[here] > apart + rounding)
        return std::signbit(distance_[before]);
    }
    const Vec3 p = position(i, j, k);
    return surface_.side(p, surface_.onTriangle(nearest_[here], p)) < 0;
  }

  const ClosestPoint& surface_;
  const std::array<std::vector<double>, 3>& coordinates_;
  bool rough_;
  float* distance_;  ///< without signs at first
  std::size_t slab_;
  std::vector<int> nearest_;
  int hint_ = -1;
  TriangleKernels kernels_ = triangleKernels(chosenInstructionSet());
  Vec3 middle_;                       ///< what candidates are seen from
  std::vector<TriangleFacts> facts_;  ///< of the candidates
  std::vector<int> chosen_;           ///< among them
  std::vector<float> toParts_;        ///< their squared distances from the middles of parts
};

}  // namespace

void signedDistances(const ClosestPoint& surface, const std::array<std::vector<double>, 3>& coordinates,
                     bool rough, float* distances) {
  Search(surface, coordinates, rough, distances)();
}

}  // namespace packmesh
