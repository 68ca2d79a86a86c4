// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_packing.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/pose.h"
#include "packMesh/packing/engine.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/problem_digest.h"
#include "packMesh/soft/soft_cells.h"

namespace packmesh {
namespace {

/// Share of the lumen that small undeformed cells may fill: packing them takes milliseconds per cell. And the
/// one up to which it is tried whether deformation is needed at all.
constexpr double easyFraction = 0.52, possibleFraction = 0.58;
/// They are made smaller by this factor until they can be packed, and not smaller than `smallestStart`.
constexpr double smaller = 0.85, smallestStart = 0.25;
/// Sweeps for that at full size, where the result may need no deformation, and for smaller cells: where these
/// need more, still smaller ones are sooner packed and grown.
constexpr std::int64_t sweepsForResult = 3000, sweepsForStart = 100;
/// Gap that they begin with, as a share of the range of the barrier; and distance from walls of cubes, as a
/// share of the reach of the smoothed wall: it usually suffices, or Wall::smoothedBelow does.
constexpr double startGap = 0.35, usualStart = 1.3;
/// Share of the mean gap that is possible at a hematocrit which the range of barriers may have: in the
/// corners between cells gaps are wider.
constexpr double shareOfMeanGap = 0.8;
/// Where cells fill less of the lumen, contacts are so few that it takes longest to list them.
constexpr double sparse = 0.5;
/// The least range, as a share of the usual one.
constexpr double leastRange = 0.2;
/// Cells are at rest when SoftCells::usualForce() is less than this [pN]; halved, as long as HemoCell's
/// forces are not as small as aimed at, down to the least.
constexpr double atRest = 1.0, leastAtRest = 0.02;
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
constexpr int seedBits = 62;  // that nobody uses, so that attempts of one seed are not those of others
/// If fewer cells suffice: share of the time for all of them, how often cells are taken out, and iterations
/// of the others then.
constexpr double shareOfAll = 0.6;
constexpr int mostRounds = 20;
constexpr std::int64_t iterationsOfRound = 3000;
/// Of cells of full size that are deformed too much, at most this share is taken out at once.
constexpr double mostOfDeformed = 0.1;
/// Iterations between two looks at HemoCell's forces.
constexpr std::int64_t lookEvery = 5;
constexpr std::int64_t reportEvery = 10;
/// Iterations until cells of full size are at rest, where no fold is left: in boxes.
constexpr std::int64_t usualRest = 20;

/// Of what is not in the physics.
std::string digestOf(const std::vector<SoftSpecies>& softness) {
  Digest digest;
  for (const SoftSpecies& one : softness) {
    const MembraneConstants& m = one.membrane;
    for (const double constant : {m.link, m.bend, m.volume, m.area, m.thermalEnergy, m.spacing})
      digest.add(constant);
    if (m.model != MembraneModel::highOrder) {
      digest.add(int(m.model));
      for (const auto& end : m.innerLinks)
        for (const int v : end) digest.add(v);
      for (const MembraneConstants::Core& core : {m.cytoskeleton, m.core})
        for (const double constant : {core.force, core.radius}) digest.add(constant);
    }
    digest.add(one.rigid);
  }
  return digest.text();
}

class SoftPacker {
 public:
  SoftPacker(const PackingProblem& problem, const std::vector<SoftSpecies>& softness,
             const SoftLimits& limits)
      : problem_(problem),
        physics_(problem.physics),
        limits_(limits),
        control_(problem),
        membranesDigest_(digestOf(softness)) {
    double volume = 0.0, area = 0.0, growing = 0.0;
    for (std::size_t s = 0; s < physics_.species.size(); ++s) {
      const Species& species = physics_.species[s];
      const Shape& shape = *physics_.shapes[species.shape];
      const Shape& undeformed = shape.undeformed() ? *shape.undeformed() : shape;
      membranes_.push_back(std::make_shared<const Membrane>(undeformed.mesh(), softness[s].membrane));
      grows_.push_back(!species.freedom.fixed && !softness[s].rigid);
      const double ofSpecies = double(species.count) * membranes_.back()->volume();
      volume += ofSpecies;
      if (species.freedom.fixed) fixed_ += ofSpecies / physics_.container->volume();
      if (grows_.back()) growing += ofSpecies;
      area += double(species.count) * membranes_.back()->area();
    }
    fraction_ = volume / physics_.container->volume();
    growing_ = growing / physics_.container->volume();
    // A uniform gap g around membranes of this area leaves room for a fraction of V / (V + A g / 2).
    const double meanGap = 2.0 * (physics_.container->volume() - volume) / area;
    const double part = std::clamp(shareOfMeanGap * meanGap / settings_.range, leastRange, 1.0);
    settings_.range *= part;
    settings_.edgeRange *= part;
    settings_.wallRange *= part;
    settings_.clearance = physics_.clearance;
    if (fraction_ < sparse) settings_.skin *= 2.0;
    for (std::size_t s = 0; s < physics_.species.size(); ++s)
      if (const double reach = physics_.smoothReachOf(int(s)); reach > 0.0)
        settings_.wallRange = std::min(settings_.wallRange, reach);
    if (limits_.fewerCells && control_.limited())
      control_.stopAfter(shareOfAll * problem.execution.limits.maxSeconds);
  }

