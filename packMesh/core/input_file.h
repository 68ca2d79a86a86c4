// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Files named by the user.
#pragma once

#include <filesystem>
#include <string>

namespace packmesh {

/// True if `file` exists, or if that cannot be determined (reading it then gives the reason).
bool isThere(const std::filesystem::path& file);

/// @param expected what the file should be, for the message: "a mesh file"
/// @throws InputError with the name of the file if it does not exist, is not accessible, or is not a regular
/// file (pipes and devices may have no end)
void requireFile(const std::filesystem::path& file, const std::string& expected);

/// All bytes of a file. @throws InputError like requireFile(), and if reading fails
std::string contentOf(const std::filesystem::path& file, const std::string& expected);

/// The lines that begin in one of `parts` parts of equal length of a file; the first line is in part 0. All
/// parts together are contentOf() the file. @throws InputError likewise
/// @param part from 0
std::string linesOf(const std::filesystem::path& file, const std::string& expected, int part, int parts);

}  // namespace packmesh
