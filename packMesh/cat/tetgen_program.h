// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The program that runs TetGen, packmesh-tetgen.
#pragma once

#include <string>

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

}  // namespace packmesh
