// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Axis-aligned boxes, spheres, and cells of an unbounded grid as keys of hash tables.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "packMesh/core/vector.h"

namespace packmesh {

/// Axis-aligned box [lo, hi] in µm; empty until something is added.
struct Box {
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 hi = Vec3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vec3& p) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  void add(const Box& other) {
    lo = lo.cwiseMin(other.lo);
    hi = hi.cwiseMax(other.hi);
  }
  Box grownBy(double margin) const { return {lo.array() - margin, hi.array() + margin}; }
  bool empty() const { return (hi.array() < lo.array()).any(); }
  bool contains(const Vec3& p) const {
    return (p.array() >= lo.array()).all() && (p.array() <= hi.array()).all();
  }
  bool meets(const Box& other) const {
    return (lo.array() <= other.hi.array()).all() && (other.lo.array() <= hi.array()).all();
  }
  /// Squared distance from the box to a point [µm²]; 0 inside.
  double squaredDistance(const Vec3& p) const { return (p - p.cwiseMax(lo).cwiseMin(hi)).squaredNorm(); }
  /// The same to another box; 0 if they meet.
  double squaredDistance(const Box& other) const {
    return (lo - other.hi).cwiseMax(other.lo - hi).cwiseMax(0.0).squaredNorm();
  }
  Vec3 center() const { return 0.5 * (lo + hi); }
  Vec3 size() const { return hi - lo; }
  double volume() const { return empty() ? 0.0 : size().prod(); }
};

struct Sphere {
  Vec3 center;
  double radius;
};

using GridIndex = std::array<std::int64_t, 3>;

/// The cell with edges of these lengths that contains a point; one begins at the origin [µm].
inline GridIndex gridIndex(const Vec3& p, const Vec3& edge) {
  GridIndex cell;
  for (int k = 0; k < 3; ++k) cell[k] = std::int64_t(std::floor(p[k] / edge[k]));
  return cell;
}

constexpr std::int64_t keyRange = std::int64_t(1) << 21;

/// Different for cells within half of keyRange of the origin along each axis.
inline std::int64_t keyOf(const GridIndex& cell) {
  return (cell[2] * keyRange + cell[1]) * keyRange + cell[0];
}

/// The cell of a key without negative indices.
inline GridIndex cellOfKey(std::int64_t key) {
  return {key % keyRange, key / keyRange % keyRange, key / keyRange / keyRange};
}

}  // namespace packmesh
