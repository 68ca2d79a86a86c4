// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's `<Cell>.pos` files: their lines, written and read strictly, and the lines that were read,
/// kept to write unmoved cells unchanged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "packMesh/core/pose.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/problem/physics.h"

namespace packmesh::hemocell {

/// One line of a .pos file: `x y z a b c`.
struct PosLine {
  Vec3 position = Vec3::Zero();  ///< [µm]
  Vec3 angles = Vec3::Zero();    ///< [degrees] world = Rz(c) Ry(b) Rx(a) v + position
};

/// The map that HemoCell applies to the vertices of the centred template for this line.
Placement placementOf(const PosLine& line);

/// The line that represents a pose of scale 1: its numbers are written as they are, to the last bit. Angles
/// lie in [-180, 180], b in [-90, 90]; at b = ±90, where only a∓c is defined, the pair chosen still maps
/// every vector correctly up to rounding. Pre: finite pose.
PosLine posLineOf(const Pose& pose);

/// The pose represented by a line.
Pose poseOf(const PosLine& line);

/// The line of a cell of a state: with the angles that it has there.
PosLine lineOf(const Cell& cell);

/// Text of a .pos file or of a part of it, one line per cell: shortest decimal numbers that read back to the
/// same bits, independent of the locale; single spaces, no trailing space, `\n`. Pre: finite numbers.
std::string formatPosLines(const std::vector<PosLine>& lines);
/// Text before the lines: the number of cells.
std::string formatPosHead(std::int64_t count);

/// Lines of .pos files that were read: cells that have not moved are written exactly as read.
class ReadLines {
 public:
  void add(const PosLine& line);
  /// The cells of a state that has other lines than those of their poses.
  void add(const std::vector<Cell>& cells);
  /// The line that represents a pose.
  PosLine lineOf(const Pose& pose) const;

 private:
  std::unordered_map<std::string, PosLine> lines_;  ///< key: the bits of the pose
};

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

/// Reads the part of a .pos file that HemoCell reads, strictly: the announced number of lines with exactly
/// six finite numbers each. Further lines are ignored.
/// @param warnings if not null, receives a warning for ignored lines and for everything that HemoCell accepts
/// but other tools do not: tabs, repeated, leading or trailing spaces (pos_to_vtk drops such lines), Windows
/// line ends, blank lines
/// @throws InputError with file and line: missing file, invalid count, fewer lines than announced, comments,
/// extra or missing fields, numbers that are not finite or implausibly large
std::vector<PosLine> readPos(const std::filesystem::path& file, std::vector<std::string>* warnings = nullptr);

/// The cells that one rank has read.
struct PosShare {
  std::vector<PosLine> lines;
  std::int64_t first = 0;  ///< number of the first of them, from 0, among those of the file
  std::int64_t all = 0;    ///< number of cells in the file
};

/// The same for several ranks: each reads about as many bytes as the others, and parses them with its
/// threads. Errors and warnings do not depend on the number of ranks. All ranks call.
/// @throws AgreedFailure on all ranks; InputError if there is a single one
PosShare readPosShare(const std::filesystem::path& file, const Communicator& ranks, const Threads& threads,
                      std::vector<std::string>* warnings = nullptr);

}  // namespace packmesh::hemocell
