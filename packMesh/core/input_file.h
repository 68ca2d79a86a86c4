// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Files named by the user. Those that a run has read are recorded, so that no output replaces one.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace packmesh {

/// True if `file` exists, or if that cannot be determined (reading it then gives the reason).
bool isThere(const std::filesystem::path& file);

/// @param expected what the file should be, for the message: "a mesh file"
/// @throws InputError with the name of the file if it does not exist, is not accessible, or is not a regular
/// file (pipes and devices may have no end)
void requireFile(const std::filesystem::path& file, const std::string& expected);

/// All bytes of a file. @throws InputError like requireFile(), and if reading fails
std::string contentOf(const std::filesystem::path& file, const std::string& expected);

/// The lines that begin in one of `parts` parts of equal length of a file; the first line is in part 0. All
/// parts together are contentOf() the file. @throws InputError likewise
/// @param part from 0
std::string linesOf(const std::filesystem::path& file, const std::string& expected, int part, int parts);

/// A set of files, whatever their names.
class InputFiles;

/// While it exists, the files that this thread reads are recorded; if there is another one already, in that.
class InputRecord {
 public:
  InputRecord();
  ~InputRecord();
  InputRecord(const InputRecord&) = delete;
  InputRecord& operator=(const InputRecord&) = delete;

 private:
  bool outermost_;
};

/// What is recorded now, and will be; nullptr without an InputRecord.
std::shared_ptr<const InputFiles> recordedInputs();

/// Records a file that something else reads.
void recordInput(const std::filesystem::path& file);

/// True if `file` is among them, under this or another name.
bool isInput(const std::filesystem::path& file, const std::shared_ptr<const InputFiles>& inputs);

}  // namespace packmesh
