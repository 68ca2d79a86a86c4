// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Files that users name.
#pragma once

#include <filesystem>
#include <string>

namespace packmesh {

/// Whether there is something of this name, or the system does not let us know: then reading it tells why.
bool isThere(const std::filesystem::path& file);

/// @param expected "a mesh file", for the message
/// @throws InputError naming the file when it is not there, cannot be reached, or is no regular file: pipes
/// and devices
///   may have no end
void requireFile(const std::filesystem::path& file, const std::string& expected);

/// All bytes of a file. @throws InputError as requireFile(), and when it cannot be read
std::string contentOf(const std::filesystem::path& file, const std::string& expected);

}  // namespace packmesh
