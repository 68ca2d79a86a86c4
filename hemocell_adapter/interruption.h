// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Ctrl-C.
#pragma once

namespace packmesh::hemocell {

/// From now on SIGINT and SIGTERM only set a flag; a second one ends the program at once (exit code 130).
void catchInterruption();

/// Whether the flag is set.
bool interrupted();

}  // namespace packmesh::hemocell
