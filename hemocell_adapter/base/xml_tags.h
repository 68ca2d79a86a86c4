// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Strict reading of XML, with errors that state file, line and tag.
#pragma once

#include <tinyxml2.h>

#include <filesystem>
#include <string>

#include "hemocell_adapter/base/value.h"

namespace packmesh::hemocell {

/// Reads a file. @throws InputError if it cannot be read or is not well-formed
void loadXml(tinyxml2::XMLDocument& document, const std::filesystem::path& file);

/// The same of a text. @param file its name, for messages
void parseXml(tinyxml2::XMLDocument& document, const std::string& content, const std::filesystem::path& file);

/// "config.xml:12: <dx>".
std::string placeOf(const tinyxml2::XMLElement& element, const std::filesystem::path& file);

/// All text directly inside the element, without comments.
std::string textOf(const tinyxml2::XMLElement& element);

/// The text of `element`, parsed according to `spec`. @throws InputError with file, line and tag
Value valueOf(const tinyxml2::XMLElement& element, const ValueSpec& spec, const std::filesystem::path& file);

/// The only child named `name`, nullptr if there is none. @throws InputError if there are several
const tinyxml2::XMLElement* onlyChild(const tinyxml2::XMLElement& parent, const char* name,
                                      const std::filesystem::path& file);

}  // namespace packmesh::hemocell
