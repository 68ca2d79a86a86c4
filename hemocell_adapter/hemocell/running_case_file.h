// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which file a running HemoCell has read: HemoCell does not keep its name.
#pragma once

#include <tinyxml2.h>

#include <filesystem>
#include <optional>

namespace packmesh::hemocell {

/// The file that has this XML, up to white space between tags: among the words of this program's command
/// line, or config.xml; empty if none has.
std::optional<std::filesystem::path> runningCaseFile(const tinyxml2::XMLDocument& document);

}  // namespace packmesh::hemocell
