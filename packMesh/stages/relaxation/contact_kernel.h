// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The innermost loop: how deep do the sample points of one cell reach into the surface of another.
///
/// The same source (contact_kernel_body.h) is compiled for the baseline, AVX2 and AVX-512 instruction sets
/// and chosen at run time. All work in lanes of 16 floats with IEEE operations only (no contraction, sums in
/// lane order), so that the three give the same bits. This header must not pull in templates of other
/// libraries: what they instantiate in an AVX-512 object could be linked into the baseline.
#pragma once

#include <cstdint>

#include "packMesh/instruction_set.h"

namespace packmesh {

/// The surface of a cell as the kernel sees it, in its body frame.
struct FieldView {
  bool onGrid;
  // Closed form y² = P(a x² + c z²) (ProfileSurface).
  float p[6], a, c;
  float bend;  ///< beyond the rim P(s) = P'(1) (s - 1) + bend (s - 1)² [µm²]
  // Sampled distance (DistanceGrid).
  const float* value;
  float origin[3], nodesPerLength;
  int nodes[3];
  // Disc + ellipsoid bound (SupportBound) and half extents: what lies outside of them is apart.
  float ring, thickness, extent[3];
};

/// Sample points of a cell (SamplePoints).
struct SampleView {
  int clusters;
  int clustersPerBit;  ///< of a ClusterMask
  const float *x, *y, *z;
  const float *centerX, *centerY, *centerZ, *radius;
};

/// A set of clusters: bit k stands for the clusters k * clustersPerBit and following.
using ClusterMask = std::uint64_t;
constexpr ClusterMask allClusters = ~ClusterMask{0};

/// Map from the sampled cell's body frame to the other's: x -> m x + t; `scale` is the factor of m.
struct RelativeFrame {
  float m[9], t[3], scale;
};

/// Sums over the points nearer than the clearance, weighted by how much nearer they are; in the other's
/// frame.
struct ContactSums {
  float weight;     ///< sum of penetrations
  float point[3];   ///< sum of penetration * point
  float normal[3];  ///< sum of penetration * unit outward normal
  float deepest;    ///< largest penetration into the clearance
  float nearest;    ///< no sample point is nearer to the surface than this (negative: inside)
};

/// Looks at the clusters in `mask`. When these are all, `mask` becomes the set of those with a point nearer
/// than clearance + margin: as long as the two have not moved by more than the margin, no others can touch.
using ContactKernel = void (*)(const SampleView&, const RelativeFrame&, const FieldView&, float clearance,
                               float margin, ClusterMask& mask, ContactSums&);

namespace kernel_portable {
void contact(const SampleView&, const RelativeFrame&, const FieldView&, float clearance, float margin,
             ClusterMask& mask, ContactSums&);
}
namespace kernel_avx2 {
void contact(const SampleView&, const RelativeFrame&, const FieldView&, float clearance, float margin,
             ClusterMask& mask, ContactSums&);
}
namespace kernel_avx512 {
void contact(const SampleView&, const RelativeFrame&, const FieldView&, float clearance, float margin,
             ClusterMask& mask, ContactSums&);
}

/// The kernel for an instruction set. Pre: available(set).
ContactKernel contactKernel(InstructionSet set);

}  // namespace packmesh
