// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which cells of a scene are soft, and by which constants.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"
#include "packMesh/soft/soft_packing.h"

namespace packmesh::hemocell {

/// What soft cells exclude. @throws UsageError
void refuseBesideSoft(const Request& request);

/// @throws InputError if a cell's XML file has some constants of the membrane, and others not. Pre: the
/// species have their numbers
void requireMembranes(const Scene& scene);

/// Of a species, at the lattice spacing of the scene. Files without any constants, and cells without a file,
/// have those of HemoCell's cell templates.
MembraneConstants membraneOf(const Scene& scene, const CellSpecies& species);

/// "RBC: soft, kLink 15, kBend 80, kVolume 20, kArea 5 (RBC.xml)", for each species that there is.
std::vector<std::string> softnessLines(const Scene& scene);

}  // namespace packmesh::hemocell
