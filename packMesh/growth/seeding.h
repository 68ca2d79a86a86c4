// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Where growth begins.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "packMesh/growth/growth_settings.h"
#include "packMesh/growth/growth_state.h"

namespace packmesh {

/// Cells shrunk to `scale` at random centres, turned at random, such that their bounding spheres do not meet
/// and are inside the lumen (thesis eq. 3.6, with the sum of both radii as distance). Large cells choose
/// first.
/// @param counts cells of each species
/// @param names of the species, for messages
/// @throws InputError naming the species and cell for which no room was found
GrowthState seedRandomly(const GrowthScene& scene, const std::vector<std::int64_t>& counts,
                         const std::vector<std::string>& names, double scale);

/// The first state: seedRandomly() at the initial scale and, where cells differ in volume, spread by a
/// centroidal power diagram (spreadByPowerDiagram). Parameters and errors as there.
GrowthState seed(const GrowthScene& scene, const std::vector<std::int64_t>& counts,
                 const std::vector<std::string>& names, const GrowthSettings& settings);

}  // namespace packmesh
