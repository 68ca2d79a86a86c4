// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes of a cell as rows of a linear programme.
///
/// A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// How far a step can move vertices along normals.
struct StepReach {
  float scale;        ///< of the cell now
  float largest;      ///< scale after the step
  float padding;      ///< to be kept from planes [µm]
  float translation;  ///< along each axis [µm]
  float rotation;     ///< about each axis, times the factor of its second order [rad]
  float margin;       ///< beyond the padding within which planes matter [µm]
};

/// Copies the planes that a step could reach from columns as in CellPlanes to others, in which the distance
/// becomes the limit: the distance without padding, or where the vertex is nearer its present one.
/// @param room least distance of any vertex from its limit if the cell only grows to the largest scale [µm];
/// 1e30 without planes
/// @return their number; there must be room for 16 more
using ReachedPlanes = int (*)(const float* const planes[7], int count, const StepReach&, float* const out[7],
                              float& room);

/// Rows of unit length in the columns and right-hand sides of LinearProgramView for the planes found by
/// ReachedPlanes, linearised around a rotation (rows first). The variables are the scale, or at the barrier
/// the margin, rotation and translation. There must be room for 16 more.
/// @param scale of the cell in the linearisation
using RowsOfPlanes = void (*)(const float* const planes[7], int count, const float rotation[9], float scale,
                              bool atBarrier, double* const out[8]);

struct GrowthRowKernel {
  ReachedPlanes reached;
  RowsOfPlanes rows;
};

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
GrowthRowKernel growthRowKernel();
inline GrowthRowKernel growthRowKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return growthRowKernel<constant.value>(); });
}

}  // namespace packmesh
