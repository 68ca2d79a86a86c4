// SPDX-License-Identifier: AGPL-3.0-or-later
#define PACKMESH_KERNEL_NAMESPACE kernel_portable
#include "packMesh/relaxation/wall_kernel_body.h"
