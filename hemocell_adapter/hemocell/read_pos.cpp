// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/read_pos.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_lines.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
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
