// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/make_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <system_error>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/problem/job_source.h"
#include "hemocell_adapter/problem/job_species.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "hemocell_adapter/problem/tiling.h"
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
    try {
      sizes[k] = std::get<double>(parseValue(spec, text));
      if (commandLine.asPackCells) {
        const double truncated = std::atoi(text.c_str());
        if (truncated != sizes[k]) {
          const std::string notice = fmt::format(
              "size {} is read as {}, as packCells does; packMesh takes it as it is", text, truncated);
          if (!(truncated > 0)) throw InputError(notice);
          warnings.push_back(notice);
          sizes[k] = truncated;
        }
      }
    } catch (const InputError& error) {
      throw UsageError(fmt::format("size s{}: {}", "XYZ"[k], error.what()));
    }
  }
  return sizes;
}

/// Copies the request without interpretation.
void takeSettings(Job& job, const Settings& settings) {
  const std::filesystem::path folder = job.config ? job.config->folder : std::filesystem::path(".");
  static_cast<RunSettings&>(job) = settings;
  job.outputStated = !job.outputDirectory.empty();
  if (!job.outputStated) job.outputDirectory = folder;
  job.demanded = {settings.clearance.value_or(0.0), settings.wallClearance.value_or(0.0)};
  job.autoClearance = !settings.clearance && !job.largestClearance;
  job.autoWallClearance = !settings.wallClearance;
  if (!job.stateFile && (job.checkpointEvery > 0.0 || job.restart))
    job.stateFile = job.restart ? *job.restart : job.outputDirectory / "state.h5";
}

/// A box from the command line is packed with cells that HemoCell keeps; under the name packCells it is
/// periodic, as there.
void chooseEnds(Job& job) {
  const bool box = job.boxSize && !(job.container && job.container->lumen);
  if (box && !job.periodicEnds) job.periodicEnds = job.asPackCells && !job.keepAll;
}

const char* nameOf(Method method) {
  return method == Method::cat ? "cat" : "relaxation";
}

/// Where settings without an option are from, for messages.
std::string sectionOf(const Job& job) {
  return job.config ? job.config->file.string() : "argument";
}

/// Settings that have no effect are refused, not ignored.
void checkApplicability(const Job& job, const Settings& settings, const Settings& options) {
  const bool meshLumen =
      job.container && job.container->lumen && job.container->lumen->kind == SolidRequest::Kind::mesh;
  if (job.container && job.container->lumen && job.container->lumen->openAxis && !meshLumen) {
    throw UsageError("option '--open-axis' is for --vessel; a cylinder is open or closed by --ends");
  }
  if (meshLumen && job.container->lumen->file.empty()) {
    throw UsageError("option '--open-axis' needs a --vessel");
  }
  for (const Setting& setting : settingsTable()) {
    if (!setting.method || *setting.method == job.method || !settings.states(setting.name())) continue;
    if (setting.flag && !std::get<bool>(*setting.get(job))) continue;
    if (options.states(setting.name()))
      throw UsageError(
          fmt::format("option '--{}' is for --method {}", setting.option, nameOf(*setting.method)));
    throw InputError(fmt::format("{}: <{}>: it is for <method> {}", sectionOf(job), setting.name(),
                                 nameOf(*setting.method)));
  }
  if (job.reportFile && job.reportFile->extension() != ".json" && job.reportFile->extension() != ".html") {
    const std::string reason =
        fmt::format("expected a file that ends in .json or .html, found '{}'", job.reportFile->string());
    if (options.states("report")) throw UsageError("option '--report': " + reason);
    throw InputError(sectionOf(job) + ": <report>: " + reason);
  }
  const bool ownBody = job.container && job.container->lumen;
  const bool boxLumen = ownBody ? job.container->lumen->kind == SolidRequest::Kind::box
                                : !job.config || !job.config->domain.geometry || job.container;
  if (job.walls && !job.walls->empty() && !boxLumen) {
    const std::string reason = "walls are chosen for boxes only; the surface of this lumen is its wall";
    if (options.states("walls")) throw UsageError("option '--walls': " + reason);
    throw InputError(sectionOf(job) + ": <walls>: " + reason);
  }
  if (options.states("tile") && (!job.boxSize || job.container || !job.periodicEnds.value_or(false)))
    throw UsageError("option '--tile' is for periodic boxes: sX sY sZ --ends periodic");
  if (job.seed + std::uint64_t(job.realisations - 1) >
      std::uint64_t(std::numeric_limits<std::int64_t>::max()))
    throw UsageError("option '--realisations': the last of the seeds would be larger than a seed may be");
  if (job.inColumns && job.boxSize && !ownBody && !job.periodicEnds.value_or(false))
    throw InputError(
        "columns (--order, <order>) take a box that is periodic along all axes: sX sY sZ --ends periodic");
  if (job.largestClearance && job.stateFile)
    throw UsageError(
        "the largest clearance (--clearance max) requires many packings, and a state belongs to one: omit "
        "--state and --checkpoint-every, or state a clearance");
  if (job.largestClearance && job.escape)
    throw UsageError("the largest clearance (--clearance max) is not searched for with escapes (--escape)");
  if (job.keepAll && ownBody) throw UsageError("option '--keep-all' is for boxes: sX sY sZ");
  if (job.periodicEnds.value_or(false) && job.keepAll) {
    throw UsageError(
        "--ends periodic excludes --keep-all: HemoCell deletes every cell that crosses a periodic face");
  }
}

