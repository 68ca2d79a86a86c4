// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lines of a .pos file, read strictly. Internal to readPos().
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/pos_file.h"

namespace packmesh::hemocell {

/// Something that HemoCell reads but other tools may not: number of occurrences, and the first one.
struct Oddity {
  std::int64_t count = 0, firstLine = 0;
  void note(std::int64_t line) {
    if (count++ == 0) firstLine = line;
  }
  /// Adds those of later lines.
  void add(const Oddity& later) {
    if (count == 0) firstLine = later.firstLine;
    count += later.count;
  }
};
struct Oddities {
  Oddity spacing, windows, blankLines;
};

/// Whole lines of a file.
struct LineCounts {
  std::int64_t lines = 0;
  std::int64_t cells = 0;     ///< lines that are not blank
  std::int64_t blankEnd = 0;  ///< blank lines after the last of these
};
LineCounts countLines(std::string_view text);
bool isBlank(std::string_view text);

/// Reads successive whole lines of a file.
class PosLines {
 public:
  /// @param file its name, for messages
  /// @param line number of the first line, from 1
  /// @param blankSince number of the first of the blank lines that precede it, 0: none
  PosLines(std::string file, std::string_view text, std::int64_t line, std::int64_t blankSince)
      : file_(std::move(file)), text_(text), line_(line - 1), firstBlank_(blankSince) {}

  /// The next line, with the number of cells. @throws InputError
  std::int64_t readCount();
  /// The cells of the next `count` lines that are not blank. Pre: there are as many. @throws InputError
  void readCells(std::int64_t count, PosLine* to);

  const Oddities& oddities() const { return oddities_; }
  /// The text after the lines read.
  std::string_view rest() const { return text_; }

 private:
  [[noreturn]] void fail(const std::string& what) const;
  std::string_view nextLine();
  PosLine lineOf(const std::vector<std::string_view>& fields) const;

  std::string file_;
  std::string_view text_;
  std::int64_t line_, firstBlank_;
  Oddities oddities_;
};

}  // namespace packmesh::hemocell
