// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Hashes of files, by which changes are recognised, and files that begin with their own.
#pragma once

#include <cstddef>
#include <cstdint>
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

/// Beginning of a sealed file: text padded with zeros to sealSize bytes.
struct Seal {
  std::string kind;  ///< kind of file, one line
  std::int64_t version;
  std::string writer;  ///< one line
};

/// Size of a seal [bytes].
inline constexpr std::size_t sealSize = 512;

/// Writes the seal into the first sealSize bytes of a file, with the XXH3 hash of the remaining bytes.
/// @return an error message, or an empty string
std::string seal(const std::filesystem::path& file, const Seal& seal);

/// Reads and verifies the whole file.
/// @return the version of the file
/// @throws InputError naming the file if it is not of this kind and of a version from `oldest` to `version`,
/// or has changed since it was sealed
std::int64_t requireSealed(const std::filesystem::path& file, const std::string& kind, std::int64_t oldest,
                           std::int64_t version);

}  // namespace packmesh
