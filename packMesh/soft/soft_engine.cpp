// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_engine.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/pose.h"
#include "packMesh/io/hdf5_file.h"
#include "packMesh/packing/id_shares.h"

namespace packmesh {
namespace {

/// Cells are at rest when SoftCells::usualForce() is less than SoftRest::tolerance; halved, as long as
/// HemoCell's forces are not as small as aimed at, down to the least [pN].
constexpr double leastAtRest = 0.02;
/// With half the tolerance HemoCell's largest force is to be at most this part of what it was; otherwise it
/// will not decrease much any more, and suffices if it is within the limit. So often [iterations] this is
/// asked even if cells do not come to rest: single vertices may flicker for thousands of iterations.
constexpr double worthResting = 0.9;
constexpr std::int64_t restlessFor = 500;
/// Before that, where forces are larger than aimed at, sharp folds are opened so often, each time with less
/// of the range of the wall's barrier.
constexpr int mostUnfolded = 3;
constexpr double wallFactor = 0.5;
/// Where forces or changes stay too large, cells begin elsewhere. Few cells do so, too, where forces are
/// within the limits but larger than usual: whether one has a sharp fold depends on where it began. Of many
/// cells, some have one wherever they begin.
constexpr int mostAttempts = 3, fewCells = 32;
/// Share of the time for all this; the rest is for the certificate. If fewer cells suffice: share for all of
/// them, how often cells are taken out, and iterations of the others then.
constexpr double shareOfGrowing = 0.9, shareOfAll = 0.6;
constexpr int mostRounds = 20;
constexpr std::int64_t iterationsOfRound = 3000;
/// Of cells of full size that are deformed too much, at most this share is taken out at once.
constexpr double mostOfDeformed = 0.1;
/// Iterations between two looks at HemoCell's forces.
constexpr std::int64_t lookEvery = 5;
constexpr std::int64_t reportEvery = 10;

/// Soft cells on their way from small ones to rest. All ranks call its functions together.
class RestingCells {
 public:
  RestingCells(const SoftModel& model, const SoftLimits& limits, std::vector<BodyState> placed,
               std::vector<SoftCell> cells)
      : RestingCells(model, limits, std::move(placed), settingsFor(model, cells), std::move(cells)) {}

  SoftRest rest;

  const std::vector<BodyState>& placed() const { return placed_; }
  const SoftCells& cells() const { return cells_; }
  bool isFull() const { return cells_.smallestScale() == 1.0; }

  void restore(const SoftCellsState& from, const SoftRest& itsRest) {
    cells_.restore(from);
    cells_.narrowWall(std::pow(wallFactor, itsRest.unfolded));
    rest = cells_.told(itsRest);
  }

  /// A step, or several. @param another whether there is another attempt
  void advance(std::int64_t iterations, bool another) {
    for (std::int64_t n = 0; cells_.computes() && n < cells_.stepsAtOnce(); ++n) {
      if (rest.reached || cells_.iterations() >= iterations) break;
      cells_.step();
      rest.reached = isAtRest(another);
      report();
    }
    rest = cells_.told(rest);
  }

  /// Whether all have their full size, and are within the limits.
  bool isGrown() const { return cells_.full() && limits_.allow(largestDeformation()); }

  /// Whether forces are larger than usual of cells that are so few that they can begin elsewhere.
  bool isUnusual(const Deformation& most) const {
    return most.force > limits_.usual &&
           std::count_if(placed_.begin(), placed_.end(),
                         [&](const BodyState& cell) { return model_.isSoft(cell); }) <= fewCells;
  }

  Deformation largestDeformation() const { return largestDeformation(ranks()); }
  bool anyMeetsWall() const;

  /// Those with their full size. @param small the cells from which they have grown
  std::vector<Cell> result(const SmallCells& small);
  /// Takes out those that find no room. @return nothing if no soft ones are left
  std::unique_ptr<RestingCells> withFewer();

