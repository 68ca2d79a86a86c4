// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_kernel.h"

namespace packmesh {

TriangleKernels triangleKernels(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernel_avx512::triangleKernels();
  if (set == InstructionSet::avx2) return kernel_avx2::triangleKernels();
#endif
  (void)set;
  return kernel_portable::triangleKernels();
}

}  // namespace packmesh
