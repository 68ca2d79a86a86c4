// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/sealed_file.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

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

namespace {

namespace fs = std::filesystem;

std::string headOf(const std::string& kind) {
  return "packMesh " + kind + ", version ";
}

/// The first bytes of a sealed file.
std::string blockOf(const Seal& seal, const std::string& hash) {
  std::string block =
      fmt::format("{}{}\nwritten by {}\nXXH3 {}\n", headOf(seal.kind), seal.version, seal.writer, hash);
  block.resize(sealSize, '\0');
  return block;
}

/// Hash of the writer and of all bytes after the seal; empty if they cannot be read.
std::string hashOf(const std::string& writer, std::istream& in) {
  in.seekg(sealSize);
  return restHash(in, writer);
}

/// The line that begins at position `at`.
std::string_view lineAt(std::string_view text, std::size_t at) {
  return at < text.size() ? text.substr(at, text.find('\n', at) - at) : std::string_view();
}

}  // namespace

std::string seal(const fs::path& file, const Seal& seal) {
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  const std::string hash = hashOf(seal.writer, out);
  out.clear();
  if (hash.empty()) return "cannot be read back";
  const std::string block = blockOf(seal, hash);
  errno = 0;
  if (out.seekp(0) && out.write(block.data(), sealSize) && out.flush()) return "";
  return std::string("cannot be written: ") + std::strerror(errno);
}

std::int64_t requireSealed(const fs::path& file, const std::string& kind, std::int64_t oldest,
                           std::int64_t version) {
  const auto fail = [&](const std::string& what) { throw InputError(file.string() + ": " + what); };
  requireFile(file, "a packMesh " + kind);
  std::error_code ignored;
  std::ifstream in;
  if (fs::is_regular_file(file, ignored)) in.open(file, std::ios::binary);  // a pipe cannot be read twice
  std::string block(sealSize, '\0');
  in.read(block.data(), sealSize);
  block.resize(static_cast<std::size_t>(in.gcount()));
  in.clear();

  const std::string head = headOf(kind);
  if (block.compare(0, 4, "\x89HDF") == 0) fail("is an HDF5 file, but not a packMesh " + kind);
  if (block.compare(0, head.size(), head) != 0) fail("is not a packMesh " + kind + ", or cannot be read");
  const std::string_view number = lineAt(block, head.size());
  std::int64_t found = 0;
  std::from_chars(number.data(), number.data() + number.size(), found);
  const std::string_view writtenBy = lineAt(block, head.size() + number.size() + 1);
  constexpr std::string_view by = "written by ";
  const std::string writer(writtenBy.substr(std::min(by.size(), writtenBy.size())));
  if (found > 0 && (found < oldest || found > version))
    fail(fmt::format("is a {0} of version {1}, written by {3}; this packMesh reads version {2}", kind, found,
                     version, writer));
  const std::string hash = hashOf(writer, in);
  if (hash.empty() || block != blockOf({kind, found, writer}, hash)) fail("is truncated or damaged");
  return found;
}

}  // namespace packmesh
