// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Elastic forces and steps of sixteen cells of one template at a time.
///
/// A kernel: see packMesh/simd/instruction_set.h. Numbers of a batch stand by vertex, then by component, then
/// by cell.
#pragma once

#include "packMesh/simd/instruction_set.h"
#include "packMesh/soft/membrane_view.h"

namespace packmesh {

struct MembraneBatch {
  static constexpr int cells = 16;
  float* position;      ///< 3 per vertex [µm]
  const float* listed;  ///< 3 per vertex: positions for which contacts were listed [µm]
  float* step;          ///< 3 per vertex: the last one [µm]
  float* force;         ///< 4 per vertex: force of contacts [pN], their stiffness [pN/µm]; changed
  const float* gap;     ///< 1 per vertex: no nearer is what it could meet [µm]
  float* scratch;       ///< MembraneView::scratch
  const float* scale;   ///< per cell
  const float* moves;   ///< per cell: 1, or 0 for those that rest
  // Results, per cell
  float* volume;        ///< [µm³]
  float* largestForce;  ///< on a vertex [pN]
  float* farthest;      ///< from `listed` [µm]
};

struct StepSettings {
  float momentum;          ///< share of the last step that is added
  float shareOfGap, most;  ///< largest step: as a share of the gap, and [µm]
  float stiffness;         ///< of links, for a scale of 1 [pN/µm]
};

using MembraneKernel = void (*)(const MembraneView&, const MembraneBatch&, const StepSettings&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
MembraneKernel membraneKernel();
inline MembraneKernel membraneKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return membraneKernel<constant.value>(); });
}

}  // namespace packmesh
