// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/cell_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/io/sealed_file.h"
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

namespace {

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
        log::info(fmt::format("{}.pos is not written: its cells are deformed{}", problem_.species[s].name,
                              withState_ ? ", and are in " + output_.stateFile->string() : ""));
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
    shared_.take(*preparedResult(packing_, *output_.stateFile, written_));
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

namespace {

/// How cells are packed of which HemoCell keeps all: those of .pos files with closed ends, where that is
/// possible.
std::string remedyOfDropped(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const std::string plugIn = "the plug-in (packmesh::loadParticles) keeps all of them";
  const bool needsPeriod = packing.before || problem.request.inColumns ||
                           std::any_of(problem.species.begin(), problem.species.end(),
                                       [](const CellSpecies& species) { return !species.fixed.empty(); });
  if (needsPeriod) return plugIn;
  return fmt::format("{} packs cells that it keeps, {}",
                     problem.request.packCellsConventions ? named("keep-all") + " (or the name packMesh)"
                                                          : named("ends", "closed"),
                     plugIn);
}

/// For cells that cross periodic faces.
void warnOfDropped(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const auto sum = [](const std::vector<std::int64_t>& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  };
  log::warning(fmt::format(
      "HemoCell would keep {} of {} cells, a hematocrit of {:.4f}: it silently deletes cells that cross a "
      "periodic face when it loads them from .pos files; {}",
      sum(packing.kept.kept), sum(packing.tally.counts),
      tallyOf(problem, packing.kept.kept, packing.kept.excess).redMesh / problem.referenceVolume(),
      remedyOfDropped(packing)));
}

/// About .pos files of other packings in the folder.
void warnOfStaleFiles(const Problem& problem, const fs::path& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.path().extension() != ".pos") continue;
    const std::string name = entry.path().stem().string();
    bool ours = false;
    for (const CellSpecies& s : problem.species) ours = ours || (s.name == name && s.mostCells() > 0);
    if (!ours) {
      log::warning(fmt::format(
          "{} is not part of this packing; cells in it may overlap the new ones. Remove it unless it "
          "is intended",
          entry.path().string()));
    }
  }
}

}  // namespace

void warnOfCellFiles(const Packing& packing, const fs::path& folder) {
  if (!packing.kept.reasons.empty()) warnOfDropped(packing);
  warnOfStaleFiles(*packing.problem, folder);
}

}  // namespace packmesh::hemocell
