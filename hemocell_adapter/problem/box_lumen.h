// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumens that are boxes of nodes, or whatever nodes a running HemoCell has.
#pragma once

#include <array>
#include <string>

#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// Whether the faces across an axis are walls. @param walls axes, "yz"
bool hasWall(const std::string& walls, int axis);

/// @throws InputError that begins with `where` if no lattice can have that many nodes
std::array<int, 3> checkedNodes(const Vec3& nodes, const std::string& where);

/// A box of the command line: along periodic axes [0, s], along others the part that HemoCell keeps.
Lumen boxLumen(const Request& request);

/// A case whose lattice is a box of nodes; walls are whole node planes, so the true wall is half a node
/// inside.
Lumen domainBox(const Request& request, const Case& simulation);

/// The fluid nodes of a running HemoCell. Boxes of them are the boxes that domainBox() makes.
Lumen runningLumen(const Request& request, const RunningSystem& running);

}  // namespace packmesh::hemocell
