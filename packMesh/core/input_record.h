// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The files that a run has read, so that no output replaces one of them.
#pragma once

#include <filesystem>

namespace packmesh {

/// While it exists, the files that this thread reads are recorded. One at a time.
class InputRecord {
 public:
  InputRecord();
  ~InputRecord();
  InputRecord(const InputRecord&) = delete;
  InputRecord& operator=(const InputRecord&) = delete;
};

/// Records a file that something else than input_file.h reads.
void recordInput(const std::filesystem::path& file);

/// True if `file` is recorded, under this or another name.
bool isRecordedInput(const std::filesystem::path& file);

}  // namespace packmesh
