// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/held_packing.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "hemocell_adapter/app/examination.h"
#include "hemocell_adapter/app/memory.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/shared_files.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/state_words.h"
#include "hemocell_adapter/problem/build_scene.h"
#include "hemocell_adapter/problem/make_job.h"
#include "hemocell_adapter/problem/tiling.h"
#include "packMesh/analysis/share_measures.h"
#include "packMesh/core/input_record.h"
#include "packMesh/core/timer.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/state_cells.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// The job, with no output but the state and the states of growth that the command asks for. What a
/// `<packing>` section of config.xml asks for is left to the program.
Job jobInMemory(const CommandLine& commandLine) {
  Job job = makeJob(commandLine);
  const Settings options = commandLine.settings();
  if (!options.stateFile && !options.restart && !options.states("checkpoint-every")) job.stateFile.reset();
  job.reportFile.reset();
  job.povScene = job.vtp = job.vtpMeshes = false;
  if (!options.states("growth-frames")) job.growthFrames = 0;
  job.exports.clear();
  return job;
}

[[noreturn]] void throwInterrupted(const Job& job, bool saved) {
  throw AgreedFailure({ExitCode::interrupted,
                       saved ? fmt::format("interrupted: no cells are returned; to continue: restart from {}",
                                           job.stateFile->string())
                             : std::string("interrupted: nothing was written")});
}

/// Tests in advance that the state can be written.
void requireWritableState(const Job& job, const Communicator& ranks) {
  if (!job.stateFile) return;
  onFirstRank(ranks, [&] {
    requireWritable(job.stateFile->parent_path());
    requireReplaceableState(job);
  });
  SharedFiles(ranks).makeFolder(job.stateFile->parent_path());
}

/// Takes over a result whose species are parts of the scene.
void take(HeldPacking& packing, Scene scene, PackingResult result) {
  packing.ownParts.assign(scene.parts.size(), 0);
  for (const PlacedCell& cell : result.cells) ++packing.ownParts[cell.species];
  packing.result = std::move(result);
  packing.verified = verified(scene, packing.result, packing.ranks, returnedToPython);
  packing.scene = std::make_shared<const Scene>(std::move(scene));
  for (std::size_t s = 0; s < packing.scene->species.size(); ++s) {
    const CellSpecies& species = packing.scene->species[s];
    packing.kinds.push_back({species.name, species.shape->mesh(), packing.verified.cells.tally.counts[s]});
    packing.kindOf.push_back(int(s));
  }
}

/// A measured cell in a message between ranks.
struct MeasuredCell {
  std::int64_t id;
  double gap, localHematocrit;
};

bool sameVertices(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.triangles == b.triangles;
}

template <class Use>
auto asFinished(const HeldPacking& packing, const Scene& scene, Use&& use) {
  std::optional<Repeated> repeated;
  if (packing.before) repeated.emplace(Repeated{packing.before->scene, packing.before->result});
  return use(Finished{scene, packing.result, packing.verified.cells.tally, packing.verified.kept,
                      packing.ranks, repeated ? &*repeated : nullptr});
}

/// The scene of the command with which the cells were packed.
Scene sceneOf(const HeldPacking& packing) {
  const std::vector<std::string>& words = packing.words;
  if (words.size() < 2) throw InputError(packing.file.string() + ": does not contain the command of the run");
  return sceneToPack(parseCommandLine(words.front(), {words.begin() + 1, words.end()}), packing.ranks);
}

}  // namespace

Scene sceneToPack(const CommandLine& commandLine, const Communicator& ranks,
                  const std::function<bool()>& interrupted) {
  const InputRecord inputs;
  const Timer timer;
  Job job;
  together(ranks, [&] { job = jobInMemory(commandLine); });
  for (const std::string& warning : job.warnings) log::warning(warning);
  Scene scene = builtScene(job, ranks, endOfPreparation(job, timer, returnedToPython, interrupted));
  if (isTiled(job)) together(ranks, [&] { requireTileable(scene); });
  return scene;
}

