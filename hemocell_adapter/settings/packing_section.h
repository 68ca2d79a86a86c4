// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The `<packing>` section of config.xml.
#pragma once

#include <tinyxml2.h>

#include <filesystem>

#include "hemocell_adapter/settings/settings.h"

namespace packmesh::hemocell {

/// Reads the `<packing>` section by the tables of settings_table.h.
/// @throws InputError for everything it does not know
Settings readPackingSection(const tinyxml2::XMLElement& packing, const std::filesystem::path& file);

}  // namespace packmesh::hemocell