  /// canPackUndeformed().
  bool placeUndeformedEasily() {
    return fraction_ - fixed_ <= possibleFraction * (1.0 - fixed_) && placeUndeformed(1.0);
  }

  SoftPacking run() {
    if (problem_.resume) resume(*problem_.resume);
    SoftPacking out = attempt();
    while (beginsElsewhere(out)) out = attempt();
    if (best_.result && out.outcome == Outcome::outOfReach) out = *best_.result;  // for want of time
    const bool failed = out.outcome == Outcome::outOfReach;
    if (cells_ && problem_.checkpoints &&
        (out.outcome == Outcome::interrupted || (failed && limits_.savesFailed)))
      problem_.checkpoints->save(state());
    if (failed && limits_.fewerCells && cells_) takeOutUntilPacked(out);
    return out;
  }

 private:
  /// Whether there is another attempt after one that ended so. After the last one the best one is the result;
  /// it is repeated if this run has continued from a state after it.
  bool beginsElsewhere(SoftPacking& out) {
    if (repeats_ || control_.stopped()) return false;
    const bool ended = out.iterations > 0 && out.scale == 1.0, failed = out.outcome == Outcome::outOfReach;
    const bool unusual = ended && !failed && isUnusual(out.most);
    if (unusual && (best_.attempt < 0 || out.most.force < best_.force)) {
      best_ = {attempt_, out.most.force, scale_, out};
      if (auto& end = best_.result->end) end->soft->counters[5] = true;  // it is that attempt
    }
    if (((ended && failed) || unusual) && attempt_ + 1 < mostAttempts) {
      ++attempt_;
      return true;
    }
    if ((!failed && !unusual) || best_.attempt < 0) return false;
    attempt_ = best_.attempt;
    scale_ = best_.scale;
    repeats_ = !best_.result;
    if (best_.result) out = *best_.result;
    return repeats_;
  }

  bool isUnusual(const Deformation& most) const {
    return most.force > limits_.usual &&
           std::count_if(placed_.begin(), placed_.end(),
                         [&](const BodyState& cell) { return grows_[cell.species]; }) <= fewCells;
  }

  SoftPacking attempt() {
    SoftPacking out;
    if (!std::exchange(resumed_, false)) {
      if (!placeSmallCells(out)) return out;
      begin();
    }
    out.startScale = scale_;
    const bool packed = growAndComeToRest(limits_.iterations, true);
    out.iterations = cells_->iterations();
    out.scale = cells_->smallestScale();
    if (control_.interrupted()) {
      out.outcome = Outcome::interrupted;
      return out;
    }
    out.most = largestDeformation();
    out.meetsWall = meetsWall_;
    if (packed) {
      out.outcome = Outcome::certified;
      out.cells = result();
      if (problem_.checkpoints && problem_.checkpoints->due) out.end = state();
    }
    return out;
  }

