// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/completed_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <system_error>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/problem/checkpoints.h"
#include "hemocell_adapter/problem/choose_species.h"
#include "hemocell_adapter/problem/code_facts.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "hemocell_adapter/settings/packing_section.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {
namespace {

/// Sizes of a box. packCells reads them with atoi; under its name packMesh does the same, with a warning if
/// that matters.
Vec3 boxSizes(const CommandLine& commandLine, std::vector<std::string>& warnings) {
  const ValueSpec spec = specs::length("");
  Vec3 sizes;
  for (int k = 0; k < 3; ++k) {
    const std::string& text = (*commandLine.sizes)[k];
    located<UsageError>(fmt::format("size s{}", "XYZ"[k]), [&] {
      sizes[k] = std::get<double>(parseValue(spec, text));
      const double truncated = std::atoi(text.c_str());
      if (!commandLine.asPackCells || truncated == sizes[k]) return;
      const std::string notice = fmt::format(
          "size {} is read as {}, as packCells does; packMesh takes it as it is", text, truncated);
      if (!(truncated > 0)) throw InputError(notice);
      warnings.push_back(notice);
      sizes[k] = truncated;
    });
  }
  return sizes;
}

/// Where the outputs are: the folder of the case, and the state in it.
void chooseOutputs(Request& request, const Case* simulation) {
  OutputRequest& output = request.output;
  if (output.folder.empty()) output.folder = simulation ? simulation->folder : std::filesystem::path(".");
  if (!output.stateFile && (output.checkpointEvery > 0.0 || request.restart))
    output.stateFile = request.restart ? resultOf(*request.restart) : output.folder / "state.h5";
}

/// A box from the command line is packed with cells that HemoCell keeps; under the name packCells it is
/// periodic, as there. A running system is periodic where it says so.
void chooseEnds(Request& request, const Case* simulation) {
  if (request.periodicEnds) return;
  if (request.boxSize && !(request.container && request.container->lumen))
    request.periodicEnds = request.packCellsConventions && !request.keepAll;
  if (simulation && simulation->running) request.periodicEnds = true;
}

const char* nameOf(Method::Kind method) {
  return method == Method::cat ? "cat" : "relaxation";
}

/// Where settings without an option are from, for messages.
std::string sectionOf(const Case* simulation) {
  return simulation ? simulation->file.string() : "argument";
}

/// Settings that have no effect are refused, not ignored.
void checkApplicability(const Request& request, const Request& options, const Case* simulation) {
  const bool meshLumen = request.container && request.container->lumen &&
                         request.container->lumen->kind == SolidRequest::Kind::mesh;
  if (request.container && request.container->lumen && request.container->lumen->openAxis && !meshLumen) {
    throw UsageError("option '--open-axis' is for --vessel; a cylinder is open or closed by --ends");
  }
  if (meshLumen && request.container->lumen->file.empty()) {
    throw UsageError("option '--open-axis' needs a --vessel");
  }
  for (const Setting& setting : settingsTable()) {
    if (!setting.method || *setting.method == request.method || !request.states(setting.name())) continue;
    if (setting.isFlag() && !std::get<bool>(*setting.get(request))) continue;
    if (options.states(setting.name()))
      throw UsageError(
          fmt::format("option '--{}' is for --method {}", setting.option, nameOf(*setting.method)));
    throw InputError(fmt::format("{}: <{}>: it is for <method> {}", sectionOf(simulation), setting.name(),
                                 nameOf(*setting.method)));
  }
  if (request.method == Method::cat && !hasCat()) {
    const std::string reason = "this packMesh was built without 'cat' (CMake: -DPACKMESH_CAT=ON)";
    if (options.states("method")) throw UsageError("option '--method': " + reason);
    throw InputError(sectionOf(simulation) + ": <method>: " + reason);
  }
  if (request.output.reportFile && request.output.reportFile->extension() != ".json" &&
      request.output.reportFile->extension() != ".html") {
    const std::string reason = fmt::format("expected a file that ends in .json or .html, found '{}'",
                                           request.output.reportFile->string());
    if (options.states("report")) throw UsageError("option '--report': " + reason);
    throw InputError(sectionOf(simulation) + ": <report>: " + reason);
  }
  const bool ownBody = request.container && request.container->lumen;
  const bool boxLumen = ownBody ? request.container->lumen->kind == SolidRequest::Kind::box
                                : !simulation || !simulation->domain.geometry || request.container;
  if (request.walls && !request.walls->empty() && !boxLumen) {
    const std::string reason = "walls are chosen for boxes only; the surface of this lumen is its wall";
    if (options.states("walls")) throw UsageError("option '--walls': " + reason);
    throw InputError(sectionOf(simulation) + ": <walls>: " + reason);
  }
  if (options.states("tile") &&
      (!request.boxSize || request.container || !request.periodicEnds.value_or(false)))
    throw UsageError("option '--tile' is for periodic boxes: sX sY sZ --ends periodic");
  if (request.seed + std::uint64_t(request.realisations - 1) >
      std::uint64_t(std::numeric_limits<std::int64_t>::max()))
    throw UsageError("option '--realisations': the last of the seeds would be larger than a seed may be");
  if (request.inColumns && request.boxSize && !ownBody && !request.periodicEnds.value_or(false))
    throw InputError(
        "columns (--order, <order>) take a box that is periodic along all axes: sX sY sZ --ends periodic");
  if (request.largestClearance && request.output.stateFile)
    throw UsageError(
        "the largest clearance (--clearance max) requires many packings, and a state belongs to one: omit "
        "--state and --checkpoint-every, or state a clearance");
  if (request.largestClearance && request.cat.usesReserve())
    throw UsageError("the largest clearance (--clearance max) is not searched for with escapes (--escape)");
  if (request.keepAll && ownBody) throw UsageError("option '--keep-all' is for boxes: sX sY sZ");
  if (request.periodicEnds.value_or(false) && request.keepAll) {
    throw UsageError(
        "--ends periodic excludes --keep-all: HemoCell deletes every cell that crosses a periodic face");
  }
}

/// Valid settings that are probably unintended.
void warnOfUnits(const Request& request, const Request& options, const Case* simulation,
                 std::vector<std::string>& warnings) {
  const std::string where = simulation ? simulation->domain.dxWhere : "option '--dx'";
  if (simulation || options.states("dx"))
    if (const auto warning = spacingWarning(request.dx, where)) warnings.push_back(*warning);
  std::error_code ignored;
  if (simulation && simulation->domain.geometry && request.container && request.container->lumen &&
      std::filesystem::is_regular_file(*simulation->domain.geometry, ignored))
    warnings.push_back(
        fmt::format("{} replaces the <geometry> of {}, {}: right only where the case builds its lumen in C++ "
                    "and does not "
                    "read that file",
                    request.container->lumen->where, simulation->file.string(),
                    simulation->domain.geometry->filename().string()));
}

/// What a configuration requests beside the cells belongs to the run that packs them: `check` writes what its
/// command line requests.
void onlyOutputsOf(const OutputRequest& options, OutputRequest& output) {
  output.exports = options.exports;
  output.povScene = options.povScene;
  output.vtp = options.vtp;
  output.vtpMeshes = options.vtpMeshes;
  output.reportFile = options.reportFile;
}

/// A restart of one of several realisations continues with the following ones, in the folder that contains
/// them all.
void continueRealisations(Request& request) {
  if (request.realisations == 1 || !request.restart) return;
  OutputRequest& output = request.output;
  const auto place = placeInSeries(*request.restart, request.realisations);
  if (!place)
    throw UsageError(fmt::format(
        "option '--restart': realisations continue from the state of one of them, where it was written: "
        "{}; found '{}'",
        (output.folder / realisationFolder(1, request.realisations) / "state.h5").string(),
        request.restart->string()));
  output.realisation = place->realisation;
  output.folder = place->seriesFolder;
}

/// Everything that is stated, in the order of precedence.
Request statedBy(const CommandLine& commandLine, const Case* simulation, std::vector<std::string>& warnings) {
  Request request;
  if (simulation) request = simulation->packing;
  if (commandLine.sizes) request.boxSize = boxSizes(commandLine, warnings);
  if (!commandLine.section.empty())
    request = withPackingSection(std::move(request), commandLine.section, "argument");
  request = withOptions(std::move(request), commandLine);
  request.packCellsConventions = commandLine.asPackCells;
  request.words = commandLine.words;
  return request;
}

/// Of a hematocrit and a discharge hematocrit, options override the section of a case. Until the lumen is
/// known, the discharge hematocrit stands for that of the lumen.
void settleHematocrit(Request& request, const Request& options, const Case* simulation) {
  if (!request.dischargeHematocrit) return;
  if (options.hematocrit && options.dischargeHematocrit)
    throw UsageError("--hematocrit and --discharge-hematocrit exclude each other");
  if (request.hematocrit && !options.hematocrit && !options.dischargeHematocrit)
    throw InputError(sectionOf(simulation) + ": <hematocrit> and <dischargeHematocrit> exclude each other");
  if (options.hematocrit)
    request.dischargeHematocrit.reset();
  else
    request.hematocrit = request.dischargeHematocrit;
}

/// What packing and checking have in common.
/// @return whether cells of states have meshes of their own
bool settle(CompletedRequest& completed, const Request& options) {
  Request& request = completed.request;
  const Case* simulation = completed.simulation.get();
  const bool deformed = nameSpeciesOfStates(request);
  settleHematocrit(request, options, simulation);
  chooseOutputs(request, simulation);
  chooseEnds(request, simulation);
  if (simulation) request.dx = simulation->domain.dx;
  warnOfUnits(request, options, simulation, completed.warnings);
  if (request.packCellsConventions && !request.redCellVolume) request.redCellVolume = packCellsRedCellVolume;
  checkApplicability(request, options, simulation);
  continueRealisations(request);
  if (!simulation || !simulation->running)
    completed.preInlet = choosePreInlet(request, simulation, completed.warnings);
  if (request.ignoredScale)
    completed.warnings.emplace_back("--scale is ignored: there is no neighbour grid to tune");
  return deformed;
}

CompletedRequest begun(const CommandLine& commandLine, std::shared_ptr<const Case> running) {
  CompletedRequest completed;
  completed.simulation = std::move(running);
  if (!completed.simulation && commandLine.configFile)
    completed.simulation = std::make_shared<const Case>(readCase(*commandLine.configFile));
  completed.request = statedBy(commandLine, completed.simulation.get(), completed.warnings);
  return completed;
}

}  // namespace

