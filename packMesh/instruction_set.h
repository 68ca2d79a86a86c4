// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which instructions this processor has: kernels are compiled for several sets and chosen at run time.
#pragma once

namespace packmesh {

enum class InstructionSet { portable, avx2, avx512 };

/// Whether this processor has it.
bool available(InstructionSet set);

/// The best instruction set available, unless the environment variable PACKMESH_ISA (portable, avx2, avx512)
/// asks for another one that is.
InstructionSet chosenInstructionSet();

}  // namespace packmesh
