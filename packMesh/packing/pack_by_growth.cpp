// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack_by_growth.h"

#include <algorithm>
#include <utility>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/certificate/certify.h"
#include "packMesh/core/timer.h"
#include "packMesh/growth/growth.h"
#include "packMesh/growth/seeding.h"
#include "packMesh/packing/growth_scene.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/run_control.h"

namespace packmesh {
namespace {

/// Of attempts that are not the last one.
constexpr int giveUpAfter = 2;

/// Seeds of attempts differ by multiples of this.
constexpr std::uint64_t attemptStride = 0x9E3779B97F4A7C15u;

Progress progressOf(const GrowthState& state, double barrier, const GrowthStatistics& statistics) {
  Progress progress{"growth", statistics.iterations, barrier, 0.0, 0};
  for (const GrowingCell& cell : state) progress.unresolved += cell.pose.scale < barrier;
  return progress;
}

/// One problem, packed.
class GrowthRun {
 public:
  explicit GrowthRun(const PackingProblem& problem)
      : problem_(problem),
        control_(problem),
        scene_(distributed(growthSceneOf(problem), problem.communicator)),
        planeFunction_(makePlaneFunction(problem.planeSource, scene_, tetrahedra_)) {
    scene_.stop = [this] { return control_.stoppedHere(); };
    for (const Species& species : problem.species) {
      counts_.push_back(species.count);
      names_.push_back(species.name);
      cells_ += species.count;
    }
  }

  PackingResult operator()() {
    result_.statistics.growth.emplace();
    const std::int64_t attempts =
        std::max<std::int64_t>(1, problem_.growth.attempts / std::max<std::int64_t>(1, cells_));
    bool grown = false;
    GrowthState best;
    const bool ended = problem_.resume && problem_.resume->position.stage == Stage::certificate;
    if (problem_.resume) resume(*problem_.resume, ended ? best : resumed_);
    if (ended) grown = complete(best);
    for (; at_.attempt < attempts && !ended && !grown && !stopped(); ++at_.attempt, at_.progress = {}) {
      scene_.seed = problem_.seed + static_cast<std::uint64_t>(at_.attempt) * attemptStride;
      GrowthState state = std::exchange(resumed_, {});
      grown = grow(at_.attempt + 1 == attempts, state);
      if (best_.empty() || countFull(state) > countFull(best_)) best_ = std::move(state);
    }
    if (!ended) best = best_;
    if (!ended && problem_.escape && (!grown || anyStock()) && !stopped()) grown = escapeFrom(best);
    if (problem_.checkpoints) {
      if (!control_.interrupted() && (grown || ended || problem_.checkpoints->endsWithFewer)) {
        keepState(Stage::certificate, best);
        measure(best);
      }
      problem_.checkpoints->save(kept_);
    }
    result_.outcome = control_.interrupted() ? Outcome::interrupted
                      : grown                ? Outcome::certified
                                             : Outcome::outOfReach;
    if (!control_.interrupted()) takeCells(best);
    if (problem_.planeSource != PlaneSource::chords) result_.statistics.tetrahedra = tetrahedraOfAllRanks();
    return std::move(result_);
  }

 private:
  static GrowthScene distributed(GrowthScene scene, const Communicator& communicator) {
    scene.communicator = communicator;
    return scene;
  }

  bool grow(bool lastAttempt, GrowthState& state) {
    GrowthSettings settings = problem_.growth;
    if (!lastAttempt) settings.giveUpAfter = giveUpAfter;
    if (state.empty()) {
      const Timer watch(result_.statistics.placementSeconds);
      state = seed(scene_, counts_, names_, settings);
    }
    if (kept_.cellCount == 0) keepState(Stage::growth, state);
    const Timer watch(result_.statistics.growthSeconds);
    GrowthCallbacks callbacks;
    callbacks.stop = [this] { return stopped(); };
    callbacks.accepted = [this](const GrowthState& now, double barrier, const GrowthStatistics& sums) {
      if (problem_.progress) problem_.progress(progressOf(now, barrier, sums));
      if (problem_.observe) problem_.observe(placed(now));
    };
    callbacks.checkpoint = [this](const GrowthState& now, const GrowthProgress& progress) {
      at_.progress = progress;
      keepState(Stage::growth, now);
    };
    return packmesh::grow(scene_, settings, planeFunction_, callbacks, state, *result_.statistics.growth,
                          at_.progress);
  }

