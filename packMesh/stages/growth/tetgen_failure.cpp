// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/growth/tetgen_failure.h"

class tetgenmesh;

/// TetGen 1.5 calls this where it gives up. Its own version, a weak symbol of the shared library, frees the
/// mesh and throws an int, whereupon the mesh's destructor frees it again and the process dies. This one
/// takes its place and leaves the freeing to the destructor.
void terminatetetgen(tetgenmesh*, int code) {
  throw packmesh::TetgenGaveUp{code};
}

bool packmesh::tetgenThrows() {
  return true;
}
