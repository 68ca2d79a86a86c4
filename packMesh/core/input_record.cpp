// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/input_record.h"

#include <sys/stat.h>

#include <optional>
#include <set>
#include <utility>

namespace packmesh {
namespace {

/// Device and number: the identity of a file, whatever its names.
using FileId = std::pair<dev_t, ino_t>;

thread_local std::optional<std::set<FileId>> recorded;

std::optional<FileId> idOf(const std::filesystem::path& file) {
  struct stat info;
  if (::stat(file.c_str(), &info) != 0) return {};
  return FileId(info.st_dev, info.st_ino);
}

}  // namespace

InputRecord::InputRecord() {
  recorded.emplace();
}
InputRecord::~InputRecord() {
  recorded.reset();
}

void recordInput(const std::filesystem::path& file) {
  if (!recorded) return;
  if (const auto id = idOf(file)) recorded->insert(*id);
}

bool isRecordedInput(const std::filesystem::path& file) {
  if (!recorded) return false;
  const auto id = idOf(file);
  return id && recorded->count(*id) > 0;
}

}  // namespace packmesh
