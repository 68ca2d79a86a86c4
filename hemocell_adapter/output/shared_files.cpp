// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/shared_files.h"

#include <fmt/format.h>

#include <optional>
#include <string_view>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/ranks.h"
#include "packMesh/io/file_hash.h"

namespace packmesh::hemocell {

void SharedFiles::makeFolder(const std::filesystem::path& folder) {
  onFirstRank(ranks_, [&] {
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
      throw OutputError(
          fmt::format("{}: the folder cannot be created: {}", folder.string(), error.message()));
  });
}

void SharedFiles::begin(const std::filesystem::path& target) {
  onFirstRank(ranks_, [&] { files_.begin(target); });
}

void SharedFiles::append(const std::function<std::string()>& text) {
  onFirstRank(ranks_, [&] { files_.append(text()); });
}

void SharedFiles::appendParts(const std::vector<std::string>& own) {
  std::optional<OutputError> error;
  ranks_.streamToFirst({own.begin(), own.end()}, [&](std::string_view part) {
    try {
      if (!error) files_.append(part);
    } catch (const OutputError& failure) {
      error = failure;
    }
  });
  onFirstRank(ranks_, [&] {
    if (error) throw *error;
  });
}

void SharedFiles::end() {
  onFirstRank(ranks_, [&] { files_.end(); });
}

void SharedFiles::take(AtomicFiles& others) {
  onFirstRank(ranks_, [&] { files_.take(others); });
}

std::string SharedFiles::hash() {
  return ranks_.broadcast(ranks_.rank() == 0 ? fileHash(files_.temporary()) : std::string(), 0);
}

void SharedFiles::commit() {
  onFirstRank(ranks_, [&] { files_.commit(); });
}

}  // namespace packmesh::hemocell
