// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which vector instructions there are.
///
/// Kernels, the innermost loops, are compiled once for each instruction set from the same source
/// (*_kernel_body.h, in lanes of 16 floats, see lanes.h) and chosen at run time. All work with IEEE
/// operations only (no contraction, sums in lane order), so that all give the same bits. Headers of kernels
/// must not pull in templates of other libraries: what they instantiate in an AVX-512 object could be linked
/// into the baseline.
#pragma once

namespace packmesh {

enum class InstructionSet { portable, avx2, avx512 };

/// Whether this processor has it.
bool available(InstructionSet set);

/// The best instruction set available, unless the environment variable PACKMESH_ISA (portable, avx2, avx512)
/// asks for another one that is.
InstructionSet chosenInstructionSet();

}  // namespace packmesh