 private:
  RestingCells(const SoftModel& model, const SoftLimits& limits, std::vector<BodyState> placed,
               const SoftSettings& settings, std::vector<SoftCell>&& cells)
      : model_(model),
        limits_(limits),
        placed_(std::move(placed)),
        cells_(std::move(cells), model.physics.container->period(), model.walls, settings,
               model.problem.execution.threads, ranks()) {}
  static SoftSettings settingsFor(const SoftModel& model, const std::vector<SoftCell>& cells) {
    SoftSettings settings = model.settings;
    if (std::all_of(cells.begin(), cells.end(), [](const SoftCell& cell) { return cell.scale == 1.0; }))
      settings.stiffening = 1.0;  // it is for cells that grow
    return settings;
  }
  bool isAtRest(bool another);
  std::vector<Deformation> deformations(const Communicator& among) const;
  Deformation largestDeformation(const Communicator& among) const {
    Deformation most;
    for (const Deformation& one : deformations(among)) most.enlarge(one);
    return most;
  }
  std::vector<char> withoutRoom() const;
  void report() const {
    if (model_.problem.execution.progress && cells_.iterations() % reportEvery == 0)
      model_.problem.execution.progress(
          {softCellsStage, cells_.iterations(), cells_.smallestScale(), 0.0, 0});
  }
  const Communicator& ranks() const { return model_.problem.execution.communicator; }

  const SoftModel& model_;
  const SoftLimits& limits_;
  std::vector<BodyState> placed_;  ///< undeformed, of all ranks
  SoftCells cells_;                ///< the same cells
};

/// Whether the edges of any cell meet a wall of cubes: only its vertices are kept off it.
bool RestingCells::anyMeetsWall() const {
  std::atomic<bool> meets = false;
  const std::vector<int>& mine = cells_.mine();
  model_.problem.execution.threads.forEach(std::int64_t(mine.size()), [&](std::int64_t n, int) {
    const BodyState& cell = placed_[mine[n]];
    const Wall* const wall = model_.physics.wallOf(cell.species);
    if (!model_.isSoft(cell) || !wall || wall->smoothReach() == 0.0) return;
    const std::vector<Triangle>& triangles = model_.membranes[cell.species]->mesh().triangles;
    if (wall->violation({cells_.vertices(std::size_t(mine[n])), triangles})) meets = true;
  });
  return ranks().any(meets);
}

/// Whether forces are as small as is aimed at, or more steps will hardly make them smaller. Of the ranks that
/// compute.
bool RestingCells::isAtRest(bool another) {
  if (!cells_.full() || cells_.iterations() % lookEvery != 0) return false;
  const bool small = cells_.usualForce() <= rest.tolerance, late = cells_.iterations() % restlessFor == 0;
  if (!small && !late) return false;
  const Deformation most = largestDeformation(cells_.team());
  if (small && ((most.force <= limits_.aim && limits_.allow(most)) || rest.tolerance <= leastAtRest))
    return true;
  const bool stuck = rest.forceBefore > 0.0 && most.force > worthResting * rest.forceBefore;
  if ((small || stuck) && rest.unfolded < mostUnfolded) {
    cells_.unfold(wallFactor);
    ++rest.unfolded;
    rest.forceBefore = 0.0;
    return false;
  }
  const bool suffices = limits_.allow(most) && (another || !isUnusual(most));
  if (stuck && (suffices || (late && another))) return true;
  rest.forceBefore = most.force;
  if (small) rest.tolerance *= 0.5;
  return false;
}

/// Of each cell. @param among ranks that all call, with all those that compute
std::vector<Deformation> RestingCells::deformations(const Communicator& among) const {
  struct Deformed {
    int cell;
    Deformation by;
  };
  std::vector<Deformed> mine;
  for (const int i : cells_.mine()) mine.push_back({i, {}});
  model_.problem.execution.threads.forEach(std::int64_t(mine.size()), [&](std::int64_t n, int) {
    const BodyState& cell = placed_[mine[n].cell];
    if (model_.isSoft(cell))
      mine[n].by = deformationOf(*model_.membranes[cell.species], cells_.vertices(std::size_t(mine[n].cell)));
  });
  std::vector<Deformation> each(placed_.size());
  for (const Deformed& one : among.gatherAll(mine)) each[one.cell] = one.by;
  return each;
}

/// The smallest cells, as many as lack volume together; if all have full size, the most deformed of those
/// beyond the limits. Pre: all ranks know all cells
std::vector<char> RestingCells::withoutRoom() const {
  const std::vector<Deformation> each = deformations(ranks());
  std::vector<std::pair<double, std::size_t>> order;  // by what is lacking
  double missing = 0.0, beyond = 0.0;                 // [cells]
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    if (!model_.isSoft(placed_[i])) continue;
    order.emplace_back(isFull() ? -limits_.share(each[i]) : cells_.scale(i), i);
    missing += 1.0 - std::pow(cells_.scale(i), 3);
    beyond += !limits_.allow(each[i]);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  if (isFull()) missing = std::min(beyond, std::max(1.0, mostOfDeformed * double(order.size())));
  std::vector<char> taken(placed_.size(), false);
  for (std::size_t n = 0; n < order.size() && double(n) < missing; ++n) taken[order[n].second] = true;
  return taken;
}

std::unique_ptr<RestingCells> RestingCells::withFewer() {
  cells_.gather();
  const std::vector<char> taken = withoutRoom();
  std::vector<SoftCell> left;
  std::vector<BodyState> placed;
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    if (taken[i]) continue;
    left.push_back(model_.cell(placed_[i], cells_.vertices(i), cells_.scale(i)));
    placed.push_back(placed_[i]);
  }
  if (std::none_of(placed.begin(), placed.end(), [&](const BodyState& cell) { return model_.isSoft(cell); }))
    return nullptr;
  return std::make_unique<RestingCells>(model_, limits_, std::move(placed), std::move(left));
}

std::vector<Cell> RestingCells::result(const SmallCells& small) {
  cells_.gather();
  cells_.forgetContacts();
  std::vector<Cell> out;
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    const BodyState& cell = placed_[i];
    if (model_.physics.species[cell.species].freedom.fixed) continue;
    const auto id = std::int64_t(out.size());
    if (model_.isSoft(cell)) {
      std::vector<Vec3> vertices = cells_.vertices(i);
      const Pose pose = bestPose(model_.membranes[cell.species]->mesh().vertices, vertices);
      out.push_back({id, cell.species, pose, inFrameOf(pose, std::move(vertices))});
      continue;
    }
    out.push_back({id, cell.species, cell.pose()});
    if (small.physics.isDeformed(cell)) out.back().vertices = small.physics.shapeOf(cell).mesh().vertices;
  }
  return out;
}

