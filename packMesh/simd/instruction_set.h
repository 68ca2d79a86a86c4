// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Instruction sets and their selection at run time.
///
/// Kernels, the innermost loops (*_kernel.cpp, in lanes of 16 floats, see lanes.h), are compiled once per
/// instruction set (PACKMESH_INSTRUCTION_SET) and selected at run time. All versions give the same bits: they
/// use IEEE operations only (no contraction, sums in lane order). Kernels have internal linkage, and their
/// headers must not instantiate templates of other libraries: the linker might use such an instance from an
/// AVX-512 object in baseline code.
#pragma once

#include <type_traits>

namespace packmesh {

enum class InstructionSet { portable, avx2, avx512 };

/// True if this processor supports `set`.
bool available(InstructionSet set);

/// The best available instruction set, or the one named by the environment variable PACKMESH_ISA (portable,
/// avx2, avx512) if it is available.
InstructionSet chosenInstructionSet();

/// Calls `choose` with a constant (std::integral_constant) of value `set`. Pre: available(set).
template <class Choose>
auto forInstructionSet(InstructionSet set, Choose choose) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512)
    return choose(std::integral_constant<InstructionSet, InstructionSet::avx512>());
  if (set == InstructionSet::avx2)
    return choose(std::integral_constant<InstructionSet, InstructionSet::avx2>());
#endif
  (void)set;
  return choose(std::integral_constant<InstructionSet, InstructionSet::portable>());
}

}  // namespace packmesh
