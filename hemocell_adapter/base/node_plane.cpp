// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/node_plane.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

namespace packmesh::hemocell {

std::string toString(NodePlane plane) {
  if (plane >= 0) return fmt::format("{}", plane);
  return plane == -1 ? "last" : fmt::format("last - {}", -1 - plane);
}

std::string toString(const NodeRange& range) {
  return fmt::format("{} {} {}", "xyz"[range.axis], toString(range.lo), toString(range.hi));
}

std::optional<NodePlane> nodePlaneFromString(const std::string& text) {
  const auto whole = [](const std::string& digits) -> std::optional<NodePlane> {
    constexpr NodePlane most = 1000000;
    NodePlane n = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), n);
    if (error != std::errc() || end != digits.data() + digits.size() || n < 0 || n > most) return {};
    return n;
  };
  std::string word = text;
  for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (word.compare(0, 4, "last") != 0) return whole(word);
  word.erase(std::remove(word.begin(), word.end(), ' '), word.end());
  if (word == "last") return -1;
  const auto before = word[4] == '-' ? whole(word.substr(5)) : std::nullopt;
  if (!before) return {};
  return -1 - *before;
}

}  // namespace packmesh::hemocell
