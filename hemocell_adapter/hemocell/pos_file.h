// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's `<Cell>.pos` files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "packMesh/core/pose.h"

namespace packmesh::hemocell {

/// One line of a .pos file: `x y z a b c`.
struct PosLine {
  Vec3 position = Vec3::Zero();  ///< [µm]
  Vec3 angles = Vec3::Zero();    ///< [degrees] world = Rz(c) Ry(b) Rx(a) v + position
};

/// The map HemoCell applies for this line to the vertices of the centred template.
Placement placementOf(const PosLine& line);

/// The line that stands for a pose of scale 1: its numbers are what is written, to the last bit. Angles lie
/// in
/// [-180, 180], b in [-90, 90]; at b = ±90, where only a∓c is defined, the pair chosen still maps every
/// vector to within rounding. Pre: finite pose.
PosLine posLineOf(const Pose& pose);

/// The pose of a cell at this line.
Pose poseOf(const PosLine& line);

/// Text of a .pos file, or of a part of it: a line each, shortest decimal numbers that read back to the same
/// bits, independent of the locale; single spaces, no trailing space, `\n`. Pre: finite numbers.
std::string formatPosLines(const std::vector<PosLine>& lines);
/// What comes before them.
std::string formatPosHead(std::int64_t count);

/// Reads what HemoCell reads of a .pos file, strictly: the announced number of lines with exactly six finite
/// numbers each. Lines beyond them are left out.
/// @param warnings if given, receives a line for what is left out, and for everything HemoCell reads but
/// other
///   tools do not: tabs, repeated, leading or trailing spaces (pos_to_vtk drops such lines), Windows line
///   ends, blank lines
/// @throws InputError with file and line: missing file, bad count, fewer lines than announced, comments,
///   extra or missing fields, numbers that are not finite or absurdly large
std::vector<PosLine> readPos(const std::filesystem::path& file, std::vector<std::string>* warnings = nullptr);

/// @throws InputError when `target` exists, but not as a file that may be replaced
void requireReplaceable(const std::filesystem::path& target);

/// Writes text files so that each appears whole or not at all: all are written next to their targets under
/// temporary names, read back and compared, and only then renamed.
///
/// An existing target keeps its permissions; a target that is a symbolic link is written where it points.
/// @throws InputError when a folder is not writable or a disk full; then no target has changed
class AtomicFiles {
 public:
  AtomicFiles() = default;
  AtomicFiles(const AtomicFiles&) = delete;
  AtomicFiles& operator=(const AtomicFiles&) = delete;
  ~AtomicFiles();  ///< removes what was not committed

  /// Begins a file, under a temporary name.
  void begin(const std::filesystem::path& target);
  /// Adds to the file begun last.
  void append(const std::string& text);
  /// Flushes the file begun last to the disk and reads it back.
  void end();

  void add(const std::filesystem::path& target, const std::string& text) {
    begin(target);
    append(text);
    end();
  }
  /// Puts all files in place; when one cannot be, those already in place are put back as they were.
  void commit();

 private:
  struct Entry {
    std::filesystem::path target, temporary;
  };
  struct Part {
    std::size_t length, hash;
  };
  std::vector<Entry> entries_;
  int open_ = -1;            ///< descriptor of the file begun last
  std::vector<Part> parts_;  ///< of it, as they are to be read back
};

}  // namespace packmesh::hemocell
