// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "packMesh/error.h"
#include "packMesh/packing/validate_problem.h"
#include "packMesh/stages/certificate/certifier.h"
#include "packMesh/stages/placement/placement.h"
#include "packMesh/stages/relaxation/relaxation.h"
#include "packMesh/stages/relaxation/schedule.h"
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

double cpuSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Adds the CPU time of a scope to a total.
class Stopwatch {
 public:
  explicit Stopwatch(double& total) : total_(total), start_(cpuSeconds()) {}
  ~Stopwatch() { total_ += cpuSeconds() - start_; }

 private:
  double& total_;
  double start_;
};

/// One run of pack().
class Run {
 public:
  explicit Run(const PackingProblem& problem)
      : problem_(problem), start_(std::chrono::steady_clock::now()), deadline_(problem.limits.maxSeconds) {
    for (const Species& species : problem.species) {
      shapes_.push_back(species.shape.get());
      walls_.push_back(species.wall ? species.wall.get() : problem.container->wall());
    }
  }

  PackingResult operator()() {
    Relaxation relaxation = place();
    bool resolved = false;
    while (!resolved && relaxed(relaxation)) resolved = certified(relaxation);
    if (!resolved && !interrupted_) thinOut(relaxation);
    result_.outcome = interrupted_ ? Outcome::interrupted
                      : resolved   ? Outcome::certified
                                   : Outcome::outOfReach;
    if (interrupted_) result_.cells.clear(), result_.poses.clear();
    result_.statistics.sweeps = relaxation.sweeps();
    return std::move(result_);
  }

 private:
  Relaxation place() {
    Stopwatch watch(result_.statistics.placementSeconds);
    RelaxationInput input;
    input.shapes = shapes_;
    input.walls = walls_;
    input.bounds = problem_.container->bounds();
    input.period = problem_.container->period();
    input.clearance = problem_.clearance + tolerance::relaxationMargin;
    input.wallClearance = problem_.wallClearance + tolerance::relaxationMargin;
    input.rotate = problem_.rotate;
    input.seed = problem_.seed;
    std::vector<Body> bodies;
    for (std::size_t s = 0; s < shapes_.size(); ++s) {
      const PlacementInput placement{shapes_[s], walls_[s], static_cast<std::int64_t>(bodies.size()),
                                     problem_.species[s].count};
      for (const Pose& pose : placeRandomly(placement, input.bounds, input.seed, input.rotate)) {
        Body body;
        body.id = static_cast<std::int64_t>(bodies.size());
        body.species = static_cast<int>(s);
        body.position = pose.position;
        body.orientation = pose.orientation;
        body.rotation = pose.orientation.toRotationMatrix();
        bodies.push_back(body);
      }
    }
    return Relaxation(input, std::move(bodies));
  }

  /// Whether all contacts could be resolved within the limits.
  bool relaxed(Relaxation& relaxation) {
    Stopwatch watch(result_.statistics.relaxationSeconds);
    return relax(relaxation, tolerance::relaxationTolerance, limits(relaxation, problem_.limits.maxSweeps));
  }

  /// Wall time since the start [s].
  double elapsed() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

  bool timeIsUp() const { return problem_.limits.maxSeconds > 0.0 && elapsed() > deadline_; }

  bool askedToStop() {
    interrupted_ = interrupted_ || (problem_.interrupted && problem_.interrupted());
    return interrupted_;
  }

  ScheduleLimits limits(const Relaxation& relaxation, std::int64_t maxSweeps) {
    ScheduleLimits limits;
    limits.maxSweeps = maxSweeps;
    limits.stop = [this] { return askedToStop() || timeIsUp(); };
    if (problem_.progress)
      limits.tell = [this, &relaxation](const char* stage) {
        problem_.progress({stage, relaxation.sweeps(), 1.0, relaxation.lastSweep().deepest,
                           relaxation.lastSweep().contacts});
      };
    return limits;
  }

  CertificateInput certificateInput() const {
    CertificateInput input;
    input.shapes = shapes_;
    input.walls = walls_;
    input.container = problem_.container.get();
    input.cells = &result_.cells;
    input.requiredGap = problem_.clearance;
    input.requiredWallGap = problem_.wallClearance;
    return input;
  }

  /// Takes the cells over from the relaxation, as they will be written. Returns which of them changed.
  std::vector<std::int64_t> takeCells(const std::vector<Body>& bodies) {
    std::vector<std::int64_t> changed;
    const bool same = result_.cells.size() == bodies.size();
    result_.cells.resize(bodies.size());
    result_.poses.resize(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Pose pose = bodies[i].pose();
      PlacedCell cell{bodies[i].species, problem_.written ? problem_.written(pose) : pose.placement()};
      PlacedCell& old = result_.cells[i];
      if (!same || old.placement.linear != cell.placement.linear ||
          old.placement.translation != cell.placement.translation)
        changed.push_back(static_cast<std::int64_t>(i));
      old = cell;
      result_.poses[i] = pose;
    }
    return changed;
  }

