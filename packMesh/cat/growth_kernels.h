// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The innermost loops of growth.
///
/// Kernels: see packMesh/simd/instruction_set.h.
#pragma once

#include <cstdint>

#include "packMesh/shape/field_view.h"
#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// The two cells of a pair. Lengths in units of the surface's body frame, if not said otherwise.
struct ChordFrame {
  RelativeFrame toSurface;       ///< from the body frame of the sampled cell to that of the surface
  float sampled[9], surface[9];  ///< rotations of the two cells, rows first
  float limit;                   ///< longest chord
  float scale;                   ///< of the cell with the surface
  float shortChord;              ///< shorter ones take their direction from the gradient of the distance
  float share;                   ///< of the gap, for the sampled cell
  float offset;                  ///< by which the plane is moved away from the sampled cell [µm]
};

/// Where the planes of the two cells are written, in the columns of CellPlanes; nullptr: not wanted.
struct ChordPlanesOut {
  float* const* sampled;
  float* const* surface;
};

/// @param distinct for each cluster, which of its points are not repetitions of others, as bits
/// @return the number of chords; there must be room for all points and 16 more
using ChordKernel = int (*)(const SampleView&, const std::uint16_t* distinct, const ChordFrame&,
                            const FieldView&, const ChordPlanesOut&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
ChordKernel chordKernel();
inline ChordKernel chordKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return chordKernel<constant.value>(); });
}

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

/// A programme as LinearProgram has it.
struct LinearProgramView {
  static constexpr int size = 7;  ///< variables
  /// There is a multiple of this many rows; those added to fill up are 0 · x <= a large number.
  static constexpr int rowsAtOnce = 16;

  const double* column[size];  ///< of rows of unit length
  const double* rhs;
  int rows;
  double objective[size], lower[size], upper[size];
};

enum class LinearProgramStatus {
  optimal,
  infeasible,
  unsolved,  ///< rounding errors: some inequality is violated by more than the tolerance
};

struct LinearProgramResult {
  LinearProgramStatus status = LinearProgramStatus::unsolved;
  double x[LinearProgramView::size] = {};
  int pivots = 0;
};

/// @param tolerance accuracy for variables and normalised rows of order 1
using LinearProgramKernel = void (*)(const LinearProgramView&, double tolerance, LinearProgramResult&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
LinearProgramKernel linearProgramKernel();
inline LinearProgramKernel linearProgramKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return linearProgramKernel<constant.value>(); });
}

}  // namespace packmesh
