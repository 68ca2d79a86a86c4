// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/contact_kernel.h"

namespace packmesh {

ContactKernel contactKernel(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernel_avx512::contact;
  if (set == InstructionSet::avx2) return kernel_avx2::contact;
#endif
  (void)set;
  return kernel_portable::contact;
}

}  // namespace packmesh