HeldPacking packInMemory(const CommandLine& commandLine, const Communicator& ranks, const RunHooks& hooks) {
  const Timer timer;
  HeldPacking packing;
  packing.ranks = ranks;
  Scene scene = sceneToPack(commandLine, ranks, hooks.interrupted);
  packing.words = scene.commandWords;
  requireWritableState(scene, ranks);
  for (const std::string& line : headLines(scene, ranks.size())) log::info(line);
  together(ranks, [&] { requireMemory(scene.mostCells(), ranks); });
  PackingAttempts attempts(scene, ranks, hooks);
  RoomyPacking packed = attempts.withRoom(timer);
  if (packed.result.outcome == Outcome::interrupted || ranks.any(hooks.interrupted && hooks.interrupted()))
    throwInterrupted(scene, attempts.saved());
  const bool delivers =
      packed.result.outcome != Outcome::outOfReach || (scene.bestEffort && packed.result.cellCount > 0);
  if (isTiled(scene) && delivers) {
    RepeatedPacking big = repeatedInTiles(scene, packed.result, ranks, hooks.interrupted);
    if (big.result.outcome == Outcome::interrupted) throwInterrupted(scene, false);
    packing.before =
        std::make_shared<const RepeatedPacking>(RepeatedPacking{std::move(scene), std::move(packed.result)});
    take(packing, std::move(big.scene), std::move(big.result));
  } else {
    take(packing, std::move(scene), std::move(packed.result));
  }
  packing.times = {timer.cpu(), timer.wall()};
  logSummary(*packing.scene, packing.verified.cells, packing.result.certificate, packing.verified.kept,
             packing.times);
  return packing;
}

HeldPacking loadPacking(const fs::path& file, const Communicator& ranks) {
  const StateCells state = readStateCells(file, ranks);
  if (!state.certified)
    throw InputError(fmt::format(
        "{}: is the state of a packing that is not finished; packing can continue from it (restart)",
        file.string()));
  HeldPacking packing;
  packing.ranks = ranks;
  packing.file = file;
  packing.words = wordsNow(state.command, file);
  for (const StateCells::Kind& kind : state.species)
    packing.kinds.push_back({kind.name, kind.mesh, kind.count});
  packing.kindOf.resize(packing.kinds.size());
  std::iota(packing.kindOf.begin(), packing.kindOf.end(), 0);
  for (const StateCell& cell : state.cells) {
    packing.result.poses.push_back(cell.pose);
    packing.result.cells.push_back({cell.species, placementOf(posLineOf(cell.pose))});
  }
  packing.result.cellCount = ranks.sum(std::int64_t(state.cells.size()));
  return packing;
}

HeldPacking completed(HeldPacking packing) {
  Scene scene = sceneOf(packing);
  if (isTiled(scene))
    throw InputError(fmt::format("{}: the box of a packing that was repeated in it (--tile) is not rebuilt",
                                 packing.file.string()));
  std::vector<int> speciesOf;
  for (const HeldPacking::Kind& kind : packing.kinds) {
    const auto species = std::find_if(scene.species.begin(), scene.species.end(), [&](const CellSpecies& s) {
      return s.name == kind.name && sameVertices(s.shape->mesh(), kind.mesh);
    });
    if (species == scene.species.end())
      throw InputError(fmt::format("{}: its template of '{}' is not that of the command {}",
                                   packing.file.string(), kind.name, fmt::join(packing.words, " ")));
    speciesOf.push_back(int(species - scene.species.begin()));
  }
  PackingResult& result = packing.result;
  for (PlacedCell& cell : result.cells) cell.species = speciesOf[cell.species];
  packing.kindOf.assign(scene.species.size(), -1);
  for (std::size_t kind = 0; kind < speciesOf.size(); ++kind) packing.kindOf[speciesOf[kind]] = int(kind);
  for (std::size_t i = 0; i < result.cells.size(); ++i)
    result.cells[i].placement = placementOf(scene.read.lineOf(result.poses[i]));
  result.certificate = examine(scene, packing.result.cells, packing.ranks).certificate;
  std::vector<std::int64_t> counts = countsOf(scene, result.cells);
  packing.ranks.sum(counts);
  packing.verified.cells.tally = tallyOf(scene, std::move(counts));
  packing.verified.kept = keptOf(scene, result.cells, packing.ranks);
  packing.scene = std::make_shared<const Scene>(std::move(scene));
  return packing;
}

