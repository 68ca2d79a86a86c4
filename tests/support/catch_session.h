// SPDX-License-Identifier: AGPL-3.0-or-later
#pragma once

namespace packmesh::test {

/// @param argc, argv arguments of the program @return its exit code
int runTests(int argc, char** argv);

}  // namespace packmesh::test
