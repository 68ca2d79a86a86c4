// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "packMesh/error.h"
#include "packMesh/packing/cell_measures.h"
#include "packMesh/packing/fixed_cells.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/pack_by_growth.h"
#include "packMesh/packing/regrown_cells.h"
#include "packMesh/packing/validate_problem.h"
#include "packMesh/packing/written_cells.h"
#include "packMesh/stages/certificate/certifier.h"
#include "packMesh/stages/placement/columns.h"
#include "packMesh/stages/placement/placement.h"
#include "packMesh/stages/relaxation/relaxation.h"
#include "packMesh/stages/relaxation/schedule.h"
#include "packMesh/stopwatch.h"
#include "packMesh/tolerances.h"

namespace packmesh {
namespace {

/// Rounds of repair before a packing counts as not resolved, and sweeps in each.
constexpr int repairRounds = 60;
constexpr std::int64_t repairSweeps = 400;

/// Thin parts of cells can pierce each other between their sample points, where a little more clearance
/// changes nothing: pairs that fail more often than this get twice as much every time.
constexpr int patience = 2;

/// When all cells do not fit: the share of them, the most overlapped, that is taken out before trying again,
/// and sweeps for each trial.
constexpr double thinning = 0.01;
constexpr std::int64_t thinningSweeps = 400;

/// With a time limit, thinning out takes about as long again at most: a trial ends after a tenth of the
/// limit, and with every tenth spent the share doubles. After five of them whatever still fails is left out.
constexpr double thinningParts = 10.0, mostThinningParts = 5.0;

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// One run of pack(). All ranks take the same way through it.
class Run {
 public:
  explicit Run(const PackingProblem& problem)
      : problem_(problem),
        start_(std::chrono::steady_clock::now()),
        deadline_(problem.limits.maxSeconds),
        shares_(cellsOf(problem), problem.communicator),
        written_(problem) {}

  PackingResult operator()() {
    Relaxation relaxation = problem_.resume ? resumed(*problem_.resume) : placed();
    keepState(relaxation);
    bool resolved = startsClean(relaxation);
    while (!at_.thinning && !resolved && !interrupted_ && relaxed(relaxation))
      resolved = certified(relaxation);
    PackingState all;
    if (!resolved && !interrupted_) {
      if (problem_.checkpoints && !problem_.checkpoints->endsWithFewer) all = kept_;
      thinOut(relaxation);
    }
    if (problem_.checkpoints) {
      if (!interrupted_ && all.cellCount > 0) {
        kept_ = std::move(all);
      } else if (!interrupted_) {
        keepState(relaxation);
        measure(relaxation);
      }
      problem_.checkpoints->save(kept_);
    }
    result_.outcome = interrupted_ ? Outcome::interrupted
                      : resolved   ? Outcome::certified
                                   : Outcome::outOfReach;
    result_.statistics.blocks = relaxation.blockCount();
    result_.statistics.sweeps = relaxation.sweeps();
    return std::move(result_);
  }

 private:
  static std::int64_t cellsOf(const PackingProblem& problem) {
    std::int64_t cells = 0;
    for (const Species& species : problem.species) cells += species.count;
    return cells;
  }

  RelaxationInput relaxationInput() const {
    RelaxationInput input;
    for (const Species& species : problem_.species) {
      input.shapes.push_back(species.shape.get());
      input.walls.push_back(problem_.wallOf(species));
      input.freedoms.push_back(species.freedom);
    }
    input.bounds = problem_.container->bounds();
    input.period = problem_.container->period();
    input.clearance = problem_.clearance + tolerance::relaxationMargin;
    input.wallClearance = problem_.wallClearance + tolerance::relaxationMargin;
    input.rotate = problem_.rotate;
    return input;
  }

