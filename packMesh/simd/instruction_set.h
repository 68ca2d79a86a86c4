// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which vector instructions there are.
///
/// Kernels, the innermost loops (*_kernel.cpp, in lanes of 16 floats, see lanes.h), are compiled once for
/// each instruction set, PACKMESH_INSTRUCTION_SET, and chosen at run time. All work with IEEE operations only
/// (no contraction, sums in lane order), so that all give the same bits. What they define has internal
/// linkage, and their headers must not pull in templates of other libraries: what these instantiate in an
/// AVX-512 object could be linked into the baseline.
#pragma once

#include <type_traits>

namespace packmesh {

enum class InstructionSet { portable, avx2, avx512 };

/// Whether this processor has it.
bool available(InstructionSet set);

/// The best instruction set available, unless the environment variable PACKMESH_ISA (portable, avx2, avx512)
/// asks for another one that is.
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
