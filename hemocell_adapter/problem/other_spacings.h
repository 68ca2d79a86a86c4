// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One packing for several lattice spacings: HemoCell keeps its cells at each of them.
#pragma once

#include <memory>
#include <optional>

#include "hemocell_adapter/problem/cell_species.h"
#include "hemocell_adapter/problem/lumen.h"

namespace packmesh::hemocell {

/// A lumen with the lattices of the other spacings of the request. A refined case has the same extent: as
/// many nodes more as the spacing is smaller. Of a box without a case only what is kept at every spacing
/// remains.
/// @throws InputError if the extent is not a whole number of nodes at a spacing, or cells may cross ends
Lumen withOtherSpacings(Lumen lumen, const Request& request, const Case* simulation,
                        const std::optional<PreInletPlace>& preInlet);

/// The acceptance of a species at the other spacings of a lumen. Pre: the species has its shape
std::vector<OtherAcceptance> otherAcceptances(const CellSpecies& species, const Lumen& lumen);

/// What HemoCell says at the other spacings of a cell with this placement: "a vertex lies on a wall node at
/// dx 0.25 µm"; nothing if it is kept at all of them.
/// @param own mesh of a deformed cell; nullptr: it has the template
std::optional<std::string> violationElsewhere(const CellSpecies& species, const Lumen& lumen,
                                              const Placement& placement, const TriangleMesh* own);

/// Largest amount by which a template can extend further at another spacing than at that of the case [µm]:
/// HemoCell inflates templates by a thousandth of the spacing.
double inflationElsewhere(const Lumen& lumen, double dx);

/// A wall inside which HemoCell keeps the cells of a species at every spacing: `wall` if there are no others.
/// @param wallClearance see makeAcceptedWall()
std::shared_ptr<const Wall> wallAtAllSpacings(std::shared_ptr<const Wall> wall, const CellSpecies& species,
                                              const Lumen& lumen, double dx, double wallClearance);

}  // namespace packmesh::hemocell