  /// Where cells [from, to) of a species start, the first of which has this id.
  std::vector<Pose> startOf(std::size_t s, std::int64_t from, std::int64_t to, std::int64_t firstId) const {
    const Species& species = problem_.species[s];
    const std::int64_t atRandom = std::clamp(static_cast<std::int64_t>(species.start.size()), from, to);
    std::vector<Pose> poses(species.start.begin() + std::min(from, atRandom),
                            species.start.begin() + atRandom);
    if (species.inColumns) {
      const Columns columns(*species.shape, species.count, problem_.container->bounds(),
                            problem_.clearance + tolerance::relaxationMargin, problem_.seed);
      for (std::int64_t cell = from; cell < to; ++cell) poses.push_back(columns.pose(cell));
      return poses;
    }
    const PlacementInput random{species.shape.get(), problem_.wallOf(species), firstId + atRandom,
                                to - atRandom, &species.freedom};
    for (const Pose& pose :
         placeRandomly(random, problem_.container->bounds(), problem_.seed, problem_.rotate))
      poses.push_back(pose);
    return poses;
  }

  Relaxation placed() {
    Stopwatch watch(result_.statistics.placementSeconds);
    const RelaxationInput input = relaxationInput();
    const auto [first, end] = shares_.own();
    std::vector<Body> bodies;
    std::int64_t begin = 0;  // of the species
    for (std::size_t s = 0; s < problem_.species.size(); ++s) {
      const std::int64_t speciesBegin = begin;
      begin += problem_.species[s].count;
      const std::int64_t from = std::max(first, speciesBegin), to = std::min(end, begin);
      if (from >= to) continue;
      std::int64_t id = from;
      for (const Pose& pose : startOf(s, from - speciesBegin, to - speciesBegin, speciesBegin)) {
        Body body;
        body.id = id++;
        body.species = static_cast<int>(s);
        body.position = pose.position;
        body.orientation = pose.orientation;
        body.rotation = pose.orientation.toRotationMatrix();
        bodies.push_back(body);
      }
    }
    return Relaxation(input, std::move(bodies), problem_.communicator);
  }

  /// A packing that is given whole stays as it is when nothing is wrong with it.
  bool startsClean(Relaxation& relaxation) {
    const bool whole = std::all_of(problem_.species.begin(), problem_.species.end(), [](const Species& s) {
      return static_cast<std::int64_t>(s.start.size()) >= s.count;
    });
    if (!whole || relaxation.sweeps() > 0 || relaxation.cellCount() == 0) return false;
    const Stopwatch watch(result_.statistics.certificateSeconds);
    std::optional<Certifier> certifier;
    const Certificate found = examined(relaxation, certifier);
    certifier.reset();
    written_ = WrittenCells(problem_);
    if (!found.clean()) return false;
    result_.certificate = found;
    deliver(relaxation);
    return true;
  }

  Relaxation resumed(const PackingState& state) {
    at_ = state.position;
    result_.statistics.repairs = state.repairs;
    failures_ = state.failures;
    demandedOfWall_ = state.demandedOfWall;
    std::vector<Body> bodies;
    for (const BodyState& cell : state.cells) bodies.push_back(bodyOf(cell));
    return Relaxation(relaxationInput(), std::move(bodies), problem_.communicator, state.relaxation);
  }

  /// Keeps what is saved if the run should end before this is done again. Pre: the relaxation begins anew.
  void keepState(const Relaxation& relaxation) {
    if (!problem_.checkpoints) return;
    kept_ = PackingState();
    kept_.position = at_;
    kept_.repairs = result_.statistics.repairs;
    kept_.relaxation = relaxation.state();
    kept_.failures = failures_;
    kept_.demandedOfWall = demandedOfWall_;
    kept_.cellCount = relaxation.cellCount();
    kept_.cells = shares_.collect(relaxation.cells());
    const auto& due = problem_.checkpoints->due;
    if (due && problem_.communicator.any(due())) problem_.checkpoints->save(kept_);
  }

