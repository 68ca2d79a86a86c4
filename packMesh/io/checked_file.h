// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Writing at given positions of a file, with everything read back.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace packmesh {

/// @param error of the operating system; 0: none
/// @throws OutputError "RBC.pos: cannot be written: No space left on device"
[[noreturn]] void failToWrite(const std::filesystem::path& target, const std::string& what, int error);

/// A file of which one process, or each of several, writes parts at given positions.
///
/// Uses the calls of the operating system: Open MPI's MPI_File_write_at_all() reports success if the disk is
/// full (4.1.4).
/// @throws OutputError
class CheckedFile {
 public:
  /// Opens an existing file.
  /// @param target its final name, for messages
  CheckedFile(const std::filesystem::path& file, std::filesystem::path target);
  /// Takes over a descriptor that can be read and written.
  CheckedFile(int descriptor, std::filesystem::path target);
  CheckedFile(const CheckedFile&) = delete;
  CheckedFile& operator=(const CheckedFile&) = delete;
  ~CheckedFile();

  /// @param position of the first byte
  void write(std::int64_t position, std::string_view text);
  /// Flushes to the disk and compares what can be read now with what was written.
  void verify();
  /// @throws OutputError if the file has another size [bytes]
  void requireSize(std::int64_t size) const;
  void close();

  int descriptor() const { return descriptor_; }

 private:
  struct Part {
    std::int64_t position;
    std::size_t length, hash;
  };
  int descriptor_;
  std::filesystem::path target_;
  std::vector<Part> parts_;
};

}  // namespace packmesh
