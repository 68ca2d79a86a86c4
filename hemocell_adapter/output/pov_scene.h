// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Pictures: a packing as a scene for POV-Ray 3.7.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/container/container.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// A cell and the quantities by which it can be coloured.
struct PicturedCell {
  PlacedCell cell;
  double gap = 0.0;              ///< to the nearest other one [µm]
  double localHematocrit = 0.0;  ///< around it
};

/// Writes a POV-Ray scene: one mesh per species, instanced for every cell, coloured by the name of the
/// species (RBC* red, PLT* yellow, WBC* white), the lumen translucent around them (a lumen without walls as
/// the edges of its box), and a camera that frames all of it at any aspect ratio. Units are µm; the scene
/// includes no files. python3 -m packmesh render renders it without a display.
///
/// @param shapes,names per species
/// @param cells PlacedCell::species indexes shapes and names
/// @throws OutputError when the file cannot be written; then an older file of that name is unchanged
void writePovScene(const std::filesystem::path& file, const std::vector<const Shape*>& shapes,
                   const std::vector<std::string>& names, const std::vector<PicturedCell>& cells,
                   const Container& container);

}  // namespace packmesh
