// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The innermost loop: how deep the sample points of one cell penetrate the surface of another.
///
/// A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include <cstdint>

#include "packMesh/shape/field_view.h"
#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// A set of clusters: bit k represents the 2^bitShift clusters starting at k * 2^bitShift.
using ClusterMask = std::uint64_t;
constexpr ClusterMask allClusters = ~ClusterMask{0};

/// Sums over the points nearer than the clearance, weighted by how much nearer they are; in the other's
/// frame.
struct ContactSums {
  float weight;         ///< sum of penetrations
  float point[3];       ///< sum of penetration * point
  float normal[3];      ///< sum of penetration * outward gradient of a function that vanishes on the surface
  float gradient;       ///< sum of penetration * length of that gradient
  float deepest;        ///< largest penetration into the clearance
  ClusterMask touched;  ///< clusters with a point nearer than the clearance
  float nearest;        ///< no sample point is nearer to the surface than this (negative: inside)
};

/// Examines the clusters in `mask`. If `mask` contains all of them, it is set to those with a point nearer
/// than clearance + margin: as long as the two have not moved by more than the margin, no others can touch.
using ContactKernel = void (*)(const SampleView&, const RelativeFrame&, const FieldView&, float clearance,
                               float margin, ClusterMask& mask, ContactSums&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
ContactKernel contactKernel();
inline ContactKernel contactKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return contactKernel<constant.value>(); });
}

}  // namespace packmesh
