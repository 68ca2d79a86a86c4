// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/pos_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

constexpr std::string_view separators = " \t\r\v\f";

/// Larger positions [µm] and angles [degrees] are probably errors; the certificate relies on this bound
/// (tolerance::culling).
constexpr double largest = specs::largestLength;

/// `text` for an error message: truncated, with unprintable characters replaced.
std::string quoted(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string out = "'";
  for (char c : text.substr(0, longest)) out += c == '\t' ? ' ' : (c >= 0x20 && c < 0x7f) ? c : '?';
  return out + (text.size() > longest ? "...'" : "'");
}

std::vector<std::string_view> fieldsOf(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = line.find_first_not_of(separators); begin != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(separators, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(separators, end);
  }
  return fields;
}

/// The finite number in `field`; empty if the whole field is not one.
std::optional<double> numberIn(std::string_view field) {
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value)) return {};
  return value;
}

std::optional<long long> countIn(std::string_view field) {
  long long value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || value < 0) return {};
  return value;
}

/// Takes the first line, without its line feed, from a text.
std::string_view takeLine(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

}  // namespace

bool isBlank(std::string_view text) {
  return text.find_first_not_of(separators) == text.npos;
}

LineCounts countLines(std::string_view text) {
  LineCounts counts;
  while (!text.empty()) {
    ++counts.lines;
    if (isBlank(takeLine(text))) {
      ++counts.blankEnd;
    } else {
      ++counts.cells;
      counts.blankEnd = 0;
    }
  }
  return counts;
}

void PosLines::fail(const std::string& what) const {
  throw InputError(fmt::format("{}:{}: {}", file_, line_, what));
}

/// The next line, without its line end.
std::string_view PosLines::nextLine() {
  std::string_view line = takeLine(text_);
  ++line_;
  if (!line.empty() && line.back() == '\r') {
    oddities_.windows.note(line_);
    line.remove_suffix(1);
  }
  const bool odd =
      !line.empty() && (line.front() == ' ' || line.back() == ' ' || line.find("  ") != line.npos ||
                        line.find_first_of("\t\r\v\f") != line.npos);
  if (odd && !isBlank(line)) oddities_.spacing.note(line_);
  return line;
}

std::int64_t PosLines::readCount() {
  const std::string_view line = nextLine();
  const std::vector<std::string_view> fields = fieldsOf(line);
  const std::optional<long long> count = fields.size() == 1 ? countIn(fields[0]) : std::nullopt;
  if (!count) fail("expected the number of cells (a whole number, alone on the line), found " + quoted(line));
  return *count;
}

void PosLines::readCells(std::int64_t count, PosLine* to) {
  for (std::int64_t cell = 0; cell < count;) {
    const std::vector<std::string_view> fields = fieldsOf(nextLine());
    if (fields.empty()) {
      if (firstBlank_ == 0) firstBlank_ = line_;
      continue;
    }
    if (firstBlank_ != 0) oddities_.blankLines.note(firstBlank_);
    firstBlank_ = 0;
    to[cell++] = lineOf(fields);
  }
}

PosLine PosLines::lineOf(const std::vector<std::string_view>& fields) const {
  if (fields[0].front() == '#' || fields[0].front() == '/' || fields[0].front() == '%')
    fail("comment " + quoted(fields[0]) + ": HemoCell stops reading here; expected x y z a b c");
  if (fields.size() != 6)
    fail(fmt::format("{} field{}, expected six numbers x y z [µm] a b c [degrees]", fields.size(),
                     fields.size() == 1 ? "" : "s"));
  double numbers[6];
  for (int k = 0; k < 6; ++k) {
    const std::optional<double> number = numberIn(fields[k]);
    const std::string_view name = std::string_view("xyzabc").substr(k, 1);
    if (!number)
      fail(fmt::format("field {} ({}): expected a finite number, found {}", k + 1, name, quoted(fields[k])));
    if (std::abs(*number) > largest)
      fail(fmt::format("field {} ({}): expected a number between -{:.0f} and {:.0f}, found {}", k + 1, name,
                       largest, largest, quoted(fields[k])));
    numbers[k] = *number;
  }
  return {{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
}

}  // namespace packmesh::hemocell
