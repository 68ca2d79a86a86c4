// SPDX-License-Identifier: AGPL-3.0-or-later
#define PACKMESH_KERNEL_NAMESPACE kernel_avx2
#include "packMesh/relaxation/wall_kernel_body.h"