  /// Measures the cells of the state that is kept.
  void measure(Relaxation& relaxation) {
    relaxation.dropLists();
    written_.take(relaxation);
    const CertificateInput input = written_.certificateInput();
    const CellMeasures measured = measureCells(problem_, input);
    struct Measure {
      std::int64_t id;
      double gap, localHematocrit;
    };
    std::vector<Measure> own;
    for (std::size_t i = 0; i < input.own->size(); ++i)
      if ((*input.own)[i])
        own.push_back({written_.ids()[i], measured.gap[own.size()], measured.localHematocrit[own.size()]});
    kept_.measures = {};
    for (const Measure& m : shares_.collect(own)) {
      kept_.measures.gap.push_back(m.gap);
      kept_.measures.localHematocrit.push_back(m.localHematocrit);
    }
    written_ = WrittenCells(problem_);
  }

  /// Whether all contacts could be resolved within the limits.
  bool relaxed(Relaxation& relaxation) {
    if (at_.stage != Stage::relaxation) return true;  // has been
    Stopwatch watch(result_.statistics.relaxationSeconds);
    if (!relax(relaxation, tolerance::relaxationTolerance, limits(relaxation, problem_.limits.maxSweeps),
               at_.schedule))
      return false;
    at_.stage = Stage::certificate;
    return true;
  }

  /// Wall time since the start [s]; the same on all ranks.
  double elapsed() const { return problem_.communicator.max(secondsSince(start_)); }

  bool interruptedOnAnyRank() {
    interrupted_ =
        problem_.communicator.any(interrupted_ || (problem_.interrupted && problem_.interrupted()));
    return interrupted_;
  }

  /// Whether to stop, for whatever reason; the same on all ranks.
  bool stopped() {
    enum { no, timeUp, asked };
    const bool late = problem_.limits.maxSeconds > 0.0 && secondsSince(start_) > deadline_;
    const bool told = problem_.interrupted && problem_.interrupted();
    const double reason = problem_.communicator.max(told ? asked : late ? timeUp : no);
    interrupted_ = interrupted_ || reason == asked;
    return interrupted_ || reason == timeUp;
  }

  ScheduleLimits limits(const Relaxation& relaxation, std::int64_t maxSweeps) {
    ScheduleLimits limits;
    limits.maxSweeps = maxSweeps;
    limits.stop = [this] { return stopped(); };
    limits.anew = [this, &relaxation] { keepState(relaxation); };
    if (problem_.progress)
      limits.tell = [this, &relaxation](const char* stage) {
        problem_.progress({stage, relaxation.sweeps(), 1.0, relaxation.lastSweep().deepest,
                           relaxation.lastSweep().contacts});
      };
    return limits;
  }

  /// Certifies what the relaxation has; pairs and cells that fail get more clearance and are relaxed again.
  /// Post: when false, the position is at relaxation, or the run is interrupted.
  bool certified(Relaxation& relaxation) {
    std::optional<Certifier> certifier;
    written_ = WrittenCells(problem_);
    for (; at_.round < repairRounds; ++at_.round) {
      if (at_.stage == Stage::certificate) {
        relaxation.dropLists();
        keepState(relaxation);
        if (certifiedOnce(relaxation, certifier)) return true;
        if (interrupted_) return false;
        ++result_.statistics.repairs;
        at_.stage = Stage::repair;
        at_.schedule = {};
      }
      if (!settled(relaxation, repairSweeps)) break;
      at_.stage = Stage::certificate;
    }
    at_ = {Stage::relaxation, at_.thinning, 0, {}};
    return false;
  }

  /// The certificate of what the relaxation has now.
  Certificate examined(Relaxation& relaxation, std::optional<Certifier>& certifier) {
    const auto changed = certifier ? written_.update(relaxation) : std::nullopt;
    if (changed) {
      certifier->update(*changed);
    } else {
      written_.take(relaxation);
      certifier.emplace(written_.certificateInput());
    }
    return ofAllRanks(certifier->certificate(), written_.ids(), problem_.communicator);
  }