  /// @return whether all have full size, are within the limits, and do not meet the wall
  bool growAndComeToRest(std::int64_t iterations, bool withCheckpoints) {
    while (!rest_.reached && !control_.stopped() && cells_->iterations() < iterations) {
      cells_->step();
      rest_.reached = isAtRest();
      report();
      if (withCheckpoints && problem_.checkpoints && problem_.checkpoints->due &&
          problem_.execution.communicator.any(problem_.checkpoints->due()))
        problem_.checkpoints->save(state());
    }
    const bool grown = cells_->full() && limits_.allow(largestDeformation());
    meetsWall_ = grown && !control_.interrupted() && anyMeetsWall();
    return grown && !meetsWall_;
  }

  /// Whether the edges of any cell meet a wall of cubes: only its vertices are kept off it.
  bool anyMeetsWall() const {
    std::atomic<bool> meets = false;
    const std::vector<int>& mine = cells_->mine();
    problem_.execution.threads.forEach(std::int64_t(mine.size()), [&](std::int64_t n, int) {
      const int s = placed_[mine[n]].species;
      const Wall* const wall = physics_.wallOf(s);
      if (!grows_[s] || !wall || wall->smoothReach() == 0.0) return;
      const std::vector<Triangle>& triangles = membranes_[s]->mesh().triangles;
      if (wall->violation({cells_->vertices(std::size_t(mine[n])), triangles})) meets = true;
    });
    return problem_.execution.communicator.any(meets);
  }

  /// Whether forces are as small as is aimed at, or more steps will hardly make them smaller.
  bool isAtRest() {
    const SoftCells& cells = *cells_;
    if (!cells.full() || cells.iterations() % lookEvery != 0) return false;
    const bool small = cells.usualForce() <= rest_.tolerance, late = cells.iterations() % restlessFor == 0;
    if (!small && !late) return false;
    const Deformation most = largestDeformation();
    if (small && ((most.force <= limits_.aim && limits_.allow(most)) || rest_.tolerance <= leastAtRest))
      return true;
    const bool stuck = rest_.forceBefore > 0.0 && most.force > worthResting * rest_.forceBefore;
    if ((small || stuck) && rest_.unfolded < mostUnfolded) {
      cells_->unfold(wallFactor);
      ++rest_.unfolded;
      rest_.forceBefore = 0.0;
      return false;
    }
    const bool another = attempt_ + 1 < mostAttempts || best_.attempt >= 0;
    const bool suffices = limits_.allow(most) && (another || !isUnusual(most));
    if (stuck && (suffices || (late && another))) return true;
    rest_.forceBefore = most.force;
    if (small) rest_.tolerance *= 0.5;
    return false;
  }

  PackingState state() const {
    PackingState out;
    out.position.stage = Stage::soft;
    out.cellCount = std::int64_t(placed_.size());
    const auto [first, end] = IdShares(out.cellCount, problem_.execution.communicator).own();
    for (std::int64_t i = first; i < end; ++i) {
      BodyState& cell = out.cells.emplace_back(placed_[i]);
      if (!grows_[cell.species]) continue;
      cell.shape = physics_.species[cell.species].shape;
      cell.scale = scale_;
    }
    SoftPosition& soft = out.soft.emplace();
    cells_->save(soft);
    soft.membranes = membranesDigest_;
    soft.counters[1] = attemptOfCells_;
    soft.counters[2] = rest_.reached;
    soft.counters[3] = rest_.unfolded;
    soft.counters[4] = best_.attempt + 1;
    soft.counters[5] = repeats_;
    soft.numbers[2] = scale_;
    soft.numbers[3] = rest_.tolerance;
    soft.numbers[4] = rest_.forceBefore;
    soft.numbers[5] = best_.force;
    soft.numbers[6] = best_.scale;
    return out;
  }

