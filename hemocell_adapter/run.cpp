// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <ctime>

#include "hemocell_adapter/interruption.h"
#include "hemocell_adapter/log.h"
#include "hemocell_adapter/scene.h"
#include "hemocell_adapter/summary.h"
#include "packMesh/io/pov_scene.h"
#include "packMesh/packing/pack.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

class Stopwatch {
 public:
  RunTimes elapsed() const {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
    return {double(std::clock()) / CLOCKS_PER_SEC, wall.count()};
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Fails before hours of packing rather than after them.
void requireWritable(const fs::path& folder) {
  std::error_code ignored;
  fs::path existing = folder.empty() ? fs::path(".") : fs::absolute(folder);
  while (!fs::exists(existing, ignored) && existing.has_relative_path()) existing = existing.parent_path();
  if (!fs::is_directory(existing, ignored)) {
    throw OutputError(
        fmt::format("{}: is not a folder; the .pos files cannot be written there", existing.string()));
  }
  if (access(existing.c_str(), W_OK | X_OK) != 0) {
    throw OutputError(fmt::format("{}: the folder is not writable", existing.string()));
  }
}

/// Leftovers that HemoCell would load together with the new files.
void warnOfStaleFiles(const Job& job, const Scene& scene) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(job.outputDirectory, ignored)) {
    if (entry.path().extension() != ".pos") continue;
    const std::string name = entry.path().stem().string();
    bool ours = false;
    for (const SceneSpecies& s : scene.species) ours = ours || (s.job.name == name && s.count > 0);
    if (!ours) {
      log::warning(fmt::format(
          "{} is not part of this packing; cells in it may overlap the new ones. Remove it unless it "
          "is meant",
          entry.path().string()));
    }
  }
}

Kept keptOf(const Scene& scene, const std::vector<PlacedCell>& cells) {
  Kept kept;
  kept.kept.assign(scene.species.size(), 0);
  if (!knowsAcceptance(scene)) return kept;
  for (const PlacedCell& cell : cells) {
    if (const auto objection = hemocellObjection(scene, cell)) {
      countReason(kept, *objection);
    } else {
      ++kept.kept[cell.species];
    }
  }
  return kept;
}

void write(const Job& job, const Scene& scene, const PackingResult& result) {
  try {
    std::error_code error;
    fs::create_directories(job.outputDirectory, error);
    if (error)
      throw InputError(
          fmt::format("{}: the folder cannot be made: {}", job.outputDirectory.string(), error.message()));
    AtomicFiles files;
    for (std::size_t s = 0; s < scene.species.size(); ++s) {
      std::vector<PosLine> lines;
      for (std::size_t i = 0; i < result.cells.size(); ++i) {
        if (result.cells[i].species == int(s)) lines.push_back(posLineOf(result.poses[i]));
      }
      if (scene.species[s].count > 0)
        files.add(job.outputDirectory / (scene.species[s].job.name + ".pos"), formatPos(lines));
    }
    files.commit();
  } catch (const InputError& error) {
    throw OutputError(error.what());
  }
}

void writePicture(const Job& job, const Scene& scene, const PackingResult& result) {
  std::vector<const Shape*> shapes;
  std::vector<std::string> names;
  for (const SceneSpecies& species : scene.species) {
    shapes.push_back(species.shape.get());
    names.push_back(species.job.name);
  }
  try {
    writePovScene(job.outputDirectory / "cells.pov", shapes, names, result.cells, *scene.lumen.container);
  } catch (const InputError& error) {
    throw OutputError(error.what());
  }
  log::info(fmt::format("Wrote {}", (job.outputDirectory / "cells.pov").string()));
}

/// A line of progress now and then.
class ProgressLog {
 public:
  void operator()(const Progress& progress) {
    const double now = stopwatch_.elapsed().wall;
    const double pause = log::level() == log::Level::verbose ? 1.0 : 10.0;  // [s]
    if (now - last_ < pause) return;
    last_ = now;
    log::info(fmt::format("{}: sweep {}, scale {:.3f}, worst overlap {:.4f} µm, {} pairs unresolved",
                          progress.stage, progress.sweep, progress.scale, progress.worstOverlap,
                          progress.unresolved));
  }

