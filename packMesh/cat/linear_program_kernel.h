// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The dual simplex algorithm for seven variables.
///
/// A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include "packMesh/simd/instruction_set.h"

namespace packmesh {

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
