// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A report for people: one file that needs nothing else.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hemocell_adapter/output/report_picture.h"

namespace packmesh::hemocell {

/// The report as one HTML file: picture, plots and style are in it, nothing is loaded from anywhere.
std::string htmlText(const nlohmann::ordered_json& report, const Picture& picture);

}  // namespace packmesh::hemocell
