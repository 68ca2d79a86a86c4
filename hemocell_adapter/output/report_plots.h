// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The plots of a report.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "hemocell_adapter/output/svg_plot.h"

namespace packmesh::hemocell {

std::vector<Plot> plotsOf(const nlohmann::ordered_json& report);

}  // namespace packmesh::hemocell
