// SPDX-License-Identifier: AGPL-3.0-or-later
#include "tests/support/catch_session.h"

int main(int argc, char** argv) {
  return packmesh::test::runTests(argc, argv);
}