  void resume(const PackingState& state) {
    const Communicator& ranks = problem_.execution.communicator;
    SoftPosition soft = *state.soft;
    if (soft.membranes != membranesDigest_)
      throw InputError(
          "the cells of the state to continue from have other membranes: the constants of their XML files, "
          "<kBT>, "
          "the lattice spacing, or which cells are rigid, differ");
    attempt_ = int(soft.counters[1]);
    scale_ = soft.numbers[2];
    small_ = smallPhysics(scale_, usualStart);
    placed_ = ranks.gatherAll(state.cells);
    for (BodyState& cell : placed_) {
      cell.scale = 1.0;  // of the small shapes
      if (grows_[cell.species]) cell.shape = small_.species[cell.species].shape;
    }
    begin();
    soft.cells = ranks.gatherAll(soft.cells);
    soft.vertices = ranks.gatherAll(soft.vertices);
    cells_->restore(soft);
    rest_ = {soft.counters[2] != 0, soft.numbers[3], soft.numbers[4], int(soft.counters[3])};
    best_ = {int(soft.counters[4]) - 1, soft.numbers[5], soft.numbers[6], {}};
    repeats_ = soft.counters[5] != 0;
    cells_->narrowWall(std::pow(wallFactor, rest_.unfolded));
    resumed_ = true;
  }

  /// Takes out cells until the others can be packed.
  void takeOutUntilPacked(SoftPacking& out) {
    if (control_.limited()) control_.stopAfter(problem_.execution.limits.maxSeconds);
    for (int round = 0; round < mostRounds && !control_.stopped(); ++round) {
      cells_->gather();
      const std::vector<char> taken = withoutRoom();
      std::vector<SoftCell> left;
      std::size_t kept = 0;
      for (std::size_t i = 0; i < placed_.size(); ++i) {
        if (taken[i]) continue;
        left.push_back(softCell(i, cells_->vertices(i), cells_->scale(i)));
        placed_[kept++] = placed_[i];
      }
      placed_.resize(kept);
      if (std::none_of(placed_.begin(), placed_.end(),
                       [&](const BodyState& cell) { return grows_[cell.species]; }))
        return;
      begin(std::move(left));
      const bool packed = growAndComeToRest(std::min(limits_.iterations, iterationsOfRound), false);
      const bool interrupted = control_.interrupted();
      if (interrupted)
        out.outcome = Outcome::interrupted;
      else if (packed)
        out.cells = result();
      if (interrupted || packed) return;
    }
  }

  /// The smallest cells, as many as lack volume together; if all have full size, the most deformed of those
  /// beyond the limits.
  std::vector<char> withoutRoom() const {
    const bool full = cells_->smallestScale() == 1.0;
    const std::vector<Deformation> each = deformations();
    std::vector<std::pair<double, std::size_t>> order;  // by what is lacking
    double missing = 0.0, beyond = 0.0;                 // [cells]
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      if (!grows_[placed_[i].species]) continue;
      order.emplace_back(full ? -limits_.share(each[i]) : cells_->scale(i), i);
      missing += 1.0 - std::pow(cells_->scale(i), 3);
      beyond += !limits_.allow(each[i]);
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    if (full) missing = std::min(beyond, std::max(1.0, mostOfDeformed * double(order.size())));
    std::vector<char> taken(placed_.size(), false);
    for (std::size_t n = 0; n < order.size() && double(n) < missing; ++n) taken[order[n].second] = true;
    return taken;
  }

  /// Packs undeformed cells, as large as that is easy. @return whether it succeeded
  bool placeSmallCells(SoftPacking& out) {
    if (growing_ > 0.0) {
      // Of the lumen that is left by cells that do not grow.
      const double left = std::max(0.0, 1.0 - (fraction_ - growing_));
      double scale = attempt_ == 0 ? std::min(smaller, std::cbrt(easyFraction * left / growing_)) : scale_;
      for (; scale > smallestStart && !control_.stopped(); scale *= smaller)
        if (placeUndeformed(scale)) return true;
    }
    out.scale = 0.0;
    out.outcome = control_.interrupted() ? Outcome::interrupted : Outcome::outOfReach;
    return false;
  }

  Physics smallPhysics(double scale, double ofSmoothed) const {
    // Those of full size are a result, if there are any.
    const double gap = scale == 1.0 ? 0.0 : startGap * settings_.range * scale;
    Physics small = scaledPhysics(physics_, grows_, scale, gap, ofSmoothed);
    small.seed += std::uint64_t(attempt_) << seedBits;
    return small;
  }

  /// Packs undeformed cells at a scale. @return false: they are not packed easily
  bool placeUndeformed(double scale) {
    if (!placeUndeformed(scale, usualStart)) return false;
    return areWithinWalls() || (placeUndeformed(scale, Wall::smoothedBelow) && areWithinWalls());
  }

