// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/pos_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;
constexpr std::string_view blanks = " \t\r\v\f";

/// Larger positions [µm] and angles [degrees] are probably errors; the certificate relies on this bound
/// (tolerance::culling).
constexpr double largest = specs::largestLength;

/// -0 would be written as "-0".
double withoutNegativeZero(double x) {
  return x == 0.0 ? 0.0 : x;
}

void append(std::string& text, double value) {
  if (!std::isfinite(value))
    throw std::invalid_argument("a .pos file cannot hold numbers that are not finite");
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, withoutNegativeZero(value)).ptr;
  text.append(digits, end);
}

/// `text` for an error message: truncated, with unprintable characters replaced.
std::string quoted(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string out = "'";
  for (char c : text.substr(0, longest)) out += c == '\t' ? ' ' : (c >= 0x20 && c < 0x7f) ? c : '?';
  return out + (text.size() > longest ? "...'" : "'");
}

std::vector<std::string_view> fieldsOf(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = line.find_first_not_of(blanks); begin != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(blanks, end);
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

/// Something that HemoCell reads but other tools may not: number of occurrences, and the first one.
struct Oddity {
  const char* text;
  long long count = 0, firstLine = 0;
  void note(long long line) {
    if (count++ == 0) firstLine = line;
  }
};

class PosReader {
 public:
  explicit PosReader(const std::filesystem::path& file)
      : file_(file), content_(contentOf(file, "a .pos file")) {}

  std::vector<PosLine> read() {
    if (content_.find_first_not_of(" \t\r\v\f\n") == content_.npos)
      fail(1, "the file is empty; expected the number of cells");
    if (content_.compare(0, 3, "\xEF\xBB\xBF") == 0)
      fail(1,
           "the file starts with a byte order mark; expected the number of cells (save the file as plain "
           "ASCII)");
    const long long announced = readCount();
    std::vector<PosLine> lines;
    long long firstBlank = 0;
    while (position_ < content_.size() && static_cast<long long>(lines.size()) < announced) {
      const std::vector<std::string_view> fields = fieldsOf(nextLine());
      if (fields.empty()) {
        if (firstBlank == 0) firstBlank = line_;
        continue;
      }
      if (firstBlank != 0) blankLines_.note(firstBlank);
      firstBlank = 0;
      lines.push_back(readLine(fields));
    }
    const long long found = static_cast<long long>(lines.size());
    if (found < announced)
      fail(1, fmt::format("announces {} cells, but {} follow: HemoCell would invent the other {}", announced,
                          found, announced - found));
    noteUnread(announced);
    return lines;
  }

  void report(std::vector<std::string>& warnings) const {
    if (!unread_.empty()) warnings.push_back(fmt::format("{}:1: {}", file_.string(), unread_));
    for (const Oddity& oddity : {spacing_, windows_, blankLines_})
      if (oddity.count > 0)
        warnings.push_back(fmt::format("{}:{}: {} ({} line{})", file_.string(), oddity.firstLine, oddity.text,
                                       oddity.count, oddity.count == 1 ? "" : "s"));
  }

 private:
  [[noreturn]] void fail(long long line, const std::string& what) const {
    throw InputError(fmt::format("{}:{}: {}", file_.string(), line, what));
  }

  /// Lines beyond the announced number of cells are not examined: HemoCell does not read them.
  void noteUnread(long long announced) {
    long long unread = 0;
    while (position_ < content_.size()) {
      const std::size_t end = std::min(content_.find('\n', position_), content_.size());
      const std::string_view line = std::string_view(content_).substr(position_, end - position_);
      unread += line.find_first_not_of(blanks) != line.npos;
      position_ = end + 1;
    }
    if (unread > 0)
      unread_ = fmt::format("announces {} cell{}, but {} lines follow: HemoCell and packMesh read {}",
                            announced, announced == 1 ? "" : "s", announced + unread,
                            announced == 0 ? "none" : fmt::format("only the first {}", announced));
  }

  /// The next line, without its line end.
  std::string_view nextLine() {
    const std::size_t end = std::min(content_.find('\n', position_), content_.size());
    std::string_view line = std::string_view(content_).substr(position_, end - position_);
    position_ = end + 1;
    ++line_;
    if (!line.empty() && line.back() == '\r') {
      windows_.note(line_);
      line.remove_suffix(1);
    }
    const bool odd =
        !line.empty() && (line.front() == ' ' || line.back() == ' ' || line.find("  ") != line.npos ||
                          line.find_first_of("\t\r\v\f") != line.npos);
    if (odd && line.find_first_not_of(blanks) != line.npos) spacing_.note(line_);
    return line;
  }

  long long readCount() {
    const std::string_view line = nextLine();
    const std::vector<std::string_view> fields = fieldsOf(line);
    const std::optional<long long> count = fields.size() == 1 ? countIn(fields[0]) : std::nullopt;
    if (!count)
      fail(line_, "expected the number of cells (a whole number, alone on the line), found " + quoted(line));
    return *count;
  }

  PosLine readLine(const std::vector<std::string_view>& fields) const {
    if (fields[0].front() == '#' || fields[0].front() == '/' || fields[0].front() == '%')
      fail(line_, "comment " + quoted(fields[0]) + ": HemoCell stops reading here; expected x y z a b c");
    if (fields.size() != 6)
      fail(line_, fmt::format("{} field{}, expected six numbers x y z [µm] a b c [degrees]", fields.size(),
                              fields.size() == 1 ? "" : "s"));
    double numbers[6];
    for (int k = 0; k < 6; ++k) {
      const std::optional<double> number = numberIn(fields[k]);
      const std::string_view name = std::string_view("xyzabc").substr(k, 1);
      if (!number)
        fail(line_, fmt::format("field {} ({}): expected a finite number, found {}", k + 1, name,
                                quoted(fields[k])));
      if (std::abs(*number) > largest)
        fail(line_, fmt::format("field {} ({}): expected a number between -{:.0f} and {:.0f}, found {}",
                                k + 1, name, largest, largest, quoted(fields[k])));
      numbers[k] = *number;
    }
    return {{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
  }

  std::filesystem::path file_;
  std::string content_;
  std::size_t position_ = 0;
  long long line_ = 0;
  std::string unread_;  ///< warning about lines beyond those announced
  Oddity spacing_{
      "tabs, repeated, leading or trailing spaces: HemoCell reads them, pos_to_vtk drops such lines"};
  Oddity windows_{"Windows line ends"};
  Oddity blankLines_{"a blank line between cells"};
};

}  // namespace

Placement placementOf(const PosLine& line) {
  const Vec3 angle = degree * line.angles;
  const double sa = std::sin(angle.x()), ca = std::cos(angle.x());
  const double sb = std::sin(angle.y()), cb = std::cos(angle.y());
  const double sc = std::sin(angle.z()), cc = std::cos(angle.z());
  Placement placement;
  // Rz(c)·Ry(b)·Rx(a), written out.
  placement.linear << cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa,  //
      sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa,                  //
      -sb, cb * sa, cb * ca;
  placement.translation = line.position;
  return placement;
}

Pose poseOf(const PosLine& line) {
  return {1.0, Quaternion(placementOf(line).linear).normalized(), line.position};
}

PosLine posLineOf(const Pose& pose) {
  const Mat3 r = pose.orientation.normalized().toRotationMatrix();
  // c first; then a and b from Rz(-c)·R = Ry(b)·Rx(a), whose entries remain well defined if cos(b) is tiny
  // and c is dominated by noise: a and b are consistent with any c.
  const double c = std::atan2(r(1, 0), r(0, 0));
  const double sc = std::sin(c), cc = std::cos(c);
  const double b = std::atan2(-r(2, 0), cc * r(0, 0) + sc * r(1, 0));
  const double a = std::atan2(sc * r(0, 2) - cc * r(1, 2), cc * r(1, 1) - sc * r(0, 1));
  PosLine line{pose.position, Vec3(a, b, c) / degree};
  for (int k = 0; k < 3; ++k) {
    line.position[k] = withoutNegativeZero(line.position[k]);
    line.angles[k] = withoutNegativeZero(line.angles[k]);
  }
  return line;
}

std::string formatPosHead(std::int64_t count) {
  return std::to_string(count) + '\n';
}

std::string formatPosLines(const std::vector<PosLine>& lines) {
  std::string text;
  text.reserve(110 * lines.size());
  for (const PosLine& line : lines)
    for (int k = 0; k < 6; ++k) {
      append(text, k < 3 ? line.position[k] : line.angles[k - 3]);
      text += k < 5 ? ' ' : '\n';
    }
  return text;
}

std::vector<PosLine> readPos(const std::filesystem::path& file, std::vector<std::string>* warnings) {
  PosReader reader(file);
  std::vector<PosLine> lines = reader.read();
  if (warnings) reader.report(*warnings);
  return lines;
}

}  // namespace packmesh::hemocell
