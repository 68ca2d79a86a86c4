// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How TetGen says that it gives up. Internal to packMesh/stages/growth.
#pragma once

namespace packmesh {

/// Thrown through TetGen.
struct TetgenGaveUp {
  int code;
};

/// Whether TetGen's way to give up is ours; always true, and what makes linkers take our way into a program.
bool tetgenThrows();

}  // namespace packmesh
