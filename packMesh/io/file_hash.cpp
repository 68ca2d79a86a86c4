// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/file_hash.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <fstream>
#include <system_error>
#include <vector>

namespace packmesh {

std::string restHash(std::istream& in, std::string_view before) {
  XXH3_state_t state;
  XXH3_128bits_reset(&state);
  XXH3_128bits_update(&state, before.data(), before.size());
  std::vector<char> chunk(std::size_t{1} << 20);
  while (in.read(chunk.data(), static_cast<std::streamsize>(chunk.size())) || in.gcount() > 0)
    XXH3_128bits_update(&state, chunk.data(), static_cast<std::size_t>(in.gcount()));
  if (!in.eof()) return {};
  const XXH128_hash_t hash = XXH3_128bits_digest(&state);
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::string fileHash(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return {};
  std::ifstream in(file, std::ios::binary);
  return restHash(in);
}

}  // namespace packmesh
