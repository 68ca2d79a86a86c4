// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Identification of objects on which TetGen fails, for messages. Internal to packMesh/growth.
#pragma once

#include <string>

#include "packMesh/growth/tetrahedra.h"

namespace packmesh {

/// Tries every object alone, then all pairs of neighbouring ones, until one run fails.
/// @return "it fails on object 3 alone", "it fails on 'a' and 'b' together", or that it fails on no single
///   object or pair. Takes a run of TetGen per object and pair.
std::string offendersText(const TetrahedraInput& input);

}  // namespace packmesh