  bool placeUndeformed(double scale, double ofSmoothed) {
    PackingProblem small{smallPhysics(scale, ofSmoothed), nullptr, problem_.execution};
    if (problem_.execution.progress)
      small.execution.progress = [this, scale](Progress progress) {
        progress.scale *= scale;
        problem_.execution.progress(progress);
      };
    Limits& limits = small.execution.limits;
    limits.fewerCells = limits.someCloser = false;
    limits.maxSweeps = std::min(scale == 1.0 ? sweepsForResult : sweepsForStart, limits.maxSweeps);
    if (control_.limited())
      limits.maxSeconds = std::max(Limits::leastSeconds, limits.maxSeconds - control_.elapsed());
    PackingResult packed;
    try {
      packed = pack(small);
    } catch (const InputError&) {  // too large for the lumen
      if (scale * smaller <= smallestStart) throw;
      return false;
    }
    if (packed.outcome != Outcome::certified) return false;
    scale_ = scale;
    small_ = std::move(small.physics);
    const Communicator& ranks = problem_.execution.communicator;
    std::int64_t id = ranks.sumBefore({std::int64_t(packed.cells.size())}).front();
    std::vector<BodyState> own;
    for (std::size_t i = 0; i < packed.cells.size(); ++i)
      own.push_back(stateOf(id++, packed.cells[i].species, packed.cells[i].shape, packed.poses[i]));
    placed_ = ranks.gatherAll(own);
    return true;
  }

  /// Whether cells at less than their size keep to the smoothed walls of their species.
  bool areWithinWalls() {
    makeWalls();
    std::atomic<bool> within = true;
    problem_.execution.threads.forEach(std::int64_t(placed_.size()), [&](std::int64_t i, int) {
      const int s = placed_[i].species;
      if (scale_ == 1.0 || !grows_[s] || physics_.smoothReachOf(s) == 0.0) return;
      for (const Vec3& v : placedVertices(small_.shapeOf(placed_[i]).mesh(), placed_[i].pose().placement()))
        if (walls_[wallOf_[s]](v).distance <= 0.0) within = false;
    });
    return within;
  }

  void makeWalls() {
    if (!wallOf_.empty()) return;
    for (int s = 0; s < int(physics_.species.size()); ++s) {
      const auto gap = wallGapOf(physics_, s);
      wallOf_.push_back(gap ? int(walls_.size()) : -1);
      if (gap) walls_.push_back(*gap);
    }
  }

  /// @param i number among those that were placed
  SoftCell softCell(std::size_t i, std::vector<Vec3> vertices, double scale) const {
    const int s = placed_[i].species;
    return {membranes_[s], std::move(vertices), grows_[s] ? scale : 1.0, !grows_[s],
            grows_[s] ? wallOf_[s] : -1};
  }

  /// The cells that were placed become soft.
  void begin() {
    makeWalls();
    std::vector<SoftCell> cells;
    for (std::size_t i = 0; i < placed_.size(); ++i)
      cells.push_back(softCell(
          i, placedVertices(small_.shapeOf(placed_[i]).mesh(), placed_[i].pose().placement()), scale_));
    begin(std::move(cells));
  }

  void begin(std::vector<SoftCell> cells) {
    SoftSettings settings = settings_;
    if (std::all_of(cells.begin(), cells.end(), [](const SoftCell& cell) { return cell.scale == 1.0; }))
      settings.stiffening = 1.0;  // it is for cells that grow
    attemptOfCells_ = attempt_;
    rest_ = {};
    cells_ = std::make_unique<SoftCells>(std::move(cells), physics_.container->period(), walls_, settings,
                                         problem_.execution.threads, problem_.execution.communicator);
  }

  std::vector<Deformation> deformations() const {
    struct Deformed {
      int cell;
      Deformation by;
    };
    std::vector<Deformed> mine;
    for (const int i : cells_->mine()) mine.push_back({i, {}});
    problem_.execution.threads.forEach(std::int64_t(mine.size()), [&](std::int64_t n, int) {
      const int i = mine[n].cell, s = placed_[i].species;
      if (grows_[s]) mine[n].by = deformationOf(*membranes_[s], cells_->vertices(std::size_t(i)));
    });
    std::vector<Deformation> each(placed_.size());
    for (const Deformed& one : problem_.execution.communicator.gatherAll(mine)) each[one.cell] = one.by;
    return each;
  }