  /// @return whether all is well; otherwise clearances have been demanded
  bool certifiedOnce(Relaxation& relaxation, std::optional<Certifier>& certifier) {
    Stopwatch watch(result_.statistics.certificateSeconds);
    const Certificate found = examined(relaxation, certifier);
    if (found.clean()) {
      result_.certificate = found;
      certifier.reset();
      written_ = WrittenCells(problem_);
      deliver(relaxation);
      return true;
    }
    interrupted_ = interrupted_ || !found.complete;
    if (interrupted_) return false;
    if (at_.round == problem_.regrowAfter && !problem_.constrained() &&
        regrown(relaxation, certifier, found)) {
      deliver(relaxation);
      return true;
    }
    for (const OverlappingPair& pair : found.overlapping) {
      const std::int64_t again = std::max<std::int64_t>(0, ++failures_[{pair.first, pair.second}] - patience);
      relaxation.demandClearance(pair.first, pair.second,
                                 std::ldexp(tolerance::repairClearance, static_cast<int>(again)));
    }
    for (const MisplacedCell& cell : found.misplaced) demandDistance(relaxation, cell);
    return false;
  }

  /// Goes on with a schedule of settling.
  bool settled(Relaxation& relaxation, std::int64_t sweeps) {
    Stopwatch watch(result_.statistics.relaxationSeconds);
    const std::int64_t most = relaxation.sweeps() + sweeps - at_.schedule.sweep;
    return settle(relaxation, tolerance::relaxationTolerance, sweeps, limits(relaxation, most), at_.schedule);
  }

  /// Gives every rank its share of the cells, in the order of their ids.
  void deliver(const Relaxation& relaxation) {
    result_.cells.clear();
    result_.poses.clear();
    for (const BodyState& state : shares_.collect(relaxation.cells())) {
      const Pose pose = bodyOf(state).pose();
      result_.poses.push_back(pose);
      result_.cells.push_back({state.species, WrittenCells::placement(problem_, pose)});
    }
    result_.cellCount = relaxation.cellCount();
  }

  /// Shrinks the cells that meet and lets them grow again. @return whether that made the packing clean;
  /// otherwise nothing has changed
  bool regrown(Relaxation& relaxation, std::optional<Certifier>& certifier, const Certificate& faults) {
    const std::vector<MovedCell> moves = regrownCells(
        problem_, relaxation, faults, [this] { return stopped(); }, result_.statistics.regrowth);
    if (moves.empty()) return false;
    std::vector<MovedCell> back;
    for (const MovedCell& move : moves) back.push_back({move.id, move.before, move.after});
    setPoses(relaxation, moves);
    result_.certificate = examined(relaxation, certifier);
    if (result_.certificate.clean()) return true;
    setPoses(relaxation, back);
    examined(relaxation, certifier);
    return false;
  }

  static void setPoses(Relaxation& relaxation, const std::vector<MovedCell>& moves) {
    for (const MovedCell& move : moves) relaxation.setPose(move.id, move.after);
  }

  /// What a misplaced cell is given on top of what it was to keep: what the relaxation did not see, because
  /// it interpolates the distance to the wall.
  void demandDistance(Relaxation& relaxation, const MisplacedCell& cell) {
    constexpr double growth = 0.5;  // how deep it is in the wall is not known: ask for more each time
    double& demanded = demandedOfWall_[cell.cell];
    const double wanted = cell.gap > 0.0 ? problem_.wallClearance - cell.gap + tolerance::repairClearance
                                         : std::max(tolerance::repairClearance, growth * demanded);
    const double most = problem_.container->bounds().size().norm();
    const double extra = std::clamp(wanted, 0.0, std::max(0.0, most - demanded));
    demanded += extra;
    relaxation.demandWallClearance(cell.cell, extra);
  }

