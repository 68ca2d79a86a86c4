// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Files that users name.
#pragma once

#include <filesystem>
#include <string>

namespace packmesh {

/// @param expected "a mesh file", for the message
/// @throws InputError naming the file when it is not there, or a folder, or a device, which may have no end
void requireFile(const std::filesystem::path& file, const std::string& expected);

/// All bytes of a file. @throws InputError as requireFile(), and when it cannot be read
std::string contentOf(const std::filesystem::path& file, const std::string& expected);

}  // namespace packmesh
