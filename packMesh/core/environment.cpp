// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/environment.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>

namespace packmesh {

std::optional<std::int64_t> numberInEnvironment(const char* variable, char end) {
  constexpr const char* blanks = " \t\r\n";
  const char* value = std::getenv(variable);
  std::string_view text = value ? value : "";
  if (text.find_first_not_of(blanks) == text.npos) return {};
  text = text.substr(0, text.find(end));
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  text = text.substr(0, text.find_last_not_of(blanks) + 1);
  std::int64_t number = -1;
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && last == text.data() + text.size() ? number : -1;
}

}  // namespace packmesh