CompletedRequest requestToPack(const CommandLine& commandLine, std::shared_ptr<const Case> running) {
  CompletedRequest completed = begun(commandLine, std::move(running));
  const Case* simulation = completed.simulation.get();
  const Request options = commandLine.options();
  const bool deformed = settle(completed, options);
  OutputRequest& output = completed.request.output;
  if (deformed && !output.stateFile && !(simulation && simulation->running))
    output.stateFile = output.folder / "state.h5";  // .pos files cannot have such cells
  completeSpecies(completed.request, options, simulation, completed.warnings);
  return completed;
}

CompletedRequest requestToCheck(const CommandLine& commandLine,
                                const std::optional<std::filesystem::path>& folder) {
  CompletedRequest completed = begun(commandLine, nullptr);
  const Request options = commandLine.options();
  onlyOutputsOf(options.output, completed.request.output);
  settle(completed, options);
  if (folder) completed.request.output.folder = *folder;
  return completed;
}

std::vector<std::filesystem::path> foldersToCheck(const Request& request) {
  if (!request.startStates.empty()) return {};
  const std::filesystem::path& folder = request.output.folder;
  std::vector<std::filesystem::path> folders = realisationFoldersIn(folder);
  if (folders.empty()) return folders;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".pos") {
      folders.insert(folders.begin(), folder);
      break;
    }
  if (request.output.asksForViews())
    throw UsageError(
        "reports, scenes, VTK files and exports of a check are of one folder: name one of the realisations "
        "by --output-dir");
  return folders;
}

}  // namespace packmesh::hemocell
