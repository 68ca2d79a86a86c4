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

fs::path positionsOf(const OutputRequest& output, const CellSpecies& species) {
  return output.folder / (species.name + ".pos");
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
  done.ranks().visitInOrder(own, [&](const std::vector<Cell>& part) {
    for (const Cell& c : part)
      cells.push_back({{c.species, {Eigen::Map<const Mat3>(c.linear), Eigen::Map<const Vec3>(c.translation)}},
                       c.gap,
                       c.localHematocrit});
  });
  return cells;
}

void writeReports(const Finished& done, const Report& report, const std::vector<PicturedCell>& cells) {
  AtomicFiles files;
  const fs::path json = fs::path(*done.output.reportFile).replace_extension(".json");
  files.add(json, jsonText(report));
  if (json != *done.output.reportFile) files.add(*done.output.reportFile, pageText(report, done, cells));
  files.commit();
}

/// Whether an output that was read keeps its content: the state that the run continues, or the file of a
/// species whose cells are all fixed and are written as they stand there.
bool replacesItself(const Problem& problem, const OutputRequest& output, const fs::path& file) {
  if (problem.request.restart && output.stateFile == file)
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
           contentOf(file, "a .pos file") ==
               formatPosHead(species.mostCells()) + formatPosLines(species.fixed);
  }
  return false;
}

}  // namespace

AnalysisInput analysisInputOf(const Finished& done) {
  const Problem& problem = done.problem;
  AnalysisInput input;
  for (const CellSpecies& species : problem.species) {
    input.shapes.push_back(species.shape.get());
    input.inHematocrit.push_back(species.redCell);
  }
  input.container = problem.lumen.container.get();
  input.communicator = done.ranks();
  input.threads = problem.team;
  for (const MisplacedCell& cell : done.result.certificate.misplaced)
    if (!(cell.gap > 0.0)) input.outside.insert(cell.cell);
  return input;
}

std::string reportText(const Finished& done, const RunTimes& times) {
  const AnalysisInput analysis = analysisInputOf(done);
  const CellMeasures measures = measureShare(analysis, done.result.cells);
  return jsonText(makeReport(
      done, measurePacking(analysis, done.result.cells, measures.gap, endAxes(done.problem)), times));
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

void requireWritableOutputs(const Problem& problem, const OutputRequest& output, bool withCells) {
  std::vector<fs::path> files = viewFiles(problem, output);
  if (withCells)
    for (const CellSpecies& species : problem.species)
      if (species.mostCells() > 0) files.push_back(positionsOf(output, species));
  for (const fs::path& file : files) requireReplaceable(file);
  std::vector<std::int64_t> counts;
  for (const CellSpecies& species : problem.species) counts.push_back(species.mostCells());
  for (const ExportedFile& exported : exportedFiles(problem, output.exports, counts))
    files.push_back(output.folder / exported.name);
  if (output.stateFile) files.push_back(*output.stateFile);
  if (output.stateFile && companionOf(*output.stateFile) != *output.stateFile)
    files.push_back(companionOf(*output.stateFile));
  std::set<fs::path> known;
  for (const fs::path& file : files) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(fs::absolute(file, error), error);
    if (error) throw OutputError(fmt::format("{}: cannot be written: {}", file.string(), error.message()));
    if (isInput(file, problem.inputs) && !replacesItself(problem, output, file))
      throw OutputError(fmt::format(
          "{}: is read by this run and would be overwritten; write into another folder (--output-dir), or "
          "under another name",
          file.string()));
    if (!known.insert(real).second)
      throw OutputError(fmt::format(
          "{}: two outputs have this name (report, state with its .xdmf, pictures, cells)", file.string()));
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

std::vector<fs::path> viewFiles(const Problem& problem, const OutputRequest& output) {
  std::vector<fs::path> files = vtpFiles(problem, output);
  if (output.reportFile) {
    files.push_back(*output.reportFile);
    const fs::path json = fs::path(*output.reportFile).replace_extension(".json");
    if (json != *output.reportFile) files.push_back(json);
  }
  return files;
}

void writeViews(const Finished& done, const RunTimes& times) {
  const Problem& problem = done.problem;
  const OutputRequest& output = done.output;
  const Communicator& ranks = done.ranks();
  const std::vector<fs::path> views = viewFiles(problem, output);
  if (views.empty()) return;
  const AnalysisInput analysis = analysisInputOf(done);
  const CellMeasures measures = measureShare(analysis, done.result.cells);
  if (!vtpFiles(problem, output).empty()) writeVtp(done, measures);
  if (output.reportFile) {
    SharedFiles(ranks).makeFolder(output.reportFile->parent_path());
    std::vector<PicturedCell> cells;
    if (output.reportFile->extension() == ".html") cells = allCells(done, measures);
    const PackingMeasures all = measurePacking(analysis, done.result.cells, measures.gap, endAxes(problem));
    onFirstRank(ranks, [&] { writeReports(done, makeReport(done, all, times), cells); });
  }
  for (const fs::path& file : views) log::info(fmt::format("Wrote {}", file.string()));
  if (output.povScene)
    log::info(fmt::format("For a picture: python3 -m packmesh render {}", output.folder.string()));
}

}  // namespace packmesh::hemocell