 private:
  Stopwatch stopwatch_;
  double last_ = 0.0;
};

ExitCode endInterrupted() {
  log::error("interrupted: nothing was written");
  return ExitCode::interrupted;
}

/// What was reached when not everything could be.
std::string reachedText(const Job& job, const Scene& scene, const PackingResult& result) {
  const Tally tally = tallyOf(scene, result.cells);
  std::string counts;
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    counts += fmt::format("{}{} of {} {}", s ? ", " : "", tally.counts[s], scene.species[s].count,
                          scene.species[s].job.name);
  }
  return fmt::format(
      "out of reach within the limits ({} sweeps{}): the densest certified packing has hematocrit {:.4f} of "
      "the "
      "{} ({})",
      result.statistics.sweeps, job.maxSeconds > 0 ? fmt::format(", {:.15g} s", job.maxSeconds) : "",
      tally.redMesh / scene.referenceVolume(job), job.fluidVolume ? "fluid nodes" : "lumen", counts);
}

}  // namespace

ExitCode runPacking(const Job& job) {
  const Stopwatch stopwatch;
  requireWritable(job.outputDirectory);
  for (const std::string& warning : job.warnings) log::warning(warning);
  const Scene scene = buildScene(job);
  for (const auto* list : {&scene.warnings, &scene.lumen.notices}) {
    for (const std::string& warning : *list) log::warning(warning);
  }
  for (const std::string& line : headLines(job, scene)) log::info(line);
  log::detail(fmt::format("Preparation: {:.3f} s CPU", stopwatch.elapsed().cpu));

  const PolledInterruption whilePackingAndWriting;
  ProgressLog progress;
  const PackingResult result =
      pack(problemOf(job, scene, interrupted, [&](const Progress& p) { progress(p); }));
  if (result.outcome == Outcome::interrupted || interrupted()) return endInterrupted();
  log::detail(
      fmt::format("Packing: {} sweeps, {} rounds of repair; CPU: placement {:.3f} s, relaxation {:.3f} s, "
                  "certificate {:.3f} s",
                  result.statistics.sweeps, result.statistics.repairs, result.statistics.placementSeconds,
                  result.statistics.relaxationSeconds, result.statistics.certificateSeconds));
  if (result.outcome == Outcome::outOfReach) {
    const std::string reached = reachedText(job, scene, result);
    if (!job.bestEffort || result.cells.empty()) {
      log::error(reached + (result.cells.empty() ? "; nothing was written"
                                                 : "; nothing was written (--best-effort writes that one)"));
      return ExitCode::outOfReach;
    }
    log::warning(reached + "; writing that one (--best-effort)");
  }
  const Kept kept = keptOf(scene, result.cells);
  const bool allKept = kept.reasons.empty();
  const bool promised = scene.lumen.acceptedOnly && !scene.lumen.periodic;
  if (!result.certificate.clean() || (promised && !allKept)) {
    log::error(fmt::format(
        "the packing does not hold ({} overlapping pairs, {} cells misplaced, HemoCell would drop some: "
        "{}); nothing was written. This is a fault of packMesh; please report it with the command",
        result.certificate.overlapping.size(), result.certificate.misplaced.size(),
        allKept ? "no" : kept.reasons.front().first));
    return ExitCode::internal;
  }
  write(job, scene, result);
  for (const std::string& line :
       footLines(job, scene, result.cells, result.certificate, kept, stopwatch.elapsed()))
    log::info(line);
  for (const SceneSpecies& species : scene.species) {
    if (species.count > 0)
      log::info(fmt::format("Wrote {}", (job.outputDirectory / (species.job.name + ".pos")).string()));
  }
  warnOfStaleFiles(job, scene);
  if (job.povScene) writePicture(job, scene, result);
  return ExitCode::ok;
}

}  // namespace packmesh::hemocell
