// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parser of the `<packing>` section of config.xml.
#pragma once

#include <tinyxml2.h>

#include <filesystem>
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// Parses the `<packing>` section by the tables of settings_table.h.
/// @throws InputError for unknown tags or attributes and invalid values
Request readPackingSection(const tinyxml2::XMLElement& packing, const std::filesystem::path& file);

}  // namespace packmesh::hemocell
