// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Files that begin with a checksum of themselves: damage is seen before anything else reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace packmesh {

/// What a sealed file begins with: text, then zeros, sealSize bytes in all.
struct Seal {
  std::string kind;  ///< of file, one line
  std::int64_t version;
  std::string writer;  ///< one line
};

/// A seal takes so many bytes [bytes].
inline constexpr std::size_t sealSize = 512;

/// Puts the seal over the first sealSize bytes of a file, with the XXH3 of all others.
/// @return what went wrong, or nothing
std::string seal(const std::filesystem::path& file, const Seal& seal);

/// Reads all of the file.
/// @throws InputError naming the file when it is none of this kind and version, or not as it was when sealed
void requireSealed(const std::filesystem::path& file, const std::string& kind, std::int64_t version);

}  // namespace packmesh
