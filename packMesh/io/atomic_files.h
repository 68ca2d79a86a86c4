// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Atomic writing of files: a file appears completely or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace packmesh {

/// @throws OutputError if `target` exists and cannot be replaced by a file
void requireReplaceable(const std::filesystem::path& target);

/// Writes text files so that each appears completely or not at all: all are written under temporary names
/// next to their targets, read back and compared, and only then renamed.
///
/// An existing target keeps its permissions; if a target is a symbolic link, the file that it points to is
/// replaced.
/// @throws OutputError if a folder is not writable or a disk is full; then no target has changed
class AtomicFiles {
 public:
  AtomicFiles() = default;
  AtomicFiles(const AtomicFiles&) = delete;
  AtomicFiles& operator=(const AtomicFiles&) = delete;
  ~AtomicFiles();  ///< removes files that were not committed

  /// Begins a file under a temporary name.
  void begin(const std::filesystem::path& target);
  /// Appends to the file begun last.
  void append(const std::string& text);
  /// Flushes the file begun last to disk and reads it back.
  void end();

  void add(const std::filesystem::path& target, const std::string& text) {
    begin(target);
    append(text);
    end();
  }
  /// Renames all files to their targets; if one fails, those already renamed are restored.
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
  std::vector<Part> parts_;  ///< its parts, for comparison after reading back
};

}  // namespace packmesh
