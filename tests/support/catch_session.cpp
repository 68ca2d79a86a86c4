// SPDX-License-Identifier: AGPL-3.0-or-later
// Catch itself, compiled once for all programs that contain tests.
#define CATCH_CONFIG_RUNNER
#include "tests/support/catch_session.h"
#include "tests/support/catch.h"

int packmesh::test::runTests(int argc, char** argv) {
  return Catch::Session().run(argc, argv);
}
