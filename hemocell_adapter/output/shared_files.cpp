// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/shared_files.h"

#include <fmt/format.h>

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
  const bool first = ranks_.rank() == 0;
  file_.emplace(first ? files_.temporary() : std::filesystem::path(),
                first ? files_.target() : std::filesystem::path(), ranks_);
  size_ = 0;
}

void SharedFiles::append(const std::function<std::string()>& text) {
  std::vector<std::string> own;
  onFirstRank(ranks_, [&] {
    if (ranks_.rank() == 0) own.push_back(text());
  });
  appendParts(own);
}

void SharedFiles::appendParts(std::string own) {
  appendParts(std::vector<std::string>{std::move(own)});
}

void SharedFiles::appendParts(const std::vector<std::string>& own) {
  size_ = file_->write(size_, {own.begin(), own.end()});
  together(ranks_, [&] { file_->requireGood(); });
}

void SharedFiles::end() {
  file_->close();
  together(ranks_, [&] { file_->requireGood(); });
  file_.reset();
  onFirstRank(ranks_, [&] {
    files_.skipTo(size_);
    files_.end();
  });
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
