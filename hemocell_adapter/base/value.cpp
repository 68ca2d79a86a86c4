// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/value.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <sstream>

#include "hemocell_adapter/base/messages.h"
#include "packMesh/core/error.h"

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

namespace {

/// Cell names are used as names of files, with extensions, and as table entries.
constexpr std::size_t longestName = 100;  // [bytes]

/// The part of a value that a message quotes.
std::string shortened(const std::string& text) {
  constexpr std::size_t longest = 200;  // [bytes]
  return text.size() <= longest ? text : text.substr(0, longest) + "...";
}

/// A bound of the range of `spec`; integers with all digits.
std::string boundText(const ValueSpec& spec, double bound) {
  if (spec.kind != Kind::integer) return fmt::format("{:.15g}", bound);
  constexpr auto largest = std::numeric_limits<std::int64_t>::max();
  return fmt::format("{}", bound < double(largest) ? std::int64_t(bound) : largest);
}

/// The range of `spec` as text: " > 0", " in [1, 5)", "".
std::string rangeText(const ValueSpec& spec) {
  const bool low = std::isfinite(spec.low), high = std::isfinite(spec.high);
  if (low && high) {
    return fmt::format(" in {}{}, {}{}", spec.lowExcluded ? '(' : '[', boundText(spec, spec.low),
                       boundText(spec, spec.high), spec.highExcluded ? ')' : ']');
  }
  if (low) return fmt::format(" {} {}", spec.lowExcluded ? ">" : ">=", boundText(spec, spec.low));
  if (high) return fmt::format(" {} {}", spec.highExcluded ? "<" : "<=", boundText(spec, spec.high));
  return "";
}

bool inRange(const ValueSpec& spec, double x) {
  const bool aboveLow = spec.lowExcluded ? x > spec.low : x >= spec.low;
  const bool belowHigh = spec.highExcluded ? x < spec.high : x <= spec.high;
  return aboveLow && belowHigh;
}

std::optional<std::int64_t> toInteger(const std::string& text) {
  std::int64_t whole = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), whole);
  if (error == std::errc() && end == text.data() + text.size()) return whole;
  const auto number = toNumber(text);
  constexpr double largestExact = 9007199254740992.0;  // 2^53: larger doubles skip integers
  if (number && std::abs(*number) <= largestExact && *number == std::floor(*number))
    return std::int64_t(*number);
  return {};
}

std::optional<std::string> toAxes(const std::string& text) {
  const std::string letters = lowered(text);
  if (letters == "none") return "";
  std::string sorted;
  for (const char axis : {'x', 'y', 'z'}) {
    const auto count = std::count(letters.begin(), letters.end(), axis);
    if (count > 1) return {};
    if (count == 1) sorted += axis;
  }
  for (const char c : letters) {
    if (c != ' ' && c != ',' && sorted.find(c) == std::string::npos) return {};
  }
  if (sorted.empty()) return {};
  return sorted;
}

/// Numbers separated by blanks; empty if one of them is invalid or out of range.
std::vector<double> toNumbers(const ValueSpec& spec, const std::string& text) {
  std::istringstream words(text);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const auto number = toNumber(word);
    if (!number || !std::isfinite(*number) || !inRange(spec, *number)) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

/// The choice named by `text`, ignoring case.
std::optional<Value> choiceIn(const ValueSpec& spec, const std::string& text) {
  for (const std::string& choice : spec.choices)
    if (lowered(text) == lowered(choice)) return choice;
  return {};
}

std::optional<Value> read(const ValueSpec& spec, const std::string& text) {
  switch (spec.kind) {
    case Kind::number: {
      const auto number = toNumber(text);
      if (number && std::isfinite(*number) && inRange(spec, *number)) return *number;
      return choiceIn(spec, text);
    }
    case Kind::integer: {
      const auto whole = toInteger(text);
      if (whole && inRange(spec, double(*whole))) return *whole;
      return {};
    }
    case Kind::boolean: {
      const std::string word = lowered(text);
      if (word == "true" || word == "yes" || word == "on" || word == "1") return true;
      if (word == "false" || word == "no" || word == "off" || word == "0") return false;
      return choiceIn(spec, text);
    }
    case Kind::text:
      if (text.empty()) return {};
      return text;
    case Kind::name:
      if (!isCellName(text)) return {};
      return text;
    case Kind::choice:
      return choiceIn(spec, text);
    case Kind::axis: {
      const std::string letter = lowered(text);
      if (letter.size() == 1 && letter[0] >= 'x' && letter[0] <= 'z') return std::int64_t(letter[0] - 'x');
      return {};
    }
    case Kind::plane:
      return nodePlaneFromString(text);
    case Kind::axes:
      return toAxes(text);
    case Kind::vector: {
      const auto numbers = toNumbers(spec, text);
      if (numbers.size() != 3) return {};
      return Vec3(numbers[0], numbers[1], numbers[2]);
    }
    case Kind::numbers: {
      auto numbers = toNumbers(spec, text);
      if (numbers.empty()) return {};
      return numbers;
    }
  }
  return {};
}

}  // namespace

