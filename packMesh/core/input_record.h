// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The files that a run has read, so that no output replaces one of them.
#pragma once

#include <filesystem>
#include <memory>

namespace packmesh {

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

/// Records a file that something else than input_file.h reads.
void recordInput(const std::filesystem::path& file);

/// True if `file` is among them, under this or another name.
bool isInput(const std::filesystem::path& file, const std::shared_ptr<const InputFiles>& inputs);

}  // namespace packmesh
