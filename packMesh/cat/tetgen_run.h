// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Runs of TetGen, each in a process of its own: TetGen 1.5 has global state, and on some input it
/// crashes or never returns. Internal to packMesh/cat.
#pragma once

#include <functional>

#include "packMesh/cat/tetgen_data.h"

namespace packmesh {

/// Runs packmesh-tetgen and waits for it. Threads may do so at the same time. Pre: triangles intersect in
/// common vertices and edges only; on other input TetGen may fail in any way, which is a failure of the run
/// alone.
/// @param failure set if TetGen gives up; the output is then empty
/// @param stop polled at least 20 times per second; true ends the run. Empty: never stop
/// @throws InputError if there is no such program (see tetgenProgram())
TetgenOutput runTetgen(const TetgenInput& input, TetgenFailure& failure,
                       const std::function<bool()>& stop = {});

}  // namespace packmesh
