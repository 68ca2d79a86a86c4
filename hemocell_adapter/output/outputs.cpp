// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/outputs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/python_command.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/output/report.h"
#include "packMesh/analysis/cell_measures.h"
#include "packMesh/core/input_file.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh::hemocell {
namespace {

/// Some programs simulate only meshes of their own files.
TemplateSource sourceOf(const CellSpecies& species) {
  if (species.kind != CellSpecies::Template::mesh) return {{}, "is not packed from a mesh file"};
  if (species.meshFrame != MeshFrame::file || species.meshScale != 1.0) return {{}, "is turned or scaled"};
  const TriangleMesh own = meshFrom(species.meshFile);
  const std::vector<Vec3>& packed = species.shape->mesh().vertices;
  const Vec3 origin = boundingBox(own).center();
  constexpr double rounding = 1e-9;  // of centring [µm]
  bool same = own.vertices.size() == packed.size();
  for (std::size_t i = 0; same && i < packed.size(); ++i)
    same = (own.vertices[i] - origin - packed[i]).cwiseAbs().maxCoeff() <= rounding;
  if (!same) return {{}, "has been repaired"};
  return {origin, {}};
}

PackingDetails detailsOf(const Problem& problem) {
  PackingDetails details;
  details.lumen = true;
  for (const CellSpecies& species : problem.species) details.templates.push_back(sourceOf(species));
  return details;
}

Physics physicsOf(const Problem& problem, const std::vector<std::int64_t>& counts) {
  Physics physics = physicsOf(problem);
  for (std::size_t s = 0; s < counts.size(); ++s) physics.species[s].count = counts[s];
  return physics;
}

}  // namespace

std::unique_ptr<AtomicFiles> writtenWithoutCells(const std::filesystem::path& file, const Problem& problem,
                                                 const std::vector<std::int64_t>& counts) {
  return writtenPacking(file, physicsOf(problem, counts), {}, detailsOf(problem), {});
}

std::unique_ptr<AtomicFiles> writtenTables(const std::filesystem::path& file, const Packing& packing,
                                           const CellMeasures& measures) {
  const Problem& problem = *packing.problem;
  PackingDetails details;
  together(packing.ranks(), [&] { details = detailsOf(problem); });
  CellColumn angles{"angles", 3, {}};
  for (const Pose& pose : packing.poses) {
    const PosLine line = problem.read->lineOf(pose);
    angles.values.insert(angles.values.end(), line.angles.data(), line.angles.data() + 3);
  }
  details.columns = columnsOf(measures, packing.cells.size());
  for (CellColumn& column : deformationColumns(problem, packing.cells))
    details.columns.push_back(std::move(column));
  details.columns.push_back(std::move(angles));
  return writtenPacking(file, physicsOf(problem, packing.tally.counts), packing, details, packing.ranks());
}

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

fs::path keptTables(const OutputRequest& output) {
  return output.folder / "packing.h5";
}

bool wantsPage(const OutputRequest& output) {
  return output.reportFile && output.reportFile->extension() == ".html";
}

/// The commands that make the requested files from the tables in `file`.
std::vector<Words> commandsFor(const OutputRequest& output, const fs::path& file) {
  std::vector<Words> commands;
  Words formats = output.exports;
  if (output.writesVtp()) formats.emplace_back("vtk");
  if (output.vtpMeshes) formats.emplace_back("vtk-meshes");
  if (!formats.empty()) {
    Words words = {"export", file.string(), "--folder", output.folder.empty() ? "." : output.folder.string()};
    for (const std::string& format : formats) words.insert(words.end(), {"--format", format});
    if (output.undeformed) words.emplace_back("--undeformed");
    commands.push_back(words);
  }
  if (wantsPage(output))
    commands.push_back({"view", file.string(), "--report", reportJson(output).string(), "--page",
                        output.reportFile->string()});
  return commands;
}

bool needsConversion(const OutputRequest& output) {
  return !commandsFor(output, {}).empty();
}

