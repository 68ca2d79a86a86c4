// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Triangles whose distances from points are tested.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "packMesh/mesh/mesh_kernels.h"

namespace packmesh {

/// Triangles as candidates for the nearest ones of points, relative to the origin.
class TriangleCandidates {
 public:
  explicit TriangleCandidates(std::vector<TriangleFacts> facts) : facts_(std::move(facts)) {
    for (const TriangleFacts& t : facts_) {
      TriangleDisc disc{};
      for (int k = 0; k < 3; ++k) {
        disc.center[k] = (t.corner[0][k] + t.corner[1][k] + t.corner[2][k]) / 3.0f;
        disc.normal[k] = t.normal[k];
        along_[k].push_back(static_cast<float>(disc.center[k]));
      }
      for (const auto& corner : t.corner) {
        float squared = 0.0f, height = 0.0f;
        for (int k = 0; k < 3; ++k) {
          const float from = corner[k] - static_cast<float>(disc.center[k]);
          squared += from * from;
          height += from * t.normal[k];
        }
        disc.radius = std::fmax(disc.radius, 1.00001f * std::sqrt(squared));
        disc.half = std::fmax(disc.half, std::fabs(height) + 1e-5f);
      }
      triangles_.push_back(static_cast<int>(triangles_.size()));
      radii_.push_back(disc.radius);
      discs_.push_back(disc);
    }
    const std::size_t padded = (facts_.size() + 15) / 16 * 16;
    for (std::vector<float>& centers : along_) centers.resize(padded, 1e15f);
    radii_.resize(padded, 0.0f);
    scratch_.resize(padded);
  }

  void nearest(const TriangleKernels& kernels, const PointLanes& points, float (&squared)[16],
               float (&which)[16]) {
    constexpr float slack = 1e-4f;
    kernels.nearest(
        points,
        {along_[0].data(), along_[1].data(), along_[2].data(), radii_.data(), triangles_.data(),
         discs_.data(), static_cast<int>(facts_.size())},
        slack, scratch_.data(),
        [](void* facts, int candidate) -> const TriangleFacts& {
          return static_cast<const TriangleFacts*>(facts)[candidate];
        },
        facts_.data(), squared, which);
  }

 private:
  std::vector<TriangleFacts> facts_;
  std::vector<TriangleDisc> discs_;
  std::vector<float> along_[3], radii_, scratch_;
  std::vector<int> triangles_;
};

}  // namespace packmesh