  /// Takes out the most overlapped cells, a few at a time, until the others are certified.
  void thinOut(Relaxation& relaxation) {
    const double maxSeconds = problem_.limits.maxSeconds, began = elapsed();
    while (!interrupted_ && relaxation.cellCount() > 0) {
      double share = thinning;
      if (maxSeconds > 0.0) {
        const double spent = thinningParts * (elapsed() - began) / maxSeconds;
        if (spent > mostThinningParts) return leaveOutFailing(relaxation);
        share *= std::exp2(std::floor(spent));
        deadline_ = elapsed() + maxSeconds / thinningParts;
      }
      if (at_.stage == Stage::relaxation) {
        const auto count = static_cast<std::size_t>(
            std::ceil(std::min(share, 1.0) * static_cast<double>(relaxation.cellCount())));
        relaxation.remove(mostOverlapped(relaxation, count));
        at_ = {Stage::thinning, true, 0, {}};
      }
      if (at_.stage == Stage::thinning)
        at_.stage = settled(relaxation, thinningSweeps) ? Stage::certificate : Stage::relaxation;
      if (at_.stage != Stage::relaxation && certified(relaxation)) return;
    }
    result_.certificate = Certificate();
  }

  /// Leaves out cells until no other one fails, moving none: of each failing pair the cell that fails in
  /// more of them.
  void leaveOutFailing(Relaxation& relaxation) {
    Stopwatch watch(result_.statistics.certificateSeconds);
    while (!interruptedOnAnyRank()) {
      relaxation.dropLists();
      written_.take(relaxation);
      result_.certificate =
          ofAllRanks(certify(written_.certificateInput()), written_.ids(), problem_.communicator);
      if (result_.certificate.clean()) return deliver(relaxation);
      std::map<std::int64_t, int> failures;
      std::set<std::int64_t> out;
      for (const MisplacedCell& cell : result_.certificate.misplaced) out.insert(cell.cell);
      for (const OverlappingPair& pair : result_.certificate.overlapping)
        ++failures[pair.first], ++failures[pair.second];
      for (const OverlappingPair& pair : result_.certificate.overlapping) {
        if (out.count(pair.first) || out.count(pair.second)) continue;
        const bool first =
            isFixed(pair.second) || (!isFixed(pair.first) && failures[pair.first] > failures[pair.second]);
        out.insert(first ? pair.first : pair.second);
      }
      relaxation.remove({out.begin(), out.end()});
    }
  }

  bool isFixed(std::int64_t id) const {
    for (const Species& species : problem_.species) {
      if (id < species.count) return species.freedom.fixed;
      id -= species.count;
    }
    return false;
  }

  /// The ids of the `count` cells with the deepest penetrations, sorted; the same on all ranks.
  std::vector<std::int64_t> mostOverlapped(const Relaxation& relaxation, std::size_t count) const {
    struct Overlap {
      double depth;  // [µm]
      std::int64_t id;
    };
    std::vector<Overlap> overlaps;
    for (const Body& body : relaxation.cells())
      if (!problem_.species[body.species].freedom.fixed) overlaps.push_back({body.overlap, body.id});
    const auto keepMost = [&] {
      std::sort(overlaps.begin(), overlaps.end(), [](const Overlap& a, const Overlap& b) {
        return a.depth != b.depth ? a.depth > b.depth : a.id < b.id;
      });
      overlaps.resize(std::min(count, overlaps.size()));
    };
    keepMost();
    overlaps = problem_.communicator.gatherAll(overlaps);
    keepMost();
    std::vector<std::int64_t> ids;
    for (const Overlap& overlap : overlaps) ids.push_back(overlap.id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }

  const PackingProblem& problem_;
  std::chrono::steady_clock::time_point start_;
  double deadline_;  ///< in elapsed() [s]; counts when there is a time limit
  IdShares shares_;
  RunPosition at_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> failures_;  ///< of pairs in the exact test
  std::map<std::int64_t, double> demandedOfWall_;  ///< by cells (ids) that were found misplaced [µm]
  WrittenCells written_;
  PackingState kept_;
  bool interrupted_ = false;
  PackingResult result_;
};

}  // namespace

PackingResult pack(const PackingProblem& problem) {
  validate(problem);
  requireFixedApart(problem);
  return problem.method == Method::cat ? packByGrowth(problem) : Run(problem)();
}

}  // namespace packmesh