  /// Keeps what is saved if the run should end before this is done again.
  void keepState(Stage stage, const GrowthState& state) {
    if (!problem_.checkpoints) return;
    const Communicator& ranks = problem_.communicator;
    kept_ = PackingState();
    kept_.position.stage = stage;
    kept_.growth = at_;
    kept_.growth.iterations = result_.statistics.growth->iterations;
    kept_.growth.best = statesOf(best_, 0, static_cast<std::int64_t>(best_.size()));
    kept_.cellCount = static_cast<std::int64_t>(state.size());
    const auto [first, end] = IdShares(kept_.cellCount, ranks).own();
    kept_.cells = statesOf(state, first, end);
    const auto& due = problem_.checkpoints->due;
    if (due && ranks.any(due())) problem_.checkpoints->save(kept_);
  }

  void resume(const PackingState& saved, GrowthState& state) {
    at_ = saved.growth;
    at_.best.clear();
    result_.statistics.growth->iterations = at_.iterations;
    best_ = cellsOf(saved.growth.best);
    state = cellsOf(problem_.communicator.gatherAll(saved.cells));
  }

  static std::vector<BodyState> statesOf(const GrowthState& state, std::int64_t first, std::int64_t end) {
    std::vector<BodyState> states;
    for (std::int64_t i = first; i < end; ++i) {
      Body body;
      body.id = i;
      body.species = state[i].species;
      body.scale = state[i].pose.scale;
      body.position = state[i].pose.position;
      body.orientation = state[i].pose.orientation;
      states.push_back(stateOf(body));
    }
    return states;
  }
  static GrowthState cellsOf(const std::vector<BodyState>& states) {
    GrowthState cells;
    for (const BodyState& state : states) cells.push_back({state.species, bodyOf(state).pose()});
    return cells;
  }

  /// Done by all ranks alike. Swapping may gain volume with full cells that become smaller: if less volume
  /// were in full cells then, the state stays as it was.
  /// @return whether the state is complete
  bool escapeFrom(GrowthState& state) {
    const GrowthState before = state;
    GrowthScene scene = distributed(scene_, Communicator());
    if (!problem_.communicator.alone()) scene.stop = {};  // ranks must not part ways
    const Timer watch(result_.statistics.growthSeconds);
    const PlaneFunctionFactory factory = [this](const GrowthScene& part) {
      return makePlaneFunction(problem_.planeSource, part, tetrahedra_);
    };
    const auto observe = [this](const GrowthState& now) {
      if (problem_.observe) problem_.observe(placed(now));
    };
    // All ranks poll equally often; that they agree takes longer than what is done between two polls.
    const auto stop = [this, polls = std::int64_t{0}, ended = false]() mutable {
      constexpr std::int64_t pollsPerAgreement = 64;
      ended = ended || (polls++ % pollsPerAgreement == 0 && stopped());
      return ended;
    };
    result_.statistics.escape =
        escape(scene, problem_.growth, *problem_.escape, factory, stop, observe, state);
    std::stable_sort(state.begin(), state.end(),
                     [](const GrowingCell& a, const GrowingCell& b) { return a.species < b.species; });
    if (fullVolume(state) < fullVolume(before)) state = before;
    return complete(state);
  }

  std::vector<PlacedCell> placed(const GrowthState& state) const {
    std::vector<PlacedCell> cells;
    for (const GrowingCell& cell : state) cells.push_back({cell.species, scene_.placement(cell.pose)});
    return cells;
  }

  /// Whether to stop, for whatever reason; the same on all ranks.
  bool stopped() {
    return control_.stopped() || result_.statistics.growth->iterations >= problem_.limits.maxSweeps;
  }

  static std::int64_t countFull(const GrowthState& state) {
    return std::count_if(state.begin(), state.end(),
                         [](const GrowingCell& c) { return c.pose.scale == 1.0; });
  }

  bool anyStock() const {
    const std::vector<std::int64_t>& reserve = problem_.escape->reserve;
    return std::any_of(reserve.begin(), reserve.end(), [](std::int64_t bodies) { return bodies > 0; });
  }

  double fullVolume(const GrowthState& state) const {
    double volume = 0.0;
    for (const GrowingCell& cell : state)
      if (cell.pose.scale == 1.0) volume += scene_.shapes[cell.species]->volume();
    return volume;
  }