/// Attempts from several beginnings; what is packed is that of the first that succeeds, or of the best.
class SoftStage final : public EngineStage {
 public:
  SoftStage(const SoftEngine& engine, const PackingProblem& problem, RunControl& control,
            Statistics& statistics, std::function<void()> keep)
      : engine_(engine),
        problem_(problem),
        control_(control),
        statistics_(std::make_shared<SoftStatistics>()),
        keep_(std::move(keep)),
        model_(problem, engine.species) {
    statistics.engine = statistics_;
    stopAfter(problem.execution.limits.fewerCells ? shareOfAll : shareOfGrowing);
    if (problem.resume && problem.resume->position.stage == Stage::engine) resume(*problem.resume);
  }

  bool run(std::int64_t iterations) override;
  bool ended() const override { return ended_; }
  bool hasBegun() const override { return resting_ != nullptr; }
  std::int64_t iterations() const override { return resting_ ? resting_->cells().iterations() : 0; }
  std::vector<Body> cells() const override { return bodiesOf(saved_ ? saved_->cells : ownCells()); }
  std::shared_ptr<const EngineState> save() const override { return saved_ ? saved_->state : state(); }
  EngineCells take() override;

 private:
  struct Saved {
    std::vector<BodyState> cells;
    std::shared_ptr<SoftState> state;
  };
  /// What an attempt has reached.
  struct Reached {
    Outcome outcome = Outcome::outOfReach;
    SoftStatistics numbers;
    std::vector<Cell> cells;                 ///< if it has succeeded
    std::optional<Saved> beforeItsEnd = {};  ///< likewise, if states are saved on the way
  };

  void stopAfter(double share) {
    if (control_.limited()) control_.stopAfter(share * problem_.execution.limits.maxSeconds);
  }
  void resume(const PackingState& state);
  Reached attempt(std::int64_t iterations);
  bool beginsElsewhere(Reached& out);
  bool comeToRest(std::int64_t iterations, bool withStates);
  std::vector<Cell> packFewer(std::int64_t iterations);
  std::vector<BodyState> ownCells() const;
  std::shared_ptr<SoftState> state() const;
  bool savesOnTheWay() const { return problem_.checkpoints && problem_.checkpoints->due; }
  void begin();

