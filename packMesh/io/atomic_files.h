// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Atomic writing of files: a file appears completely or not at all.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace packmesh {

/// `.<name>~<host>.<process>-<number>.<kind>` next to `target`: unique to this process and short enough for
/// every file system; a long target name is replaced by a hash.
std::filesystem::path temporaryName(const std::filesystem::path& target, int number, const std::string& kind);

/// True if `file` is a temporary file of `target`, of any process.
bool isTemporaryOf(const std::filesystem::path& file, const std::filesystem::path& target,
                   const std::string& kind);

/// True if `file` is a temporary file of a process of this machine that has ended.
bool isAbandoned(const std::filesystem::path& file, const std::string& kind);

/// The name of a lock on `target`, next to it.
std::filesystem::path lockName(const std::filesystem::path& target);

/// Name of this machine and id of this process: "node7", 4711.
std::string hostName();
long processNumber();

/// @param error of the operating system; 0: none
/// @throws OutputError "RBC.pos: cannot be written: No space left on device"
[[noreturn]] void failToWrite(const std::filesystem::path& target, const std::string& what, int error);

/// @throws OutputError if `target` exists and cannot be replaced by a file
void requireReplaceable(const std::filesystem::path& target);

/// Writes files so that each appears completely or not at all: all are written under temporary names next to
/// their targets, flushed to the disk, and only then renamed. Where there are several, all that
/// they replace is renamed first: if the process is killed meanwhile, some files are missing, but no new one
/// stands beside an old one.
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
  void append(std::string_view text) { write(size_, text); }
  /// Writes into it from a position on [bytes].
  void write(std::int64_t position, std::string_view text);
  /// The name of the file begun last until it is committed.
  const std::filesystem::path& temporary() const { return entries_.back().temporary; }
  const std::filesystem::path& target() const { return entries_.back().target; }
  /// Flushes the file begun last to the disk.
  void end();

  void add(const std::filesystem::path& target, const std::string& text) {
    begin(target);
    append(text);
    end();
  }
  /// An existing file that does not belong to the new ones gets another name in its folder when they are
  /// committed. @throws OutputError if that name is one of a folder
  void putAside(const std::filesystem::path& file, const std::filesystem::path& as);
  /// Adds the files of another object, which are ended, behind those of this one.
  void take(AtomicFiles& others);
  /// Renames all files to their targets; if one fails, those already renamed are restored.
  void commit();

 private:
  struct Entry {
    std::filesystem::path target, temporary;
    std::optional<mode_t> mode;        ///< of the file that it replaces
    std::filesystem::path aside = {};  ///< new name of the target, for which there is no new file
  };
  std::vector<Entry> entries_;
  int descriptor_ = -1;    ///< of the one begun last, until it is ended
  std::int64_t size_ = 0;  ///< of it [bytes]
};

}  // namespace packmesh
