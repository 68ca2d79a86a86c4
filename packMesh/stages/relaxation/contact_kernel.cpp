// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/relaxation/contact_kernel.h"

#include <cstdlib>
#include <cstring>
#include <initializer_list>

#include "packMesh/stages/relaxation/wall_kernel.h"

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

ContactKernel contactKernel(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernel_avx512::contact;
  if (set == InstructionSet::avx2) return kernel_avx2::contact;
#endif
  (void)set;
  return kernel_portable::contact;
}

WallKernel wallKernel(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernel_avx512::wall;
  if (set == InstructionSet::avx2) return kernel_avx2::wall;
#endif
  (void)set;
  return kernel_portable::wall;
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