  const SoftEngine& engine_;
  const PackingProblem& problem_;
  RunControl& control_;
  std::shared_ptr<SoftStatistics> statistics_;
  std::function<void()> keep_;
  const SoftModel model_;
  SmallCells small_;                       ///< from which `resting_` began
  std::unique_ptr<RestingCells> resting_;  ///< of the last attempt that has placed cells
  bool resumed_ = false;                   ///< the attempt begins with cells that are there
  bool meetsWall_ = false;                 ///< at the end of comeToRest()
  int attempt_ = 0;
  double scaleBefore_ = 1.0;  ///< of the small cells of the attempt before
  /// Of attempts within the limits but with unusual forces, the one with the least.
  struct Best {
    int attempt = -1;  ///< -1: none
    double force = 0.0, scale = 0.0;
    std::optional<Reached> result = {};  ///< none if this run has continued from a state after it
  } best_;
  bool repeats_ = false;        ///< this attempt is that one again
  std::optional<Saved> saved_;  ///< in place of the present state
  std::vector<Cell> packed_;
  bool ended_ = false;
};

bool SoftStage::run(std::int64_t iterations) {
  Reached out = attempt(iterations);
  while (beginsElsewhere(out)) out = attempt(iterations);
  if (best_.result && out.outcome == Outcome::outOfReach) out = *best_.result;  // for want of time
  *statistics_ = out.numbers;
  packed_ = std::move(out.cells);
  ended_ = out.outcome != Outcome::interrupted;
  const bool failed = out.outcome == Outcome::outOfReach;
  saved_ = std::move(out.beforeItsEnd);
  if (resting_ && (out.outcome != Outcome::certified || saved_)) keep_();
  if (failed && problem_.execution.limits.fewerCells && resting_) packed_ = packFewer(iterations);
  return out.outcome == Outcome::certified;
}

/// Whether there is another attempt after one that ended so. After the last one the best one is the result;
/// it is repeated if this run has continued from a state after it.
bool SoftStage::beginsElsewhere(Reached& out) {
  if (repeats_ || control_.stopped()) return false;
  const bool ended = out.numbers.done > 0 && out.numbers.scale == 1.0;
  const bool failed = out.outcome == Outcome::outOfReach;
  const bool unusual = ended && !failed && resting_->isUnusual(out.numbers.most);
  if (unusual && (best_.attempt < 0 || out.numbers.most.force < best_.force)) {
    best_ = {attempt_, out.numbers.most.force, small_.scale, out};
    if (auto& before = best_.result->beforeItsEnd) before->state->repeats = true;  // it is that attempt
  }
  if (resting_) scaleBefore_ = small_.scale;
  if (((ended && failed) || unusual) && attempt_ + 1 < mostAttempts) {
    ++attempt_;
    return true;
  }
  if ((!failed && !unusual) || best_.attempt < 0) return false;
  attempt_ = best_.attempt;
  scaleBefore_ = best_.scale;
  repeats_ = !best_.result;
  if (best_.result) out = *best_.result;
  return repeats_;
}

SoftStage::Reached SoftStage::attempt(std::int64_t iterations) {
  Reached out;
  if (!std::exchange(resumed_, false)) {
    std::optional<SmallCells> small = packSmallCells(model_, control_, attempt_, scaleBefore_);
    if (!small) {
      if (control_.interrupted()) out.outcome = Outcome::interrupted;
      return out;
    }
    small_ = std::move(*small);
    begin();
  }
  const bool packed = comeToRest(iterations, true);
  SoftStatistics& reached = out.numbers;
  reached.startScale = small_.scale;
  reached.done = resting_->cells().iterations();
  reached.scale = resting_->cells().smallestScale();
  reached.atRest = resting_->rest.reached;
  if (control_.interrupted()) {
    out.outcome = Outcome::interrupted;
    return out;
  }
  reached.most = resting_->largestDeformation();
  reached.meetsWall = meetsWall_;
  reached.succeeded = packed;
  if (packed) {
    out.outcome = Outcome::certified;
    out.cells = resting_->result(small_);
    if (savesOnTheWay()) out.beforeItsEnd = {ownCells(), state()};
  }
  return out;
}

