// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/held_signals.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/exports.h"
#include "hemocell_adapter/output/pictured_cell.h"
#include "hemocell_adapter/output/report.h"
#include "hemocell_adapter/output/report_page.h"
#include "hemocell_adapter/output/shared_files.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/vtp_output.h"
#include "packMesh/analysis/share_measures.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/input_record.h"
#include "packMesh/io/atomic_files.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

fs::path positionsOf(const Job& job, const CellSpecies& species) {
  return job.outputDirectory / (species.name + ".pos");
}

/// The cells of all ranks in the form needed for pictures; on the first rank.
std::vector<PicturedCell> allCells(const Finished& done, const CellMeasures& measures) {
  struct Cell {
    double linear[9], translation[3], gap, localHematocrit;
    int species;
  };
  std::vector<Cell> own;
  for (std::size_t i = 0; i < done.result.cells.size(); ++i) {
    const PlacedCell& cell = done.result.cells[i];
    Cell plain{};
    Eigen::Map<Mat3>(plain.linear) = cell.placement.linear;
    Eigen::Map<Vec3>(plain.translation) = cell.placement.translation;
    plain.species = cell.species;
    plain.gap = measures.gap[i];
    plain.localHematocrit = measures.localHematocrit[i];
    own.push_back(plain);
  }
  std::vector<PicturedCell> cells;
  done.ranks.visitInOrder(own, [&](const std::vector<Cell>& part) {
    for (const Cell& c : part)
      cells.push_back({{c.species, {Eigen::Map<const Mat3>(c.linear), Eigen::Map<const Vec3>(c.translation)}},
                       c.gap,
                       c.localHematocrit});
  });
  return cells;
}

void writeReports(const Finished& done, const Report& report, const std::vector<PicturedCell>& cells) {
  AtomicFiles files;
  const fs::path json = fs::path(*done.scene.reportFile).replace_extension(".json");
  files.add(json, jsonText(report));
  if (json != *done.scene.reportFile) files.add(*done.scene.reportFile, pageText(report, done, cells));
  files.commit();
}

/// Whether an output that was read keeps its content: the state that the run continues, or the file of a
/// species whose cells are all fixed and are written as they stand there.
bool replacesItself(const Scene& scene, const fs::path& file) {
  if (scene.restart && scene.stateFile == file) return fs::equivalent(file, *scene.restart);
  const Box bounds = scene.lumen.container->bounds();
  const Vec3 period = scene.lumen.container->period();
  for (const CellSpecies& species : scene.species) {
    if (positionsOf(scene, species) != file || species.fixed.empty()) continue;
    for (const PosLine& line : species.fixed)  // others are written as their images inside
      for (int k = 0; k < 3; ++k)
        if (period[k] > 0.0 && !(line.position[k] >= bounds.lo[k] && line.position[k] < bounds.hi[k]))
          return false;
    return static_cast<std::int64_t>(species.fixed.size()) == species.mostCells() &&
           contentOf(file, "a .pos file") ==
               formatPosHead(species.mostCells()) + formatPosLines(species.fixed);
  }
  return false;
}

}  // namespace

AnalysisInput analysisInputOf(const Finished& done) {
  const Scene& scene = done.scene;
  AnalysisInput input;
  for (const CellSpecies& species : scene.species) {
    input.shapes.push_back(species.shape.get());
    input.inHematocrit.push_back(species.redCell);
  }
  input.container = scene.lumen.container.get();
  input.communicator = done.ranks;
  input.threads = scene.team;
  for (const MisplacedCell& cell : done.result.certificate.misplaced)
    if (!(cell.gap > 0.0)) input.outside.insert(cell.cell);
  return input;
}

