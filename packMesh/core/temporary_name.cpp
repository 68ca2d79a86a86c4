// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/temporary_name.h"

#include <unistd.h>

#include <algorithm>

namespace packmesh {
namespace {

constexpr std::size_t longestName = 120, longestHost = 60;  // [bytes]; the whole name stays below 255

/// The beginning of a UTF-8 text, at most `most` bytes, without splitting a character.
std::string beginning(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0u) == 0x80u) --end;
  return text.substr(0, end);
}

}  // namespace

std::string hostName() {
  char name[256] = {};
  if (::gethostname(name, sizeof name - 1) != 0 || name[0] == '\0') return "localhost";
  std::string host = name;
  std::replace(host.begin(), host.end(), '/', '_');
  return host;
}

long processNumber() {
  return ::getpid();
}

std::string temporaryPrefix(const std::filesystem::path& target) {
  return "." + beginning(target.filename().string(), longestName) + ".";
}

std::filesystem::path temporaryName(const std::filesystem::path& target, int number,
                                    const std::string& kind) {
  return target.parent_path() / (temporaryPrefix(target) + beginning(hostName(), longestHost) + "." +
                                 std::to_string(processNumber()) + "-" + std::to_string(number) + "." + kind);
}

}  // namespace packmesh
