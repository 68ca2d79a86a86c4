// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace packmesh {

/// @throws OutputError when `target` exists, but not as a file that may be replaced
void requireReplaceable(const std::filesystem::path& target);

/// Writes text files so that each appears whole or not at all: all are written next to their targets under
/// temporary names, read back and compared, and only then renamed.
///
/// An existing target keeps its permissions; a target that is a symbolic link is written where it points.
/// @throws OutputError when a folder is not writable or a disk full; then no target has changed
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

}  // namespace packmesh
