// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/files_of_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <system_error>

#include "hemocell_adapter/output/requested_outputs.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/core/error.h"
#include "packMesh/io/file_hash.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

fs::path folderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// The files of a folder with this extension, sorted.
std::vector<fs::path> filesIn(const fs::path& folder, const char* extension) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.path().extension() == extension && entry.is_regular_file(ignored))
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

bool hasCells(const fs::path& posFile) {
  std::error_code ignored;
  if (!fs::is_regular_file(posFile, ignored)) return false;  // a pipe would be read forever
  std::ifstream in(posFile);
  std::string number, more;
  return in >> number >> more && true;
}

bool isBeside(const fs::path& file, const fs::path& other) {
  std::error_code ignored;
  return fs::equivalent(folderOf(file), folderOf(other), ignored);
}

PosFilesBeside filesOfState(const fs::path& state) {
  PosFilesBeside beside;
  FilesOfState written;
  try {
    written = readStateHead(state).files;
  } catch (const InputError&) {
    return beside;
  }
  if (written.empty()) return beside;
  for (const fs::path& file : filesIn(folderOf(state), ".pos")) {
    const std::string name = file.filename().string();
    const auto known = written.find(name);
    if (known != written.end() && known->second == fileHash(file))
      beside.same.push_back(name);
    else if (hasCells(file))
      beside.other.push_back(name);
  }
  return beside;
}

std::vector<std::string> warningsOfTwoRuns(const fs::path& folder) {
  std::vector<std::string> warnings;
  for (const fs::path& state : filesIn(folder, ".h5")) {
    const PosFilesBeside files = filesOfState(state);
    if (files.same.empty() || files.other.empty()) continue;
    warnings.push_back(fmt::format(
        "files of two runs: {} {} written together with {}, {} not; HemoCell would load the cells of both",
        fmt::join(files.same, " and "), files.same.size() == 1 ? "was" : "were", state.string(),
        fmt::join(files.other, " and ")));
  }
  return warnings;
}

}  // namespace packmesh::hemocell
