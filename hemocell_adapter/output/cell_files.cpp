// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/cell_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/files_of_state.h"
#include "hemocell_adapter/output/shared_files.h"
#include "hemocell_adapter/output/state_files.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

class CellFiles {
 public:
  CellFiles(const Packing& packing, const OutputRequest& output, bool withState)
      : packing_(packing),
        problem_(*packing.problem),
        output_(output),
        withState_(withState),
        deformed_(deformedCounts(problem_, packing.cells)),
        shared_(problem_.ranks) {}

  std::vector<fs::path> operator()() {
    write(output_.folder, Vec3::Zero());
    for (const OtherLattice& other : problem_.lumen.others)
      if (!other.shift.isZero()) write(output_.folder / fmt::format("dx_{:.15g}", other.dx), other.shift);
    onFirstRank(problem_.ranks, [&] { putOldAside(); });
    if (withState_) addState();
    shared_.commit();
    for (const auto& [file, now] : aside_)
      log::warning(fmt::format("{} is of an earlier packing: renamed to {}", file.string(), now.string()));
    return paths_;
  }

 private:
  /// @param shift of the frame of the files [µm]
  void write(const fs::path& folder, const Vec3& shift) {
    shared_.makeFolder(folder);
    for (std::size_t s = 0; s < problem_.species.size(); ++s) {
      const fs::path file = folder / (problem_.species[s].name + ".pos");
      if (problem_.species[s].mostCells() == 0) {
        old_.insert(file);
        continue;
      }
      if (deformed_[s] > 0) {
        log::info(fmt::format(
            "{0}.pos is not written: it cannot have cells with meshes of their own{1}",
            problem_.species[s].name,
            output_.stateFile
                ? fmt::format("; {0} has them (in the case: packmesh::loadParticles(hemocell, \"{0}\"))",
                              output_.stateFile->string())
                : ""));
        old_.insert(file);
        continue;
      }
      paths_.push_back(file);
      shared_.begin(paths_.back());
      shared_.append([&] { return formatPosHead(packing_.tally.counts[s]); });
      shared_.appendParts(posLines(int(s), shift));
      shared_.end();
      if (withState_ && isBeside(paths_.back(), *output_.stateFile))
        written_[paths_.back().filename().string()] = shared_.hash();
    }
  }

  /// Files of the packing before this one that are not replaced.
  void putOldAside() {
    if (output_.stateFile && isThere(*output_.stateFile)) {
      for (const std::string& name : filesOfState(*output_.stateFile).same)
        old_.insert(output_.folder / name);
      if (!withState_) old_.insert(*output_.stateFile);
    }
    for (const fs::path& file : old_) {
      const bool replaced = std::find(paths_.begin(), paths_.end(), file) != paths_.end();
      if (replaced || !isThere(file) || (file.extension() == ".pos" && !hasCells(file))) continue;
      const fs::path now = file.string() + ".old";
      shared_.putAside(file, now);
      aside_.emplace_back(file, now);
    }
  }

  void addState() {
    shared_.makeFolder(output_.stateFile->parent_path());
    shared_.take(*preparedResult(problem_, *output_.stateFile, {packing_.packed, *packing_.state}, written_));
  }

  /// This rank's lines, in any number of pieces.
  std::vector<std::string> posLines(int species, const Vec3& shift) const {
    std::vector<std::size_t> own;
    for (std::size_t i = 0; i < packing_.cells.size(); ++i)
      if (packing_.cells[i].species == species) own.push_back(i);
    constexpr std::int64_t linesOfPiece = 4096;
    const auto count = static_cast<std::int64_t>(own.size());
    std::vector<std::string> pieces(static_cast<std::size_t>((count + linesOfPiece - 1) / linesOfPiece));
    problem_.team.forEachPart(
        count,
        [&](std::int64_t begin, std::int64_t end, int) {
          std::vector<PosLine> lines;
          for (std::int64_t i = begin; i < end; ++i) {
            lines.push_back(problem_.read->lineOf(packing_.poses[own[i]]));
            lines.back().position += shift;
          }
          pieces[begin / linesOfPiece] = formatPosLines(lines);
        },
        linesOfPiece);
    return pieces;
  }

  const Packing& packing_;
  const Problem& problem_;
  const OutputRequest& output_;
  bool withState_;
  std::vector<std::int64_t> deformed_;  ///< per species: cells with meshes of their own, of all ranks
  std::vector<fs::path> paths_;
  FilesOfState written_;                              ///< those in the folder of the state
  std::set<fs::path> old_;                            ///< may be of an earlier packing
  std::vector<std::pair<fs::path, fs::path>> aside_;  ///< files and their new names, on the first rank
  SharedFiles shared_;
};

}  // namespace

std::vector<fs::path> writeCellFiles(const Packing& packing, const OutputRequest& output, bool withState) {
  return CellFiles(packing, output, withState)();
}

}  // namespace packmesh::hemocell
