// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/conversions.h"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/python_command.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/packing_tables.h"
#include "hemocell_adapter/output/report.h"
#include "hemocell_adapter/output/shared_files.h"

namespace packmesh::hemocell {
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

}  // namespace packmesh::hemocell
