// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's `<Cell>.pos` files.
#pragma once

#include <filesystem>
#include <vector>

#include "packMesh/geometry/pose.h"

namespace packmesh::hemocell {

/// One line of a .pos file: `x y z a b c`.
struct PosLine {
  Vec3 position = Vec3::Zero();  ///< [µm]
  Vec3 angles = Vec3::Zero();    ///< [degrees] world = Rz(c) Ry(b) Rx(a) v + position
};

/// The map HemoCell applies for this line.
Placement placementOf(const PosLine& line);

/// The line that stands for a pose of scale 1: its numbers are what is written, to the last bit.
PosLine posLineOf(const Pose& pose);

/// Text of a .pos file: count, then a line each, shortest decimal numbers that read back to the same bits,
/// independent of the locale.
std::string formatPos(const std::vector<PosLine>& lines);

/// Reads a .pos file strictly: exactly the announced number of lines with exactly six finite numbers each.
/// @throws InputError with file and line: missing file, bad count, count that disagrees with the lines,
///   comments, extra or missing fields, non-finite numbers
std::vector<PosLine> readPos(const std::filesystem::path& file);

/// Writes text files so that each appears whole or not at all: all are written next to their targets under
/// temporary names, read back and compared, and only then renamed.
/// @throws InputError when a folder is not writable or a disk full; then no target has changed
class AtomicFiles {
 public:
  ~AtomicFiles();  ///< removes what was not committed
  void add(const std::filesystem::path& target, const std::string& text);
  void commit();

 private:
  struct Entry {
    std::filesystem::path target, temporary;
  };
  std::vector<Entry> entries_;
};

}  // namespace packmesh::hemocell