bool isCellName(const std::string& text) {
  if (text.empty() || text.size() > longestName || plainText(text) != text) return false;
  if (text.find_first_of("/\\ \t\n,\"'#;") != std::string::npos) return false;
  constexpr const char* first[] = {".", "=", "+", "-", "@", "＝", "＋", "－", "＠"};
  return std::none_of(std::begin(first), std::end(first),
                      [&](const char* character) { return text.rfind(character, 0) == 0; });
}

std::string expectedCellName() {
  return fmt::format(
      "a cell name of at most {} bytes without blanks, control characters, slashes, commas, semicolons, "
      "quotes and #, not beginning with one of . = + - @",
      longestName);
}

std::string expectation(const ValueSpec& spec) {
  const std::string unit = *spec.unit ? fmt::format(" [{}]", spec.unit) : "";
  switch (spec.kind) {
    case Kind::number:
      return "a number" + rangeText(spec) + unit +
             (spec.choices.empty() ? "" : ", or " + alternatives(spec.choices));
    case Kind::integer:
      return "a whole number" + rangeText(spec) + unit;
    case Kind::boolean:
      return spec.choices.empty() ? "true or false" : "true, false or " + alternatives(spec.choices);
    case Kind::text:
      return std::string_view(spec.placeholder) == "file"     ? "a file"
             : std::string_view(spec.placeholder) == "folder" ? "a folder"
                                                              : "some text";
    case Kind::name:
      return expectedCellName();
    case Kind::choice:
      return alternatives(spec.choices);
    case Kind::axis:
      return "an axis: x, y or z";
    case Kind::plane:
      return "a plane of nodes: 0, 1, ... or last, last-1, ...";
    case Kind::axes:
      return "axes, such as yz, or none";
    case Kind::vector:
      return "three numbers" + rangeText(spec) + unit;
    case Kind::numbers:
      return "numbers" + rangeText(spec) + unit;
  }
  return "";
}

Value parseValue(const ValueSpec& spec, const std::string& text) {
  const std::string content = trimmed(text);
  if (auto value = read(spec, content)) return *value;
  std::string hint;
  if (spec.kind == Kind::choice) {
    if (const auto nearest = nearestName(content, spec.choices))
      hint = fmt::format(" (did you mean '{}'?)", *nearest);
  }
  throw InputError(fmt::format("expected {}, found {}{}", expectation(spec),
                               content.empty() ? std::string("nothing") : "'" + shortened(content) + "'",
                               hint));
}

std::optional<double> toNumber(const std::string& text) {
  const char* first = text.data();
  const char* last = first + text.size();
  if (first != last && *first == '+') ++first;
  if (first != last && *first == '-' && first != text.data()) return {};  // "+-1"
  double number = 0.0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (first == last || end != last) return {};
  if (error == std::errc::result_out_of_range) return std::numeric_limits<double>::infinity();
  if (error != std::errc()) return {};
  return number;
}

std::string trimmed(const std::string& text) {
  const char* blanks = " \t\r\n\v\f";
  const auto first = text.find_first_not_of(blanks);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::string lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::optional<std::string> nearestName(const std::string& name, const std::vector<std::string>& candidates) {
  // Optimal string alignment distance: insertion, deletion, substitution and transposition of neighbours cost
  // one each.
  const auto distance = [](const std::string& a, const std::string& b) {
    std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) cost[i][0] = i;
    for (std::size_t j = 0; j <= b.size(); ++j) cost[0][j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
      for (std::size_t j = 1; j <= b.size(); ++j) {
        const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
        cost[i][j] = std::min({cost[i - 1][j] + 1, cost[i][j - 1] + 1, cost[i - 1][j - 1] + change});
        if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
          cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
        }
      }
    }
    return cost[a.size()][b.size()];
  };
  std::optional<std::string> nearest;
  constexpr std::size_t longest = 100;  // longer names are no typing errors, and comparing them is slow
  if (name.size() > longest) return nearest;
  std::size_t least = 1 + std::max<std::size_t>(1, name.size() / 3);
  for (const std::string& candidate : candidates) {
    const bool begins = name.size() > 1 && lowered(candidate).compare(0, name.size(), lowered(name)) == 0;
    const std::size_t d = begins ? 1 : distance(lowered(name), lowered(candidate));
    if (d < least) {
      least = d;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string alternatives(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 == items.size() ? " or " : ", ";
    text += items[i];
  }
  return text;
}

}  // namespace packmesh::hemocell