  /// Certifies what the relaxation has; pairs and cells that fail get more clearance and are relaxed again.
  bool certified(Relaxation& relaxation) {
    std::optional<Certifier> certifier;
    for (int round = 0; round < repairRounds; ++round) {
      relaxation.dropLists();
      const std::vector<Body> bodies = relaxation.cells();
      {
        Stopwatch watch(result_.statistics.certificateSeconds);
        const std::vector<std::int64_t> changed = takeCells(bodies);
        if (certifier)
          certifier->update(changed);
        else
          certifier.emplace(certificateInput());
        const Certificate& found = certifier->certificate();
        if (found.clean()) {
          result_.certificate = found;
          return true;
        }
        for (const OverlappingPair& pair : found.overlapping) {
          const std::int64_t first = bodies[pair.first].id, second = bodies[pair.second].id;
          const int again = std::max(0, ++failures_[{first, second}] - patience);
          relaxation.demandClearance(first, second, std::ldexp(tolerance::repairClearance, again));
        }
        for (const MisplacedCell& cell : found.misplaced)
          relaxation.demandWallClearance(bodies[cell.cell].id, missingWallClearance(cell, bodies[cell.cell]));
      }
      ++result_.statistics.repairs;
      Stopwatch watch(result_.statistics.relaxationSeconds);
      const std::int64_t most = relaxation.sweeps() + repairSweeps;
      if (!settle(relaxation, tolerance::relaxationTolerance, repairSweeps, limits(relaxation, most)))
        return false;
    }
    return false;
  }

  /// What a misplaced cell is given on top of what it was to keep [µm]: what the relaxation did not see,
  /// because it interpolates the distance to the wall.
  double missingWallClearance(const MisplacedCell& cell, const Body& body) const {
    if (cell.gap > 0.0) return problem_.wallClearance - cell.gap + tolerance::repairClearance;
    constexpr double growth = 0.5;  // how deep it is in the wall is not known: ask for more each time
    return std::max(tolerance::repairClearance, growth * body.extraWallClearance);
  }

  /// Takes out the most overlapped cells, a few at a time, until the others are certified.
  void thinOut(Relaxation& relaxation) {
    const double maxSeconds = problem_.limits.maxSeconds, began = elapsed();
    while (!interrupted_ && !relaxation.bodies().empty()) {
      double share = thinning;
      if (maxSeconds > 0.0) {
        const double spent = thinningParts * (elapsed() - began) / maxSeconds;
        if (spent > mostThinningParts) return leaveOutFailing(relaxation);
        share *= std::exp2(std::floor(spent));
        deadline_ = elapsed() + maxSeconds / thinningParts;
      }
      std::vector<Body> bodies = relaxation.bodies();
      std::sort(bodies.begin(), bodies.end(), [](const Body& a, const Body& b) {
        return a.overlap != b.overlap ? a.overlap > b.overlap : a.id < b.id;
      });
      const auto count =
          static_cast<std::size_t>(std::ceil(std::min(share, 1.0) * static_cast<double>(bodies.size())));
      std::vector<std::int64_t> ids;
      for (std::size_t i = 0; i < count; ++i) ids.push_back(bodies[i].id);
      std::sort(ids.begin(), ids.end());
      relaxation.remove(ids);
      bool resolved = false;
      {
        Stopwatch watch(result_.statistics.relaxationSeconds);
        const std::int64_t most = relaxation.sweeps() + thinningSweeps;
        resolved =
            settle(relaxation, tolerance::relaxationTolerance, thinningSweeps, limits(relaxation, most));
      }
      if (resolved && certified(relaxation)) return;
    }
    result_.cells.clear();
    result_.poses.clear();
    result_.certificate = Certificate();
  }

  /// Leaves out cells until no other one fails, moving none: of each failing pair the cell that fails in
  /// more of them.
  void leaveOutFailing(Relaxation& relaxation) {
    Stopwatch watch(result_.statistics.certificateSeconds);
    while (!askedToStop()) {
      const std::vector<Body> bodies = relaxation.cells();
      takeCells(bodies);
      result_.certificate = certify(certificateInput());
      if (result_.certificate.clean()) return;
      std::vector<int> failures(bodies.size(), 0);
      std::vector<bool> out(bodies.size(), false);
      for (const MisplacedCell& cell : result_.certificate.misplaced) out[cell.cell] = true;
      for (const OverlappingPair& pair : result_.certificate.overlapping)
        ++failures[pair.first], ++failures[pair.second];
      for (const OverlappingPair& pair : result_.certificate.overlapping) {
        if (out[pair.first] || out[pair.second]) continue;
        out[failures[pair.first] > failures[pair.second] ? pair.first : pair.second] = true;
      }
      std::vector<std::int64_t> ids;
      for (std::size_t i = 0; i < bodies.size(); ++i)
        if (out[i]) ids.push_back(bodies[i].id);
      std::sort(ids.begin(), ids.end());
      relaxation.remove(ids);
    }
  }

  const PackingProblem& problem_;
  std::chrono::steady_clock::time_point start_;
  double deadline_;  ///< in elapsed() [s]; counts when there is a time limit
  std::vector<const Shape*> shapes_;
  std::vector<const Wall*> walls_;
  std::map<std::pair<std::int64_t, std::int64_t>, int> failures_;  ///< of pairs (ids) in the exact test
  bool interrupted_ = false;
  PackingResult result_;
};

}  // namespace

PackingResult pack(const PackingProblem& problem) {
  validate(problem);
  return Run(problem)();
}

}  // namespace packmesh
