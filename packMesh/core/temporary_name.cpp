// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/temporary_name.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>

namespace packmesh {
namespace {

constexpr std::size_t longestName = 100, longestHost = 60;  // [bytes]; the whole name stays below 255

/// Common beginning of the names of all temporary files of `target`. What follows it has no '~', so that no
/// file is taken for one of a target with a shorter name.
std::string prefixOf(const std::filesystem::path& target) {
  const std::string name = target.filename().string();
  if (name.size() <= longestName) return "." + name + "~";
  return fmt::format(".{:016x}~", XXH3_64bits(name.data(), name.size()));
}

}  // namespace

std::string hostName() {
  char name[256] = {};
  if (::gethostname(name, sizeof name - 1) != 0 || name[0] == '\0') return "localhost";
  std::string host = name;
  std::replace_if(
      host.begin(), host.end(), [](char c) { return c == '/' || c == '~'; }, '_');
  return host;
}

long processNumber() {
  return ::getpid();
}

std::filesystem::path temporaryName(const std::filesystem::path& target, int number,
                                    const std::string& kind) {
  return target.parent_path() / (prefixOf(target) + hostName().substr(0, longestHost) + "." +
                                 std::to_string(processNumber()) + "-" + std::to_string(number) + "." + kind);
}

bool isTemporaryOf(const std::filesystem::path& file, const std::filesystem::path& target,
                   const std::string& kind) {
  const std::string name = file.filename().string(), prefix = prefixOf(target);
  return name.compare(0, prefix.size(), prefix) == 0 && name.find('~', prefix.size()) == name.npos &&
         file.extension() == "." + kind;
}

bool isAbandoned(const std::filesystem::path& file, const std::string& kind) {
  const std::string name = file.filename().string(), host = "~" + hostName().substr(0, longestHost) + ".";
  const std::size_t tilde = name.rfind('~');
  if (name.empty() || name[0] != '.' || tilde == name.npos || file.extension() != "." + kind ||
      name.compare(tilde, host.size(), host) != 0)
    return false;
  const char* const number = name.c_str() + tilde + host.size();
  char* end = nullptr;
  const long process = std::strtol(number, &end, 10);
  return end != number && *end == '-' && process > 0 && ::kill(static_cast<pid_t>(process), 0) != 0 &&
         errno == ESRCH;
}

std::filesystem::path lockName(const std::filesystem::path& target) {
  return target.parent_path() / (prefixOf(target) + "lock");
}

}  // namespace packmesh