std::string reportText(const Finished& done, const RunTimes& times) {
  const AnalysisInput analysis = analysisInputOf(done);
  const CellMeasures measures = measureShare(analysis, done.result.cells);
  return jsonText(makeReport(
      done, measurePacking(analysis, done.result.cells, measures.gap, endAxes(done.scene)), times));
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
  const HeldSignals held;  // until the file is removed
  std::string probe = (existing / ".packMesh_XXXXXX").string();
  const int file = mkstemp(probe.data());
  if (file < 0)
    throw OutputError(
        fmt::format("{}: the folder is not writable ({})", existing.string(), std::strerror(errno)));
  close(file);
  unlink(probe.c_str());
}

void requireWritableOutputs(const Scene& scene, bool withCells) {
  std::vector<fs::path> files = viewFiles(scene);
  if (withCells)
    for (const CellSpecies& species : scene.species)
      if (species.mostCells() > 0) files.push_back(positionsOf(scene, species));
  for (const fs::path& file : files) requireReplaceable(file);
  std::vector<std::int64_t> counts;
  for (const CellSpecies& species : scene.species) counts.push_back(species.mostCells());
  for (const ExportedFile& exported : exportedFiles(scene, counts))
    files.push_back(scene.outputDirectory / exported.name);
  if (scene.stateFile) files.push_back(*scene.stateFile);
  if (scene.stateFile && companionOf(*scene.stateFile) != *scene.stateFile)
    files.push_back(companionOf(*scene.stateFile));
  std::set<fs::path> known;
  for (const fs::path& file : files) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(fs::absolute(file, error), error);
    if (error) throw OutputError(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
    if (isInput(file, scene.inputs) && !replacesItself(scene, file))
      throw OutputError(fmt::format(
          "{}: is read by this run and would be overwritten; write into another folder (--output-dir), or "
          "under another name",
          file.string()));
    if (!known.insert(real).second)
      throw OutputError(fmt::format(
          "{}: two outputs have this name (report, state with its .xdmf, pictures, cells)", file.string()));
  }
}

void warnOfStaleFiles(const Scene& scene) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(scene.outputDirectory, ignored)) {
    if (entry.path().extension() != ".pos") continue;
    const std::string name = entry.path().stem().string();
    bool ours = false;
    for (const CellSpecies& s : scene.species) ours = ours || (s.name == name && s.mostCells() > 0);
    if (!ours) {
      log::warning(fmt::format(
          "{} is not part of this packing; cells in it may overlap the new ones. Remove it unless it "
          "is intended",
          entry.path().string()));
    }
  }
}

std::vector<fs::path> viewFiles(const Scene& scene) {
  std::vector<fs::path> files = vtpFiles(scene);
  if (scene.reportFile) {
    files.push_back(*scene.reportFile);
    const fs::path json = fs::path(*scene.reportFile).replace_extension(".json");
    if (json != *scene.reportFile) files.push_back(json);
  }
  return files;
}

void writeViews(const Finished& done, const RunTimes& times) {
  const Scene& scene = done.scene;
  const Communicator& ranks = done.ranks;
  const std::vector<fs::path> views = viewFiles(scene);
  if (views.empty()) return;
  const AnalysisInput analysis = analysisInputOf(done);
  const CellMeasures measures = measureShare(analysis, done.result.cells);
  if (!vtpFiles(scene).empty()) writeVtp(done, measures);
  if (scene.reportFile) {
    SharedFiles(ranks).makeFolder(scene.reportFile->parent_path());
    std::vector<PicturedCell> cells;
    if (scene.reportFile->extension() == ".html") cells = allCells(done, measures);
    const PackingMeasures all = measurePacking(analysis, done.result.cells, measures.gap, endAxes(scene));
    onFirstRank(ranks, [&] { writeReports(done, makeReport(done, all, times), cells); });
  }
  for (const fs::path& file : views) log::info(fmt::format("Wrote {}", file.string()));
  if (scene.povScene)
    log::info(fmt::format("For a picture: python3 -m packmesh render {}", scene.outputDirectory.string()));
}

}  // namespace packmesh::hemocell
