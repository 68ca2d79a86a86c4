// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Small helpers for strict reading of XML with errors that name the place.
#pragma once

#include <tinyxml2.h>

#include <filesystem>
#include <string>

#include "hemocell_adapter/base/value.h"

namespace packmesh::hemocell {

/// Reads a file. @throws InputError when it cannot be read or is not well-formed
void loadXml(tinyxml2::XMLDocument& document, const std::filesystem::path& file);

/// "config.xml:12: <dx>".
std::string placeOf(const tinyxml2::XMLElement& element, const std::filesystem::path& file);

/// All text directly inside the element, comments left out.
std::string textOf(const tinyxml2::XMLElement& element);

/// The text of `element` as `spec` demands. @throws InputError with the place
Value valueOf(const tinyxml2::XMLElement& element, const ValueSpec& spec, const std::filesystem::path& file);

/// The only child called `name`, nullptr when there is none. @throws InputError when there are several
const tinyxml2::XMLElement* onlyChild(const tinyxml2::XMLElement& parent, const char* name,
                                      const std::filesystem::path& file);

}  // namespace packmesh::hemocell