  /// Whether there are as many full cells of each species as asked for, or more from the reserve.
  bool complete(const GrowthState& state) const {
    std::vector<std::int64_t> full(counts_.size(), 0);
    for (const GrowingCell& cell : state) full[cell.species] += cell.pose.scale == 1.0;
    for (std::size_t s = 0; s < counts_.size(); ++s)
      if (full[s] < counts_[s]) return false;
    return true;
  }

  /// The cells that reached full size, certified.
  void takeCells(const GrowthState& state) {
    const Timer watch(result_.statistics.certificateSeconds);
    for (const GrowingCell& cell : state) {
      if (cell.pose.scale != 1.0) continue;
      result_.cells.push_back({cell.species, scene_.placement(cell.pose)});
      result_.poses.push_back(cell.pose);
    }
    const Communicator& ranks = problem_.communicator;
    std::vector<Vec3> centres;
    std::vector<std::int64_t> numbers;
    for (const Pose& pose : result_.poses) {
      centres.push_back(pose.position);
      numbers.push_back(static_cast<std::int64_t>(numbers.size()));
    }
    const CellShares shares(centres, ranks);
    std::vector<bool> own;
    for (const std::int64_t cell : numbers) own.push_back(shares.own(cell));
    CertificateInput input = certificateInput(result_.cells, own);
    input.stop = [this] { return control_.outOfTimeHere(); };
    result_.certificate = ofAllRanks(certify(input), numbers, ranks);
    if (!result_.certificate.complete) {
      result_.cells.clear();
      result_.poses.clear();
      control_.outOfTime();
      result_.outcome = control_.interrupted() ? Outcome::interrupted : Outcome::outOfReach;
    }
    keepShare();
  }

  /// References its arguments.
  CertificateInput certificateInput(const std::vector<PlacedCell>& cells,
                                    const std::vector<bool>& own) const {
    CertificateInput input;
    input.own = &own;
    input.shapes = scene_.shapes;
    input.walls = scene_.walls;
    input.container = scene_.container;
    input.cells = &cells;
    input.requiredGap = scene_.clearance;
    input.requiredWallGap = scene_.wallClearance;
    return input;
  }

  /// Measures the cells of the state that is kept.
  void measure(const GrowthState& state) {
    const std::vector<PlacedCell> cells = placed(state);
    std::vector<bool> own(cells.size(), false);
    const auto [first, end] = IdShares(kept_.cellCount, problem_.communicator).own();
    std::fill(own.begin() + first, own.begin() + end, true);
    kept_.measures = measureCells(problem_.analysisInput(), certificateInput(cells, own));
  }

  TetrahedraSums tetrahedraOfAllRanks() const {
    const Communicator& ranks = problem_.communicator;
    TetrahedraSums sums = tetrahedra_;
    for (std::int64_t* count : {&sums.runs, &sums.attempts, &sums.finer, &sums.failures})
      *count = ranks.sum(*count);
    const std::vector<char> failures =
        ranks.gatherAll(std::vector<char>(sums.lastFailure.begin(), sums.lastFailure.end()));
    sums.lastFailure.assign(failures.begin(), failures.end());
    return sums;
  }

  /// All ranks know all cells; each keeps its share of them.
  void keepShare() {
    const Communicator& ranks = problem_.communicator;
    result_.cellCount = static_cast<std::int64_t>(result_.cells.size());
    const auto from = result_.cellCount * ranks.rank() / ranks.size();
    const auto to = result_.cellCount * (ranks.rank() + 1) / ranks.size();
    result_.cells = {result_.cells.begin() + from, result_.cells.begin() + to};
    result_.poses = {result_.poses.begin() + from, result_.poses.begin() + to};
  }

  const PackingProblem& problem_;
  RunControl control_;
  GrowthScene scene_;
  TetrahedraSums tetrahedra_;
  PlaneFunction planeFunction_;
  std::vector<std::int64_t> counts_;
  std::vector<std::string> names_;
  std::int64_t cells_ = 0;
  GrowthPosition at_;
  GrowthState best_;     ///< of the attempts so far
  GrowthState resumed_;  ///< where the first attempt goes on
  PackingState kept_;
  PackingResult result_;
};

}  // namespace

PackingResult packByGrowth(const PackingProblem& problem) {
  return GrowthRun(problem)();
}

}  // namespace packmesh
