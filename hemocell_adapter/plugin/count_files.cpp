// SPDX-License-Identifier: AGPL-3.0-or-later
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <optional>

#include "hemocell_adapter/base/log.h"
#include "packMesh/hemocell_system.h"

namespace packmesh::plugin {
namespace {

namespace fs = std::filesystem;

struct PosHead {
  std::int64_t count = -1;  ///< as HemoCell reads it; negative: no number
  bool onlyCount = false;   ///< nothing follows
};

std::optional<PosHead> headOf(const fs::path& file) {
  std::ifstream in(file);
  if (!in) return {};
  PosHead head;
  std::string next;
  if (!(in >> head.count)) head.count = -1;
  head.onlyCount = head.count >= 0 && !(in >> next);
  return head;
}

bool written(const fs::path& file, std::int64_t count) {
  std::ofstream out(file);
  out << count << '\n';
  return bool(out.flush());
}

}  // namespace

void writeCounts(const std::vector<std::string>& names, const std::vector<std::int64_t>& counts,
                 const std::string& checkpointFolder, bool periodic) {
  const fs::path folder = checkpointFolder;
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  const bool earlier = fs::exists(folder / "checkpoint.xml", ignored);  // the checkpoint of another run
  std::string unwritten, other, kept;
  const auto add = [](std::string& list, const std::string& item) {
    list += (list.empty() ? "" : ", ") + item;
  };
  for (std::size_t t = 0; t < names.size(); ++t) {
    const fs::path here = names[t] + ".pos";
    for (const fs::path& file : {here, folder / here}) {
      const std::optional<PosHead> head = headOf(file);
      if (head && head->count == counts[t]) continue;
      if (head && !head->onlyCount) {
        add(other, head->count < 0 ? fmt::format("{} has no number of cells", file.string())
                                   : fmt::format("{} announces {}, {} were added", file.string(), head->count,
                                                 counts[t]));
        continue;
      }
      if (head && earlier && file != here) {
        const fs::path old = file.string() + ".old";
        fs::rename(file, old, ignored);
        add(kept, old.string());
      }
      if (!written(file, counts[t])) add(unwritten, file.string());
    }
  }
  if (!kept.empty())
    hemocell::log::warning(
        fmt::format("{} has a checkpoint of another run, whose numbers of cells are now in {}: to restart "
                    "from it, rename "
                    "them back",
                    folder.string(), kept));
  if (!unwritten.empty())
    hemocell::log::warning(fmt::format(
        "Cannot write {} with the number of cells: a restart would delete cells across periodic faces",
        unwritten));
  if (!other.empty() && periodic)
    hemocell::log::warning(
        fmt::format("HemoCell takes the number of cells from .pos files when it loads a checkpoint ({}). "
                    "hemocell.loadCheckPoint() would delete the cells across periodic faces: call "
                    "packmesh::loadCheckPoint(hemocell) "
                    "instead, or remove the files",
                    other));
}

}  // namespace packmesh::plugin
