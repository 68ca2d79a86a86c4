// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/shared_files.h"

#include <fmt/format.h>

#include <exception>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/ranks.h"

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

void SharedFiles::appendParts(const std::string& own) {
  std::exception_ptr error;
  ranks_.visitInOrder(std::vector<char>(own.begin(), own.end()), [&](const std::vector<char>& part) {
    try {
      if (!error) files_.append(std::string(part.begin(), part.end()));
    } catch (...) {
      error = std::current_exception();
    }
  });
  onFirstRank(ranks_, [&] {
    if (error) std::rethrow_exception(error);
  });
}

void SharedFiles::end() {
  onFirstRank(ranks_, [&] { files_.end(); });
}

void SharedFiles::commit() {
  onFirstRank(ranks_, [&] { files_.commit(); });
}

}  // namespace packmesh::hemocell
