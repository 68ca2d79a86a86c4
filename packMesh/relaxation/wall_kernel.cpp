// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/wall_kernel.h"

namespace packmesh {

WallKernel wallKernel(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernel_avx512::wall;
  if (set == InstructionSet::avx2) return kernel_avx2::wall;
#endif
  (void)set;
  return kernel_portable::wall;
}

}  // namespace packmesh
