// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/input_record.h"

#include <sys/stat.h>

#include <optional>
#include <set>
#include <utility>

namespace packmesh {
namespace {

/// Device and number.
using FileId = std::pair<dev_t, ino_t>;

std::optional<FileId> idOf(const std::filesystem::path& file) {
  struct stat info;
  if (::stat(file.c_str(), &info) != 0) return {};
  return FileId(info.st_dev, info.st_ino);
}

thread_local std::shared_ptr<InputFiles> current;

}  // namespace

class InputFiles {
 public:
  std::set<FileId> ids;
};

InputRecord::InputRecord() : outermost_(!current) {
  if (outermost_) current = std::make_shared<InputFiles>();
}
InputRecord::~InputRecord() {
  if (outermost_) current.reset();
}

std::shared_ptr<const InputFiles> recordedInputs() {
  return current;
}

void recordInput(const std::filesystem::path& file) {
  if (!current) return;
  if (const auto id = idOf(file)) current->ids.insert(*id);
}

bool isInput(const std::filesystem::path& file, const std::shared_ptr<const InputFiles>& inputs) {
  if (!inputs) return false;
  const auto id = idOf(file);
  return id && inputs->ids.count(*id) > 0;
}

}  // namespace packmesh
