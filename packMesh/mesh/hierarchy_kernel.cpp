// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/hierarchy_kernel.h"

namespace packmesh {

PairSearch* pairSearch(InstructionSet set) {
#if defined(__x86_64__)
  if (set == InstructionSet::avx512) return kernel_avx512::searchPairs;
  if (set == InstructionSet::avx2) return kernel_avx2::searchPairs;
#endif
  (void)set;
  return kernel_portable::searchPairs;
}

}  // namespace packmesh
