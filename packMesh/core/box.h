// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Axis-aligned boxes.
#pragma once

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
  Vec3 center() const { return 0.5 * (lo + hi); }
  Vec3 size() const { return hi - lo; }
  double volume() const { return empty() ? 0.0 : size().prod(); }
};

}  // namespace packmesh
