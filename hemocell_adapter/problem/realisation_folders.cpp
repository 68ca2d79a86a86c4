// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/realisation_folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>
#include <utility>

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view prefix = "realisation_";

std::optional<std::int64_t> numberOf(const std::string& folder) {
  if (folder.compare(0, prefix.size(), prefix) != 0) return {};
  const char *begin = folder.data() + prefix.size(), *end = folder.data() + folder.size();
  std::int64_t number = 0;
  const auto [at, error] = std::from_chars(begin, end, number);
  if (error != std::errc() || at != end || number < 1) return {};
  return number;
}

}  // namespace

std::string realisationFolder(std::int64_t i, std::int64_t realisations) {
  return fmt::format("{}{:0{}}", prefix, i, std::to_string(realisations).size());
}

std::vector<fs::path> realisationFoldersIn(const fs::path& folder) {
  std::vector<std::pair<std::int64_t, fs::path>> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const auto number = numberOf(entry.path().filename().string());
    if (number && entry.is_directory(error)) found.emplace_back(*number, entry.path());
  }
  std::sort(found.begin(), found.end());
  std::vector<fs::path> folders;
  for (auto& [number, path] : found) folders.push_back(std::move(path));
  return folders;
}

std::optional<PlaceInSeries> placeInSeries(const fs::path& state, std::optional<std::int64_t> realisations) {
  const fs::path folder = fs::absolute(state).lexically_normal().parent_path();
  const auto number = numberOf(folder.filename().string());
  if (!number) return {};
  if (realisations &&
      (*number > *realisations || folder.filename() != realisationFolder(*number, *realisations)))
    return {};
  std::error_code error;
  const fs::path series = fs::proximate(folder.parent_path(), error);
  return PlaceInSeries{*number, error ? folder.parent_path() : series};
}

}  // namespace packmesh::hemocell
