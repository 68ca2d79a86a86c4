// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Walls between two parts of a lumen that are too thin for the lattice.
#pragma once

#include <optional>
#include <string>

#include "hemocell_adapter/problem/lumen.h"

namespace packmesh::hemocell {

/// A warning about a wall without a solid node: HemoCell does not see it. Empty if there is none, or no
/// lattice.
std::optional<std::string> unseenWallWarning(const Lumen& lumen);

}  // namespace packmesh::hemocell