std::string asTyped(const std::vector<Words>& commands) {
  std::string text;
  for (const Words& words : commands) text += (text.empty() ? "" : " && ") + hemocell::asTyped(words);
  return text;
}

[[noreturn]] void throwAs(const CommandEnd& end) {
  if (end.kind == CommandEnd::Kind::stopped)
    throw AgreedFailure({ExitCode::interrupted, "interrupted: packmesh has not written all files"});
  if (end.kind == CommandEnd::Kind::refused) throw InputError(end.message);
  throw OutputError("packmesh: " + end.message);
}

void warnOfMissing(const OutputRequest& output, const std::string& why) {
  static std::string last;  // of several realisations, the first says it for all
  if (why == last) return;
  last = why;
  log::warning(fmt::format(
      "the Python package packmesh {}: exports, VTK files and pages of reports are not written. {} "
      "is kept for them; where packmesh can be used, this writes them: {}",
      why, keptTables(output).string(), asTyped(commandsFor(output, keptTables(output)))));
}

}  // namespace

std::vector<fs::path> convertedFiles(const Problem& problem, const OutputRequest& output,
                                     const std::vector<std::int64_t>& counts) {
  std::vector<fs::path> files;
  if (!needsConversion(output)) return files;
  std::error_code error;
  const fs::path place = fs::temp_directory_path(error) / "packMesh_plan.h5";
  const auto tables = writtenWithoutCells(place, problem, counts);
  for (Words words : commandsFor(output, tables->temporary())) {
    words.emplace_back("--plan");
    if (words.front() == "export" && (problem.hasDeformed() || problem.request.deforms()))
      words.emplace_back("--deformed");
    const CommandEnd end = runPackmesh(words, interrupted);
    if (end.kind == CommandEnd::Kind::unusable) {
      warnOfMissing(output, end.message);
      return {keptTables(output)};
    }
    if (end.kind != CommandEnd::Kind::done) throwAs(end);
    files.insert(files.end(), end.lines.begin(), end.lines.end());
  }
  return files;
}

void convert(const Packing& packing, const CellMeasures& measures) {
  const OutputRequest& output = packing.output;
  if (!needsConversion(output)) return;
  SharedFiles(packing.ranks()).makeFolder(output.folder);
  std::unique_ptr<AtomicFiles> file;  // of the first rank
  try {
    file = writtenTables(keptTables(output), packing, measures);
  } catch (const OutputError& error) {  // the same on all ranks
    throw AgreedFailure({ExitCode::cannotWrite, error.what()});
  }
  onFirstRank(packing.ranks(), [&] {
    for (const Words& words : commandsFor(output, file->temporary())) {
      const CommandEnd end = runPackmesh(words, interrupted);
      if (end.kind == CommandEnd::Kind::unusable) {
        file->end();
        file->commit();
        log::info(fmt::format("Wrote {}", keptTables(output).string()));
        return;
      }
      for (const std::string& line : end.lines) log::info(line);
      if (end.kind != CommandEnd::Kind::done) throwAs(end);
    }
  });
}

namespace {

fs::path positionsOf(const OutputRequest& output, const CellSpecies& species) {
  return output.folder / (species.name + ".pos");
}

/// The cells that are not wholly inside the lumen, by number.
std::set<std::int64_t> idsOutside(const Certificate& certificate) {
  std::set<std::int64_t> outside;
  for (const MisplacedCell& cell : certificate.misplaced)
    if (!(cell.gap > 0.0)) outside.insert(cell.cell);
  return outside;
}

PackingMeasures packingMeasuresOf(const Packing& packing, const CellMeasures& measures) {
  return measurePacking(physicsOf(*packing.problem), {packing.ranks(), packing.problem->team}, packing.cells,
                        measures.gap, endAxes(*packing.problem), idsOutside(packing.certificate),
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
                      idsOutside(packing.certificate), packing.certificate.gapsMeasuredUpTo);
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
