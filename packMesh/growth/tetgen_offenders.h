// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which objects TetGen fails on, for messages. Internal to packMesh/growth.
#pragma once

#include <string>

#include "packMesh/growth/tetrahedra.h"

namespace packmesh {

/// Tries every object alone, then every two that are near each other, until one try fails.
/// @return "it fails on object 3 alone", "on 'a' and 'b' together", or that it fails on no two of them. Takes
/// a
///   run of TetGen per object and pair.
std::string offendersText(const TetrahedraInput& input);

}  // namespace packmesh
