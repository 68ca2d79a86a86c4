// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/simd/instruction_set.h"

#include <cstdlib>
#include <cstring>
#include <initializer_list>

namespace packmesh {

bool available(InstructionSet set) {
#if defined(__x86_64__)
  __builtin_cpu_init();
  switch (set) {
    case InstructionSet::portable:
      return true;
    case InstructionSet::avx2:
      return __builtin_cpu_supports("avx2");
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
  }
#endif
  return set == InstructionSet::portable;
}

InstructionSet chosenInstructionSet() {
  const char* names[] = {"portable", "avx2", "avx512"};
  if (const char* asked = std::getenv("PACKMESH_ISA"))
    for (int k = 0; k < 3; ++k)
      if (std::strcmp(asked, names[k]) == 0 && available(static_cast<InstructionSet>(k)))
        return static_cast<InstructionSet>(k);
  for (InstructionSet set : {InstructionSet::avx512, InstructionSet::avx2})
    if (available(set)) return set;
  return InstructionSet::portable;
}

}  // namespace packmesh
