// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which cells growth does not move.
#pragma once

#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// Whether a cell stays where it is, with its scale.
inline bool isFixed(const Physics& physics, const Body& cell) {
  return cell.frozen || physics.species[cell.species].freedom.fixed;
}

}  // namespace packmesh
