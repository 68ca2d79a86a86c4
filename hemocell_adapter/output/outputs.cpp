// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/outputs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/conversions.h"
#include "hemocell_adapter/output/packing_tables.h"
#include "hemocell_adapter/output/report.h"
#include "hemocell_adapter/output/requested_outputs.h"
#include "hemocell_adapter/output/shared_files.h"
#include "packMesh/analysis/share_measures.h"
#include "packMesh/core/input_file.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/packing/write_together.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

fs::path positionsOf(const OutputRequest& output, const CellSpecies& species) {
  return output.folder / (species.name + ".pos");
}

/// The cells that are not wholly inside the lumen, by number.
std::set<std::int64_t> outsideOf(const Certificate& certificate) {
  std::set<std::int64_t> outside;
  for (const MisplacedCell& cell : certificate.misplaced)
    if (!(cell.gap > 0.0)) outside.insert(cell.cell);
  return outside;
}

PackingMeasures packingMeasuresOf(const Packing& packing, const CellMeasures& measures) {
  return measurePacking(physicsOf(*packing.problem), {packing.ranks(), packing.problem->team}, packing.cells,
                        measures.gap, endAxes(*packing.problem), outsideOf(packing.certificate),
                        packing.certificate.gapsMeasuredUpTo);
}

/// Whether an output that was read keeps its content: the state that the run continues, or the file of a
/// species whose cells are all fixed and are written as they stand there.
bool replacesItself(const Problem& problem, const OutputRequest& output, const fs::path& file) {
  if (problem.request.restart && output.stateFile &&
      (file == *output.stateFile || file == checkpointOf(*output.stateFile)))
    return fs::equivalent(file, *problem.request.restart);
  const Box bounds = problem.lumen.container->bounds();
  const Vec3 period = problem.lumen.container->period();
  for (const CellSpecies& species : problem.species) {
    if (positionsOf(output, species) != file || species.fixed.empty()) continue;
    for (const PosLine& line : species.fixed)  // others are written as their images inside
      for (int k = 0; k < 3; ++k)
        if (period[k] > 0.0 && !(line.position[k] >= bounds.lo[k] && line.position[k] < bounds.hi[k]))
          return false;
    return static_cast<std::int64_t>(species.fixed.size()) == species.mostCells() &&
           contentOf(file, "a .pos file") == formatPosHead(species.mostCells()) +
                                                 formatPosLines({species.fixed.begin(), species.fixed.end()});
  }
  return false;
}

}  // namespace

CellMeasures measuresOf(const Packing& packing) {
  return measureShare(physicsOf(*packing.problem), {packing.ranks(), packing.problem->team}, packing.cells,
                      outsideOf(packing.certificate), packing.certificate.gapsMeasuredUpTo);
}

std::string reportText(const Packing& packing) {
  return jsonText(makeReport(packing, packingMeasuresOf(packing, measuresOf(packing))));
}

void saveTables(const Packing& packing, const fs::path& file) {
  SharedFiles(packing.ranks()).makeFolder(file.parent_path());
  commitTogether(writtenTables(file, packing, measuresOf(packing)), packing.ranks());
}

void requireWritable(const fs::path& folder) {
  std::error_code ignored;
  fs::path existing = folder.empty() ? fs::path(".") : fs::absolute(folder, ignored);
  while (!fs::exists(existing, ignored) && existing.has_relative_path()) {
    if (fs::is_symlink(existing, ignored) && fs::status(existing, ignored).type() == fs::file_type::not_found)
      throw OutputError(fmt::format("{}: is a link to {}, which does not exist", existing.string(),
                                    fs::read_symlink(existing, ignored).string()));
    existing = existing.parent_path();
  }
  if (!fs::is_directory(existing, ignored)) {
    throw OutputError(
        fmt::format("{}: is not a folder; the output cannot be written there", existing.string()));
  }
  // Permissions are not conclusive (read-only file systems, system folders): try.
  int file = ::open(existing.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);  // without a name
  if (file < 0 && errno == EOPNOTSUPP) {                                        // by this file system
    std::string probe = (existing / ".packMesh_XXXXXX").string();
    file = ::mkstemp(probe.data());
    if (file >= 0) ::unlink(probe.c_str());
  }
  if (file < 0)
    throw OutputError(
        fmt::format("{}: the folder is not writable ({})", existing.string(), std::strerror(errno)));
  ::close(file);
}

void requireWritableOutputs(const Problem& problem, const OutputRequest& output, bool withCells,
                            const std::vector<fs::path>& others) {
  std::vector<fs::path> files = others;
  if (output.reportFile) files.push_back(reportJson(output));
  if (withCells)
    for (const CellSpecies& species : problem.species)
      if (species.mostCells() > 0) files.push_back(positionsOf(output, species));
  std::vector<std::int64_t> counts;
  for (const CellSpecies& species : problem.species) counts.push_back(species.mostCells());
  for (const fs::path& converted : convertedFiles(problem, output, counts)) files.push_back(converted);
  for (const fs::path& file : files) requireReplaceable(file);
  if (output.stateFile) files.push_back(*output.stateFile);
  if (savesCheckpoints(problem.request, output)) files.push_back(checkpointOf(*output.stateFile));
  std::set<fs::path> known;
  for (const fs::path& file : files) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(fs::absolute(file, error), error);
    if (error) throw OutputError(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
    if (isInput(file, problem.inputs) && !replacesItself(problem, output, file))
      throw OutputError(
          fmt::format("{}: is read by this run and would be overwritten; write into another folder (" +
                          named("output-dir") +
                          "), or "
                          "under another name",
                      file.string()));
    if (!known.insert(real).second)
      throw OutputError(
          fmt::format("{}: two outputs have this name (report, state, pictures, cells)", file.string()));
  }
}

void warnOfStaleFiles(const Problem& problem, const OutputRequest& output) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(output.folder, ignored)) {
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

bool isShowable(const Packing& checked) {
  if (!checked.certificate.moreOverlaps) return true;
  log::warning("so many cells overlap that nothing else is written");
  return false;
}

void writeViews(const Packing& packing) {
  const OutputRequest& output = packing.output;
  if (!output.asksForViews()) return;
  const CellMeasures measures = measuresOf(packing);
  if (output.reportFile) {
    SharedFiles(packing.ranks()).makeFolder(output.reportFile->parent_path());
    const PackingMeasures all = packingMeasuresOf(packing, measures);
    onFirstRank(packing.ranks(), [&] {
      AtomicFiles files;
      files.add(reportJson(output), jsonText(makeReport(packing, all)));
      files.commit();
    });
    log::info(fmt::format("Wrote {}", reportJson(output).string()));
  }
  convert(packing, measures);
  if (output.povScene) log::info(fmt::format("For a picture: packmesh render {}", output.folder.string()));
}

}  // namespace packmesh::hemocell