std::vector<PosLine> posLinesOf(const HeldPacking& packing) {
  std::vector<PosLine> lines;
  for (const Pose& pose : packing.result.poses)
    lines.push_back(packing.scene ? packing.scene->read.lineOf(pose) : posLineOf(pose));
  return lines;
}

std::vector<fs::path> writeCells(const HeldPacking& packing, const fs::path& folder,
                                 const std::vector<std::string>& formats) {
  Scene scene = *packing.scene;
  scene.outputDirectory = folder;
  scene.exports = formats;
  onFirstRank(packing.ranks, [&] { requireWritableOutputs(scene, true); });
  return writeCellFiles(scene, packing.result, packing.verified.cells.tally.counts, packing.ranks);
}

void writePosFiles(const fs::path& folder,
                   const std::vector<std::pair<std::string, std::vector<PosLine>>>& cells) {
  const Communicator alone;
  SharedFiles files(alone);
  files.makeFolder(folder);
  for (const auto& cell : cells) {
    files.begin(folder / (cell.first + ".pos"));
    files.append([&] { return formatPosHead(std::int64_t(cell.second.size())); });
    files.append([&] { return formatPosLines(cell.second); });
    files.end();
  }
  files.commit();
}

void savePacking(const HeldPacking& packing, const std::vector<std::string>& words, const fs::path& file) {
  const Communicator& ranks = packing.ranks;
  if (packing.ownParts.empty())
    throw InputError(fmt::format("the packing was loaded from {}: copy that file", packing.file.string()));
  const PackingProblem problem = problemOf(*packing.scene, {}, {});
  const PackingResult& result = packing.result;
  PackingState state;
  state.position.stage = Stage::certificate;
  state.position.fewer = result.outcome == Outcome::outOfReach;
  state.cellCount = result.cellCount;
  const CellMeasures own = asFinished(packing, *packing.scene, [&](const Finished& done) {
    return measureShare(analysisInputOf(done), result.cells);
  });
  std::vector<BodyState> bodies;
  std::vector<MeasuredCell> measured;
  std::int64_t id = ranks.sumBefore({std::int64_t(result.poses.size())}).front();
  for (std::size_t part = 0, i = 0; part < packing.ownParts.size(); ++part)
    for (std::int64_t n = 0; n < packing.ownParts[part]; ++n, ++i, ++id) {
      BodyState body{};
      Eigen::Map<Vec3>(body.pose.position) = result.poses[i].position;
      Eigen::Map<Eigen::Vector4d>(body.pose.orientation) = result.poses[i].orientation.coeffs();
      body.scale = body.stepTaken = 1.0;
      body.species = std::int32_t(part);
      body.id = id;
      bodies.push_back(body);
      measured.push_back({id, own.gap[i], own.localHematocrit[i]});
    }
  const IdShares shares(result.cellCount, ranks);
  state.cells = shares.collect(std::move(bodies));
  for (const MeasuredCell& cell : shares.collect(measured)) {
    state.measures.gap.push_back(cell.gap);
    state.measures.localHematocrit.push_back(cell.localHematocrit);
  }
  writeState(file, problem, storedWords(words, file), state);
}

std::string reportOf(const HeldPacking& packing) {
  return asFinished(packing, *packing.scene,
                    [&](const Finished& done) { return reportText(done, packing.times); });
}

std::vector<fs::path> writeViewFiles(const HeldPacking& packing, const fs::path& folder, const Views& views) {
  Scene scene = *packing.scene;
  scene.outputDirectory = folder;
  scene.povScene = false;
  scene.vtp = views.vtp;
  scene.vtpMeshes = views.vtpMeshes;
  scene.reportFile = views.reportFile;
  onFirstRank(packing.ranks, [&] { requireWritableOutputs(scene, false); });
  SharedFiles(packing.ranks).makeFolder(folder);
  asFinished(packing, scene, [&](const Finished& done) { writeViews(done, packing.times); });
  return viewFiles(scene);
}

}  // namespace packmesh::hemocell
