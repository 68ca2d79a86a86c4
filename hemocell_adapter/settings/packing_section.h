// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parser of the `<packing>` section of config.xml.
#pragma once

#include <tinyxml2.h>

#include <filesystem>
#include <string>

#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// Parses the `<packing>` section by the tables of settings_table.h.
/// @throws InputError for unknown tags or attributes and invalid values
Request readPackingSection(const tinyxml2::XMLElement& packing, const std::filesystem::path& file);

/// The same of a text that is in no file. Its species add to those of `base`, or change them; its container
/// and regions replace them. @param where it comes from, for messages
Request withPackingSection(Request base, const std::string& text, const std::string& where);

}  // namespace packmesh::hemocell
