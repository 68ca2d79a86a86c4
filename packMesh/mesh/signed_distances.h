// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signed distances to a surface for many points at once.
#pragma once

#include <array>
#include <vector>

#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/triangle_kernel.h"

namespace packmesh {

/// A mesh for which distances are computed in blocks of points. Immutable.
class SignedDistances {
 public:
  /// @param mesh closed and oriented outwards
  explicit SignedDistances(const TriangleMesh& mesh);

  /// Signed distances (positive outside, µm) at the points (x[i], y[j], z[k]), `x` fastest, exact up to
  /// rounding to float. Neighbouring points share the search for candidate triangles, so they should be
  /// nearer to each other than to most of the surface. Pre: coordinates ascend (equal ones are permitted).
  /// @param rough points that are further from the surface than twice their spacing get a lower bound of the
  /// distance, one hundredth less at most; inside, several times the spacing away, at least three fifths of
  /// it
  void sample(const std::array<std::vector<double>, 3>& coordinates, bool rough, float* distances) const;

  const ClosestPoint& surface() const { return surface_; }

 private:
  class Search;

  ClosestPoint surface_;
  std::vector<TriangleFacts> facts_;  ///< of all triangles; the corners are set during a search
  TriangleKernels kernels_;
};

}  // namespace packmesh