/// @return whether all have full size, are within the limits, and do not meet the wall
bool SoftStage::comeToRest(std::int64_t iterations, bool withStates) {
  const bool another = attempt_ + 1 < mostAttempts || best_.attempt >= 0;
  while (!resting_->rest.reached && !control_.stopped() && resting_->cells().iterations() < iterations) {
    resting_->advance(iterations, another);
    if (withStates && savesOnTheWay() && problem_.execution.communicator.any(problem_.checkpoints->due()))
      keep_();
  }
  const bool grown = resting_->isGrown();
  meetsWall_ = grown && !control_.interrupted() && resting_->anyMeetsWall();
  return grown && !meetsWall_;
}

/// Takes out cells until the others can be packed. @return these
std::vector<Cell> SoftStage::packFewer(std::int64_t iterations) {
  stopAfter(shareOfGrowing);
  for (int round = 0; round < mostRounds && !control_.stopped(); ++round) {
    resting_ = resting_->withFewer();
    if (!resting_) break;
    const bool packed = comeToRest(std::min(iterations, iterationsOfRound), false);
    if (control_.interrupted()) break;
    if (packed) return resting_->result(small_);
  }
  return {};
}

/// Frees memory for the certificate.
EngineCells SoftStage::take() {
  resting_.reset();
  small_ = {};
  returnFreedMemory();
  if (packed_.empty()) return {};
  const std::vector<Cell> cells = std::exchange(packed_, {});
  return {{}, engine_.written ? engine_.written(cells) : placedIn(problem_.physics, cells)};
}

/// The cells that were placed become soft.
void SoftStage::begin() {
  std::vector<SoftCell> cells;
  for (const BodyState& cell : small_.placed)
    cells.push_back(model_.cell(cell, small_.vertices(cell), small_.scale));
  resting_ = std::make_unique<RestingCells>(model_, engine_.limits, small_.placed, std::move(cells));
}

std::vector<BodyState> SoftStage::ownCells() const {
  const auto [first, end] =
      IdShares(std::int64_t(small_.placed.size()), problem_.execution.communicator).own();
  std::vector<BodyState> own(small_.placed.begin() + first, small_.placed.begin() + end);
  for (BodyState& cell : own) {
    if (!model_.isSoft(cell)) continue;
    cell.shape = problem_.physics.species[cell.species].shape;
    cell.scale = small_.scale;
  }
  return own;
}

std::shared_ptr<SoftState> SoftStage::state() const {
  auto state = std::make_shared<SoftState>();
  state->membranes = model_.membranesDigest;
  state->attempt = small_.attempt;
  state->startScale = small_.scale;
  state->rest = resting_->rest;
  state->bestAttempt = best_.attempt;
  state->bestForce = best_.force;
  state->bestScale = best_.scale;
  state->repeats = repeats_;
  state->cells = resting_->cells().state();
  return state;
}

void SoftStage::resume(const PackingState& from) {
  const Communicator& ranks = problem_.execution.communicator;
  const auto& state = dynamic_cast<const SoftState&>(*from.engine);
  if (state.membranes != model_.membranesDigest)
    throw InputError(
        "the cells of the state to continue from have other membranes: the constants of their XML files, "
        "<kBT>, the lattice spacing, or which cells are rigid, differ");
  attempt_ = state.attempt;
  small_ = smallCellsOf(model_, attempt_, state.startScale, ranks.gatherAll(from.cells));
  begin();
  SoftCellsState cells = state.cells;
  cells.cells = ranks.gatherAll(cells.cells);
  cells.vertices = ranks.gatherAll(cells.vertices);
  resting_->restore(cells, state.rest);
  best_ = {state.bestAttempt, state.bestForce, state.bestScale, {}};
  repeats_ = state.repeats;
  resumed_ = true;
}

const std::string softGroup = "/soft";

}  // namespace

void SoftState::write(Hdf5Writer& out, const Physics& physics, const std::vector<BodyState>& placed) const {
  PastEngine(0).write(out, physics, placed);
  out.group(softGroup);
  out.attribute(softGroup, "membranes", membranes);
  out.commonTable<std::int64_t>(
      softGroup + "/position", 1,
      {cells.iterations, attempt, rest.reached, rest.unfolded, bestAttempt + 1, repeats});
  out.commonTable<double>(
      softGroup + "/numbers", 1,
      {cells.stiffening, cells.skin, startScale, rest.tolerance, rest.forceBefore, bestForce, bestScale});
  out.table(softGroup + "/cells", SoftCellsState::perCell, cells.cells);
  out.table(softGroup + "/vertices", SoftCellsState::perVertex, cells.vertices);
}

