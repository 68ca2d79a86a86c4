// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/tetgen_call.h"

#include <cstdio>
#include <cstdlib>

class tetgenmesh;

namespace {

thread_local bool inTetgen = false;

}  // namespace

/// TetGen 1.5 calls this when it gives up. Its own version, a weak symbol of the shared library, frees the
/// mesh and throws an int, whereupon the mesh's destructor frees it again and the process crashes. This
/// replacement leaves the freeing to the destructor.
void terminatetetgen(tetgenmesh*, int code) {
  throw packmesh::TetgenGaveUp{code};
}

/// Called by the C library's assert(). Distributions compile TetGen with its assertions, some of which fail
/// on input that is valid but has symmetries, such as concentric objects: in TetGen this gives up like
/// terminatetetgen(); everywhere else it does what the C library does.
// NOLINTNEXTLINE(bugprone-reserved-identifier,readability-identifier-naming): the name is the C library's
extern "C" [[noreturn]] void __assert_fail(const char* assertion, const char* file, unsigned line,
                                           const char* function) {
  if (inTetgen) throw packmesh::TetgenGaveUp{packmesh::TetgenGaveUp::assertion};
  std::fprintf(stderr, "%s:%u: %s: Assertion `%s' failed.\n", file, line, function, assertion);
  std::abort();
}

packmesh::TetgenCall::TetgenCall() {
  inTetgen = true;
}
packmesh::TetgenCall::~TetgenCall() {
  inTetgen = false;
}
