// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file TetGen runs as a program of its own, packmesh-tetgen, because on some input it crashes or never
/// returns.
#pragma once

#include <functional>
#include <string>

#include "packMesh/cat/tetgen_data.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// Its path: the environment variable PACKMESH_TETGEN; otherwise beside the program or shared library that
/// this code is part of, or in libexec/packmesh of a folder above that; otherwise where it is installed by
/// default.
/// @throws InputError that names these places if it is in none of them
std::string tetgenProgram();

/// Starts it on every rank, so that later runs cannot fail for reasons of the installation. All ranks call.
/// @throws InputError on all ranks if one does not find it, or finds one of another version
void requireTetgen(const Communicator& ranks);

/// Runs packmesh-tetgen and waits for it. Threads may do so at the same time. Pre: triangles intersect in
/// common vertices and edges only; on other input TetGen may fail in any way, which is a failure of the run
/// alone.
/// @param failure set if TetGen gives up; the output is then empty
/// @param stop polled at least 20 times per second; true ends the run. Empty: never stop
/// @throws InputError if there is no such program (see tetgenProgram())
TetgenOutput runTetgen(const TetgenInput& input, TetgenFailure& failure,
                       const std::function<bool()>& stop = {});

}  // namespace packmesh
