// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A self-contained report for readers.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hemocell_adapter/output/report_picture.h"

namespace packmesh::hemocell {

/// The report as one HTML file: picture, plots and style are included, no other files are loaded.
std::string htmlText(const nlohmann::ordered_json& report, const Picture& picture);

}  // namespace packmesh::hemocell
