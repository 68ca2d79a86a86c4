// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The fluid nodes of a lattice as a lumen.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "hemocell_adapter/hemocell/lattice.h"
#include "packMesh/container/container.h"

namespace packmesh::hemocell {

/// The union of the cubes (node ± dx/2) of the fluid nodes, for vessels whose surface does not bound the
/// lumen. Its wall consists of the faces between fluid and solid nodes and, along axes that are not periodic,
/// those of the lattice; examine() is exact for them. The volume is that of the fluid nodes.
/// @param periodic axes along which the lattice repeats
/// @throws InputError if no node is fluid
std::unique_ptr<Container> makeVoxelLumen(std::shared_ptr<const Lattice> lattice,
                                          const std::array<bool, 3>& periodic);

/// The lattice spacing of a lumen that makeVoxelLumen() made, whose surface consists of stairs [µm].
std::optional<double> voxelSpacing(const Container& lumen);

/// The faces between fluid nodes and everything else, outward, in the coordinate system of the lattice [µm].
/// Edges at which only the edges of cubes touch have four or more triangles.
/// @param periodic axes along which the first plane follows the last
TriangleMesh voxelSurface(const Lattice& lattice, const std::array<bool, 3>& periodic);

/// The same of a part: the faces at the low sides of the nodes first ... last, which can be one beyond the
/// lattice.
TriangleMesh voxelSurface(const Lattice& lattice, const std::array<bool, 3>& periodic,
                          const std::array<int, 3>& first, const std::array<int, 3>& last);

}  // namespace packmesh::hemocell
