// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/pos_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;

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

}  // namespace

Placement placementOf(const PosLine& line) {
  const Vec3 angle = degree * line.angles;
  const double sa = std::sin(angle.x()), ca = std::cos(angle.x());
  const double sb = std::sin(angle.y()), cb = std::cos(angle.y());
  const double sc = std::sin(angle.z()), cc = std::cos(angle.z());
  Placement placement;
  // Rz(c)·Ry(b)·Rx(a), written out by columns.
  placement.linear = Mat3({cc * cb, sc * cb, -sb},                                    //
                          {cc * sb * sa - sc * ca, sc * sb * sa + cc * ca, cb * sa},  //
                          {cc * sb * ca + sc * sa, sc * sb * ca - cc * sa, cb * ca});
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

PosLine lineOf(const Cell& cell) {
  if (!cell.angles.allFinite()) return posLineOf(cell.pose);
  constexpr double rounding = 1e-6;  // far above that of angles and quaternions, below what moves a cell
  const PosLine line{cell.pose.position, cell.angles};
  const Mat3 turned = cell.pose.orientation.toRotationMatrix();
  if (!((placementOf(line).linear - turned).norm() < rounding))
    throw InputError("a state is damaged: the angles of a cell are not those of its orientation");
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

namespace {

std::string bitsOf(const Pose& pose) {
  std::array<double, 7> numbers{};
  for (int k = 0; k < 3; ++k) numbers[k] = pose.position[k];
  for (int k = 0; k < 4; ++k) numbers[3 + k] = pose.orientation.coeffs()[k];
  return {reinterpret_cast<const char*>(numbers.data()), sizeof numbers};
}

}  // namespace

void ReadLines::add(const PosLine& line) {
  lines_.emplace(bitsOf(poseOf(line)), line);
}

void ReadLines::add(const std::vector<Cell>& cells) {
  for (const Cell& cell : cells)
    if (const PosLine line = packmesh::hemocell::lineOf(cell); line.angles != posLineOf(cell.pose).angles)
      lines_.insert_or_assign(bitsOf(cell.pose), line);
}

PosLine ReadLines::lineOf(const Pose& pose) const {
  if (!lines_.empty()) {
    const auto found = lines_.find(bitsOf(pose));
    if (found != lines_.end()) return found->second;
  }
  return posLineOf(pose);
}

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

namespace {

/// About as many bytes are given to a thread at a time.
constexpr std::size_t bytesOfPiece = std::size_t{1} << 20;

/// Splits a text into pieces of whole lines.
std::vector<std::string_view> piecesOf(std::string_view text) {
  std::vector<std::string_view> pieces;
  while (!text.empty()) {
    const std::size_t last = text.find('\n', std::min(bytesOfPiece, text.size()) - 1);
    const std::size_t length = last == text.npos ? text.size() : last + 1;
    pieces.push_back(text.substr(0, length));
    text.remove_prefix(length);
  }
  return pieces;
}

/// Lines before a piece, and what is to be read of it.
struct Begin {
  std::int64_t line = 2;        ///< number of its first line
  std::int64_t cells = 0;       ///< before it
  std::int64_t blankSince = 0;  ///< first of the blank lines before it; 0: none
  void pass(const LineCounts& piece) {
    if (piece.cells > 0) blankSince = 0;
    if (blankSince == 0 && piece.blankEnd > 0) blankSince = line + piece.lines - piece.blankEnd;
    line += piece.lines;
    cells += piece.cells;
  }
};

class PosReader {
 public:
  PosReader(const std::filesystem::path& file, const Communicator& ranks, const Threads& threads)
      : file_(file), ranks_(ranks), threads_(threads) {}

  PosShare read() {
    together(ranks_, [&] { content_ = linesOf(file_, "a .pos file", ranks_.rank(), ranks_.size()); });
    readHead();
    countPieces();
    PosShare share;
    share.all = announced_;
    together(ranks_, [&] { readPieces(share); });
    together(ranks_, [&] {
      if (found_ == 0 && announced_ > 0)
        fail(
            fmt::format("has the number of cells, {}, but no cells. packMesh's plug-in writes such files for "
                        "HemoCell's restarts; the cells of its run are in the output folder (packmesh run)",
                        announced_));
      if (found_ < announced_)
        fail(fmt::format("announces {} cells, but {} follow: HemoCell would invent the other {}", announced_,
                         found_, announced_ - found_));
    });
    return share;
  }

  void report(std::vector<std::string>& warnings) const {
    if (const std::int64_t unread = found_ - announced_; unread > 0)
      warnings.push_back(
          fmt::format("{}:1: announces {} cell{}, but {} lines follow: HemoCell and packMesh read {}",
                      file_.string(), announced_, announced_ == 1 ? "" : "s", found_,
                      announced_ == 0 ? "none" : fmt::format("only the first {}", announced_)));
    const auto warn = [&](const Oddity& own, const char* text) {
      Oddity all;
      for (const Oddity& one : ranks_.gatherAll(std::vector<Oddity>{own})) all.add(one);
      if (all.count > 0)
        warnings.push_back(fmt::format("{}:{}: {} ({} line{})", file_.string(), all.firstLine, text,
                                       all.count, all.count == 1 ? "" : "s"));
    };
    warn(oddities_.spacing,
         "tabs, repeated, leading or trailing spaces: HemoCell reads them, pos_to_vtk drops such lines");
    warn(oddities_.windows, "Windows line ends");
    warn(oddities_.blankLines, "a blank line between cells");
  }

 private:
  /// About the first line.
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}:1: {}", file_.string(), what));
  }

  /// The first line, which the first rank has.
  void readHead() {
    std::string_view text = content_;
    const bool any = ranks_.any(!std::all_of(text.begin(), text.end(), [](char c) {
      return c == '\n' || isBlank({&c, 1});
    }));
    onFirstRank(ranks_, [&] {
      if (!any) fail("the file is empty; expected the number of cells");
      if (text.compare(0, 3, "\xEF\xBB\xBF") == 0)
        fail(
            "the file starts with a byte order mark; expected the number of cells (save the file as plain "
            "ASCII)");
      PosLines head(file_.string(), text, 1, 0);
      announced_ = head.readCount();
      add(head.oddities());
      text = head.rest();
    });
    announced_ = ranks_.sum(announced_);
    pieces_ = piecesOf(text);
  }

  void countPieces() {
    std::vector<LineCounts> own(pieces_.size());
    threads_.forEach(static_cast<std::int64_t>(own.size()),
                     [&](std::int64_t p, int) { own[p] = countLines(pieces_[p]); });
    const std::int64_t before = ranks_.sumBefore({static_cast<std::int64_t>(own.size())}).front();
    Begin begin;
    std::int64_t piece = 0;
    for (const LineCounts& counts : ranks_.gatherAll(own)) {
      if (piece >= before && piece < before + static_cast<std::int64_t>(own.size())) begins_.push_back(begin);
      begin.pass(counts);
      if (++piece <= before) firstCell_ = begin.cells;
    }
    found_ = begin.cells;
    for (std::size_t p = 0; p < own.size(); ++p)
      toRead_.push_back(std::clamp<std::int64_t>(announced_ - begins_[p].cells, 0, own[p].cells));
  }

  void readPieces(PosShare& share) {
    share.first = std::min(firstCell_, announced_);
    std::vector<std::int64_t> at;
    std::int64_t cells = 0;
    for (const std::int64_t count : toRead_) {
      at.push_back(cells);
      cells += count;
    }
    share.lines.resize(static_cast<std::size_t>(cells));
    std::vector<Oddities> found(pieces_.size());
    threads_.forEach(static_cast<std::int64_t>(pieces_.size()), [&](std::int64_t p, int) {
      PosLines piece(file_.string(), pieces_[p], begins_[p].line, begins_[p].blankSince);
      piece.readCells(toRead_[p], share.lines.data() + at[p]);
      found[p] = piece.oddities();
    });
    for (const Oddities& some : found) add(some);
  }

  void add(const Oddities& later) {
    oddities_.spacing.add(later.spacing);
    oddities_.windows.add(later.windows);
    oddities_.blankLines.add(later.blankLines);
  }

  const std::filesystem::path& file_;
  const Communicator& ranks_;
  const Threads& threads_;
  std::string content_;                   ///< this rank's lines
  std::vector<std::string_view> pieces_;  ///< of them, without the first line of the file
  std::vector<Begin> begins_;             ///< of the pieces
  std::vector<std::int64_t> toRead_;      ///< cells of the pieces
  std::int64_t announced_ = 0, found_ = 0, firstCell_ = 0;
  Oddities oddities_;
};

}  // namespace

std::vector<PosLine> readPos(const std::filesystem::path& file, std::vector<std::string>* warnings) {
  return readPosShare(file, Communicator(), Threads(), warnings).lines;
}

PosShare readPosShare(const std::filesystem::path& file, const Communicator& ranks, const Threads& threads,
                      std::vector<std::string>* warnings) {
  PosReader reader(file, ranks, threads);
  PosShare share = reader.read();
  if (warnings) reader.report(*warnings);
  return share;
}

}  // namespace packmesh::hemocell