  Deformation largestDeformation() const {
    Deformation most;
    for (const Deformation& one : deformations()) most.enlarge(one);
    return most;
  }

  std::vector<Cell> result() const {
    SoftCells& cells = *cells_;
    cells.gather();
    cells.forgetContacts();
    std::vector<Cell> out;
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      const int s = placed_[i].species;
      if (physics_.species[s].freedom.fixed) continue;
      const auto id = std::int64_t(out.size());
      if (grows_[s]) {
        std::vector<Vec3> vertices = cells.vertices(i);
        const Pose pose = bestPose(membranes_[s]->mesh().vertices, vertices);
        out.push_back({id, s, pose, inFrameOf(pose, std::move(vertices))});
        continue;
      }
      out.push_back({id, s, placed_[i].pose()});
      if (small_.isDeformed(placed_[i])) out.back().vertices = small_.shapeOf(placed_[i]).mesh().vertices;
    }
    return out;
  }

  /// At least; 0: not known. Cells that keep a fold come to rest in thousands of iterations.
  std::int64_t iterationsLeft() const {
    const std::int64_t untilFull = cells_->iterationsUntilFull(scale_);
    return untilFull > 0 ? untilFull + usualRest : 0;
  }

  void report() const {
    if (!problem_.execution.progress || cells_->iterations() % reportEvery != 0) return;
    problem_.execution.progress(
        {softCellsStage, cells_->iterations(), cells_->smallestScale(), 0.0, 0, iterationsLeft()});
  }

  const PackingProblem& problem_;
  const Physics& physics_;
  SoftLimits limits_;
  RunControl control_;
  std::vector<std::shared_ptr<const Membrane>> membranes_;
  SoftSettings settings_;
  std::vector<char> grows_;             ///< of each species, whether its cells are soft
  double fraction_ = 0.0;               ///< of the lumen, that cells fill
  double fixed_ = 0.0, growing_ = 0.0;  ///< likewise, fixed ones and those that are soft
  double scale_ = 1.0;
  int attempt_ = 0, attemptOfCells_ = 0;
  bool meetsWall_ = false;  ///< at the end of growAndComeToRest()
  bool resumed_ = false;    ///< the attempt begins with cells that are there
  /// Of attempts within the limits but with unusual forces, the one with the least.
  struct Best {
    int attempt = -1;  ///< -1: none
    double force = 0.0, scale = 0.0;
    std::optional<SoftPacking> result = {};  ///< none if this run has continued from a state after it
  } best_;
  bool repeats_ = false;  ///< this attempt is that one again
  std::string membranesDigest_;
  /// Whether the cells are at rest, and what decides it.
  struct Rest {
    bool reached = false;
    double tolerance = atRest;  ///< usual force of the method with which they are at rest [pN]
    double forceBefore = 0.0;   ///< HemoCell's at the last decision; 0: none since folds were opened [pN]
    int unfolded = 0;           ///< how often sharp folds were opened
  } rest_;
  Physics small_;
  std::vector<BodyState> placed_;  ///< undeformed, of all ranks, with shapes of small_
  std::vector<WallGap> walls_;
  std::vector<int> wallOf_;           ///< of each species, index into walls_; -1: none
  std::unique_ptr<SoftCells> cells_;  ///< those that were placed
};

}  // namespace

double SoftLimits::share(const Deformation& of) const {
  return std::max({of.force / force, std::abs(of.volume) / volume, std::abs(of.area) / area});
}

SoftPacking packSoft(const PackingProblem& problem, const std::vector<SoftSpecies>& species,
                     const SoftLimits& limits) {
  SoftPacking packed = SoftPacker(problem, species, limits).run();
  returnFreedMemory();
  return packed;
}

bool canPackUndeformed(const PackingProblem& problem, const std::vector<SoftSpecies>& species) {
  return SoftPacker(problem, species, {}).placeUndeformedEasily();
}

}  // namespace packmesh
