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
#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {
namespace {

/// Sizes of a box. packCells reads them with atoi; under its name so do we, and say when that matters.
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

template <typename T, typename U>
void take(T& target, const std::optional<U>& value) {
  if (value) target = *value;
}

void takeSettings(Job& job, const Settings& s) {
  job.container = s.container;
  job.hematocrit = s.hematocrit;
  job.redCellVolume = s.redCellVolume;
  job.periodicEnds = s.periodicEnds;
  job.walls = s.walls;
  job.maxIterations = s.maxIterations;
  take(job.fluidVolume, s.fluidVolume);
  take(job.keepAll, s.keepAll);
  take(job.dx, s.dx);
  take(job.method, s.method);
  take(job.planeSource, s.planeSource);
  take(job.escape, s.escape);
  take(job.growth, s.growth);
  take(job.clearance, s.clearance);
  take(job.wallClearance, s.wallClearance);
  take(job.largestClearance, s.largestClearance);
  job.autoClearance = !s.clearance && !job.largestClearance;
  job.autoWallClearance = !s.wallClearance;
  take(job.cellFreeLayer, s.cellFreeLayer);
  take(job.seed, s.seed);
  take(job.rotate, s.rotate);
  take(job.inColumns, s.inColumns);
  take(job.maxSeconds, s.maxSeconds);
  take(job.bestEffort, s.bestEffort);
  take(job.dryRun, s.dryRun);
  take(job.validate, s.validate);
  take(job.outputDirectory, s.outputDirectory);
  take(job.povScene, s.povScene);
  take(job.vtp, s.vtp);
  take(job.vtpMeshes, s.vtpMeshes);
  job.reportFile = s.reportFile;
  take(job.checkpointEvery, s.checkpointEvery);
  job.regions = s.regions;
  take(job.tiles, s.tiles);
  take(job.realisations, s.realisations);
  job.exports = s.exports;
  job.stateFile = s.stateFile;
  job.restart = s.restart;
  if (!job.stateFile && (job.checkpointEvery > 0.0 || job.restart))
    job.stateFile = job.restart ? *job.restart : job.outputDirectory / "state.h5";
}

/// A box from the command line is packed with cells that HemoCell keeps; under packCells' name it is
/// periodic, as there.
void chooseEnds(Job& job) {
  const bool box = job.boxSize && !(job.container && job.container->lumen);
  if (box && !job.periodicEnds) job.periodicEnds = job.asPackCells && !job.keepAll;
}

/// Settings that have no effect where they were given are refused, not ignored.
void checkApplicability(const Job& job, const Settings& settings, const Settings& options) {
  const bool meshLumen =
      job.container && job.container->lumen && job.container->lumen->kind == SolidRequest::Kind::mesh;
  if (job.container && job.container->lumen && job.container->lumen->openAxis && !meshLumen) {
    throw UsageError("option '--open-axis' is for --vessel; a cylinder is open or closed by --ends");
  }
  if (meshLumen && job.container->lumen->file.empty()) {
    throw UsageError("option '--open-axis' needs a --vessel");
  }
  if (job.planeSource && job.method != Method::cat) {
    if (options.planeSource) throw UsageError("option '--builder' is for --method cat");
    throw InputError(job.config->file.string() + ": <builder>: it is for <method> cat");
  }
  if (settings.growth && job.method != Method::cat) {
    if (options.growth) throw UsageError("option '--growth' is for --method cat");
    throw InputError(job.config->file.string() + ": <growth>: it is for <method> cat");
  }
  if (job.escape && job.method != Method::cat) {
    if (options.escape) throw UsageError("option '--escape' is for --method cat");
    throw InputError(job.config->file.string() + ": <escape>: it is for <method> cat");
  }
  if (job.reportFile && job.reportFile->extension() != ".json" && job.reportFile->extension() != ".html") {
    const std::string reason =
        fmt::format("expected a file that ends in .json or .html, found '{}'", job.reportFile->string());
    if (options.reportFile) throw UsageError("option '--report': " + reason);
    throw InputError(job.config->file.string() + ": <report>: " + reason);
  }
  const bool ownBody = job.container && job.container->lumen;
  const bool boxLumen = ownBody ? job.container->lumen->kind == SolidRequest::Kind::box
                                : !job.config || !job.config->domain.geometry || job.container;
  if (job.walls && !job.walls->empty() && !boxLumen) {
    const std::string reason = "walls are chosen for boxes only; the surface of this lumen is its wall";
    if (options.walls) throw UsageError("option '--walls': " + reason);
    throw InputError(job.config->file.string() + ": <walls>: " + reason);
  }
  if (options.tiles && (!job.boxSize || job.container || !job.periodicEnds.value_or(false)))
    throw UsageError("option '--tile' is for periodic boxes: sX sY sZ --ends periodic");
  if (options.tiles && job.method == Method::cat)
    throw UsageError("option '--tile' is for the default method, not for --method cat");
  if (job.seed + std::uint64_t(job.realisations - 1) >
      std::uint64_t(std::numeric_limits<std::int64_t>::max()))
    throw UsageError("option '--realisations': the last of the seeds would be larger than a seed may be");
  if (job.inColumns && job.method == Method::cat)
    throw UsageError("columns (--order, <order>) are for the default method, not for --method cat");
  if (job.inColumns && job.boxSize && !ownBody && !job.periodicEnds.value_or(false))
    throw InputError(
        "columns (--order, <order>) take a box that is periodic along all axes: sX sY sZ --ends periodic");
  if (job.largestClearance && job.stateFile)
    throw UsageError(
        "the largest clearance (--clearance max) is found by many packings, and a state is of one: leave out "
        "--state and --checkpoint-every, or state a clearance");
  if (job.largestClearance && job.escape)
    throw UsageError("the largest clearance (--clearance max) is not searched for with escapes (--escape)");
  if (job.keepAll && ownBody) throw UsageError("option '--keep-all' is for boxes: sX sY sZ");
  if (job.periodicEnds.value_or(false) && job.keepAll) {
    throw UsageError(
        "--ends periodic excludes --keep-all: HemoCell drops every cell that crosses a periodic face");
  }
}

/// What is legal, but hardly meant.
void warnOfUnits(Job& job, const Settings& options) {
  const std::string where = job.config ? job.config->domain.dxWhere : "option '--dx'";
  if (job.config || options.dx)
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

/// What growth does not know is refused before anything is built.
void checkMethod(const Job& job) {
  if (job.method != Method::cat) return;
  const auto refuse = [](const std::string& what) {
    throw InputError(what + ": method cat does not know it; the default method does");
  };
  if (!job.regions.empty()) refuse("<region>");
  for (const JobSpecies& species : job.species) {
    if (!species.fixed.empty() || !species.start.empty())
      refuse(fmt::format("cell '{}' has cells that are there", species.name));
    if (species.cone) refuse(fmt::format("cell '{}' has an axis", species.name));
    if (species.ownWallClearance > job.wallClearance)
      refuse(fmt::format("cell '{}' has a clearance to the wall of its own", species.name));
  }
}

/// A restart of one of several realisations goes on with those after it, in the folder that holds them all.
void continueRealisations(Job& job) {
  if (job.realisations == 1 || !job.restart) return;
  const auto place = placeInSeries(*job.restart, job.realisations);
  if (!place)
    throw UsageError(fmt::format(
        "option '--restart': realisations go on from the state of one of them, where it was written: "
        "{}; found '{}'",
        (job.outputDirectory / realisationFolder(1, job.realisations) / "state.h5").string(),
        job.restart->string()));
  job.firstRealisation = place->realisation;
  job.outputDirectory = place->seriesFolder;
}

/// What `check` examines where there are realisations: .pos files beside them, and each of them.
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

Job makeJob(const CommandLine& commandLine, const std::optional<std::filesystem::path>& folderToCheck) {
  Job job;
  job.command = commandLine.command;
  job.asPackCells = commandLine.asPackCells;
  job.commandWords = commandLine.words;
  Settings settings;
  job.outputDirectory = ".";
  if (commandLine.configFile) {
    job.config = readCaseConfig(*commandLine.configFile);
    job.source = readCaseSource(job.config->folder);
    settings = job.config->packing;
    job.outputDirectory = job.config->folder;
  }
  if (commandLine.sizes) job.boxSize = boxSizes(commandLine, job.warnings);

  const Settings options = commandLine.settings();
  settings = withOptions(settings, commandLine);
  takeSettings(job, settings);
  chooseEnds(job);
  if (job.config) job.dx = job.config->domain.dx;
  warnOfUnits(job, options);
  if (job.asPackCells && !job.redCellVolume) job.redCellVolume = packCellsRedCellVolume;
  checkApplicability(job, settings, options);
  continueRealisations(job);
  choosePreInlet(job, settings);
  if (settings.ignoredScale) {
    job.warnings.push_back("--scale is ignored: there is no neighbour grid to tune");
  }
  if (job.command == Command::check) {
    if (folderToCheck) job.outputDirectory = *folderToCheck;
    if (!folderToCheck) job.foldersToCheck = foldersOfRealisations(job.outputDirectory);
    if (job.foldersToCheck.empty()) chooseCheckedSpecies(job, settings);
  } else {
    choosePackedSpecies(job, std::move(settings), options);
    checkMethod(job);
    for (const JobSpecies& species : job.species) {
      if (species.cone && !job.rotate)
        throw InputError(fmt::format(
            "cell '{}' has an axis, but --noRotate (<rotate> false) keeps every orientation at 0 0 0",
            species.name));
      if (species.stock > 0 && !job.escape)
        throw InputError(fmt::format("cell '{}' has a stock, which only --escape uses", species.name));
    }
  }
  settleDistancesFromSolid(job);
  return job;
}

}  // namespace packmesh::hemocell
