// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Vessels in which cells get stuck.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "packMesh/container/vessel.h"
#include "tests/packMesh/sample_meshes.h"

namespace packmesh::test {

/// Two chambers of radius 6 µm around x = -7 and 7 µm, joined by a tube of radius 0.8 µm that no red cell can
/// pass.
inline std::shared_ptr<const Container> twoChambers() {
  constexpr double neck = 0.8, chamber = 6.0, middle = 7.0, end = 12.5;
  const auto radius = [=](double x) {
    const double from = std::abs(x) - middle;
    return std::max(neck, std::sqrt(std::max(0.0, chamber * chamber - from * from)));
  };
  const TriangleMesh mesh = sample::tube(
      -end, end, 81, 32, [](double) { return Vec3::Zero(); }, radius);
  return makeVessel(mesh, {}, 0.25);
}

}  // namespace packmesh::test
