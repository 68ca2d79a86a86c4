// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Hashes of files, by which changes are recognised.
#pragma once

#include <filesystem>
#include <istream>
#include <string>
#include <string_view>

namespace packmesh {

/// XXH3 of a text and all that follows in a stream: 128 bits as hexadecimal digits; empty if it cannot be
/// read.
std::string restHash(std::istream& in, std::string_view before = {});

/// The same of a regular file; empty if there is none, or it cannot be read.
std::string fileHash(const std::filesystem::path& file);

}  // namespace packmesh