std::shared_ptr<const EngineState> SoftEngine::readState(const Hdf5Reader& in, const PackingProblem& problem,
                                                         std::int64_t first,
                                                         std::vector<BodyState>& own) const {
  constexpr std::int64_t mostCounted = 100'000'000'000'000'000;
  constexpr double most = 1e9;  // no length [µm] and no force [pN] is so large
  const auto all = [&](const auto& numbers, const auto& possible) {
    if (!std::all_of(numbers.begin(), numbers.end(), possible))
      in.fail("is damaged: it contains values out of range");
  };
  const auto possible = [](double x) { return std::abs(x) < most; };  // no NaN
  auto state = std::make_shared<SoftState>();
  state->membranes = in.text(softGroup, "membranes");
  const auto position = in.table<std::int64_t>(softGroup + "/position", 1, 0, 6);
  const auto numbers = in.table<double>(softGroup + "/numbers", 1, 0, 7);
  all(position, [](std::int64_t x) { return x >= 0 && x < mostCounted; });
  all(numbers, [&](double x) { return x >= 0.0 && possible(x); });
  state->cells.iterations = position[0];
  state->attempt = int(position[1]);
  state->rest = {position[2] != 0, numbers[3], numbers[4], int(position[3])};
  state->bestAttempt = int(position[4]) - 1;
  state->repeats = position[5] != 0;
  state->cells.stiffening = numbers[0];
  state->cells.skin = numbers[1];
  state->startScale = numbers[2];
  state->bestForce = numbers[5];
  state->bestScale = numbers[6];
  const auto verticesOf = [&](std::int32_t s) {
    return std::int64_t(problem.physics.shapeOf(problem.physics.species[s]).mesh().vertices.size());
  };
  std::int64_t before = 0, count = 0;  // vertices
  const auto others = in.table<std::int32_t>("/cells/species", 1, 0, first);
  all(others, [&](std::int64_t s) { return s >= 0 && s < std::int64_t(problem.physics.species.size()); });
  for (const std::int32_t s : others) before += verticesOf(s);
  for (const BodyState& cell : own) count += verticesOf(cell.species);
  state->cells.cells = in.table<double>(softGroup + "/cells", SoftCellsState::perCell, first,
                                        static_cast<std::int64_t>(own.size()));
  state->cells.vertices = in.table<float>(softGroup + "/vertices", SoftCellsState::perVertex, before, count);
  all(state->cells.cells, possible);
  all(state->cells.vertices, possible);
  return state;
}

double SoftLimits::share(const Deformation& of) const {
  return std::max({of.force / force, std::abs(of.volume) / volume, std::abs(of.area) / area});
}

void SoftEngine::validate(const PackingProblem& problem) const {
  if (species.size() != problem.physics.species.size())
    throw InputError("the engine of soft cells needs the membranes of all species of the problem");
}

std::shared_ptr<EngineStatistics> SoftEngine::statistics(std::int64_t iterations) const {
  auto statistics = std::make_shared<SoftStatistics>();
  statistics->done = iterations;
  return statistics;
}

std::unique_ptr<EngineStage> SoftEngine::begin(const PackingProblem& problem, RunControl& control,
                                               Statistics& statistics, std::function<void()> keep) const {
  return std::make_unique<SoftStage>(*this, problem, control, statistics, std::move(keep));
}

Physics placedIn(const Physics& physics, const std::vector<Cell>& cells) {
  Physics made = physics;
  for (Species& species : made.species) {
    if (species.freedom.fixed) continue;
    species.count = 0;
    species.asked = 0.0;
    species.deformed.clear();
    species.start.clear();
    species.inColumns = false;
    species.freedom.cone.reset();  // cells keep to these only until they grow
    species.freedom.region.reset();
  }
  for (const Cell& cell : cells) {
    Species& species = made.species[cell.species];
    ++species.count;
    if (cell.vertices.empty()) {
      species.start.push_back(cell.pose);
      continue;
    }
    species.deformed.push_back({int(made.shapes.size()), cell.pose});
    made.shapes.push_back(std::make_shared<const Shape>(cell.vertices, made.shapes[species.shape]));
  }
  return made;
}

}  // namespace packmesh
