// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Centres of cells of different sizes, spread through the lumen.
#pragma once

#include "packMesh/growth/growth_state.h"

namespace packmesh {

/// Moves the centres to the centroids of their power cells, `rounds` times (Lloyd's algorithm; thesis 3.1.1,
/// centroidal power diagram): each cell gets room in proportion to its volume. The weight of a cell is the
/// square of the radius of a sphere that has the cell's share of the lumen.
///
/// The lumen is represented by points of a sequence of low discrepancy, so that lumens of any form and
/// periodic ones are treated alike; a power cell is the points that are nearest to its centre by squared
/// distance minus weight. (The dual, weighted Delaunay tetrahedra, would give the cells of the endless space,
/// which would have to be cut by the lumen's surface.) A cell without any points is hidden by those of larger
/// ones; its centre moves to the middle of the largest gap, or it would stay beside them. Scales and
/// orientations stay. A centre does not move where its cell's bounding sphere would leave the lumen, and no
/// centre does when bounding spheres would meet then.
/// Pre: positions within the container's bounds
void spreadByPowerDiagram(const GrowthScene& scene, int rounds, GrowthState& state);

}  // namespace packmesh