/// Valid settings that are probably unintended.
void warnOfUnits(Job& job, const Settings& options) {
  const std::string where = job.config ? job.config->domain.dxWhere : "option '--dx'";
  if (job.config || options.states("dx"))
    if (const auto warning = spacingWarning(job.dx, where)) job.warnings.push_back(*warning);
  std::error_code ignored;
  if (job.config && job.config->domain.geometry && job.container && job.container->lumen &&
      std::filesystem::is_regular_file(*job.config->domain.geometry, ignored))
    job.warnings.push_back(
        fmt::format("{} replaces the <geometry> of {}, {}: right only where the case builds its lumen in C++ "
                    "and does not "
                    "read that file",
                    job.container->lumen->where, job.config->file.string(),
                    job.config->domain.geometry->filename().string()));
}

/// What a configuration requests beside the cells belongs to the run that packs them: `check` writes what its
/// command line requests.
void onlyOutputsOf(const Settings& options, Settings& settings) {
  settings.exports = options.exports;
  settings.povScene = options.povScene;
  settings.vtp = options.vtp;
  settings.vtpMeshes = options.vtpMeshes;
  settings.reportFile = options.reportFile;
}

bool requestsOutputs(const RunSettings& settings) {
  return !settings.exports.empty() || settings.writesVtp() || settings.vtpMeshes || settings.reportFile;
}

/// A restart of one of several realisations continues with the following ones, in the folder that contains
/// them all.
void continueRealisations(Job& job) {
  if (job.realisations == 1 || !job.restart) return;
  const auto place = placeInSeries(*job.restart, job.realisations);
  if (!place)
    throw UsageError(fmt::format(
        "option '--restart': realisations continue from the state of one of them, where it was written: "
        "{}; found '{}'",
        (job.outputDirectory / realisationFolder(1, job.realisations) / "state.h5").string(),
        job.restart->string()));
  job.firstRealisation = place->realisation;
  job.outputDirectory = place->seriesFolder;
}

/// What `check` examines if there are realisations: .pos files beside them, and each of them.
std::vector<std::filesystem::path> foldersOfRealisations(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> folders = realisationFoldersIn(folder);
  if (folders.empty()) return folders;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".pos") {
      folders.insert(folders.begin(), folder);
      break;
    }
  return folders;
}

}  // namespace

Job makeJob(const CommandLine& commandLine, const std::optional<std::filesystem::path>& folderToCheck,
            std::shared_ptr<const RunningCase> running) {
  Job job;
  job.command = commandLine.command;
  job.asPackCells = commandLine.asPackCells;
  job.commandWords = commandLine.words;
  Settings settings;
  job.running = std::move(running);
  if (job.running) {
    job.config = job.running->config;
    settings = job.config->packing;
  } else if (commandLine.configFile) {
    job.config = readCaseConfig(*commandLine.configFile);
    job.source = readCaseSource(job.config->folder);
    settings = job.config->packing;
  }
  if (commandLine.sizes) job.boxSize = boxSizes(commandLine, job.warnings);

  if (!commandLine.section.empty())
    settings = withPackingSection(std::move(settings), commandLine.section, "argument");
  const Settings options = commandLine.settings();
  settings = withOptions(settings, commandLine);
  if (job.command == Command::check) onlyOutputsOf(options, settings);
  nameSpeciesOfStates(settings);
  takeSettings(job, settings);
  chooseEnds(job);
  if (job.running && !job.periodicEnds) job.periodicEnds = true;  // where the running system is
  if (job.config) job.dx = job.config->domain.dx;
  warnOfUnits(job, options);
  if (job.asPackCells && !job.redCellVolume) job.redCellVolume = packCellsRedCellVolume;
  checkApplicability(job, settings, options);
  continueRealisations(job);
  if (!job.running) choosePreInlet(job, settings);
  if (settings.ignoredScale) {
    job.warnings.push_back("--scale is ignored: there is no neighbour grid to tune");
  }
  if (job.command == Command::check) {
    if (folderToCheck) job.outputDirectory = *folderToCheck;
    if (!folderToCheck && settings.startStates.empty())
      job.foldersToCheck = foldersOfRealisations(job.outputDirectory);
    if (!job.foldersToCheck.empty() && requestsOutputs(job))
      throw UsageError(
          "reports, scenes, VTK files and exports of a check are of one folder: name one of the realisations "
          "by --output-dir");
    if (job.foldersToCheck.empty()) chooseCheckedSpecies(job, settings);
  } else {
    choosePackedSpecies(job, std::move(settings), options);
    for (const CellSpecies& species : job.species) {
      if (species.cone && !job.rotate)
        throw InputError(fmt::format(
            "cell '{}' has an axis, but --noRotate (<rotate> false) keeps every orientation at 0 0 0",
            species.name));
      if (species.stock > 0 && !job.escape)
        throw InputError(
            fmt::format("cell '{}' has a reserve (stock), which only --escape uses", species.name));
    }
  }
  settleDistancesFromSolid(job);
  return job;
}

}  // namespace packmesh::hemocell
