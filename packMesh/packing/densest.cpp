// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/densest.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "packMesh/packing/attempt.h"
#include "packMesh/packing/engine.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Volume fractions that are tried: multiples of this, independent of the request. No packing reaches the
/// largest.
constexpr double rung = 0.0025;
constexpr std::int64_t topRung = 320;

/// Resolution of the bisection, and step of the linear search [multiples of `rung`].
constexpr std::int64_t coarse = 10, climb = 2;

/// Parts of relax() in a trial: during the bisection, and at most if there is no time limit; few cells may
/// have more parts, up to this many sweeps of a cell.
constexpr std::int64_t fewestParts = 1, mostParts = 2;
constexpr std::int64_t sweepsOfFewCells = 3000000;

class Search {
 public:
  Search(const PackingProblem& problem, RunControl& control, const WholeAttempt& whole)
      : problem_(problem), control_(control), whole_(whole), lumen_(problem.physics.container->volume()) {
    const bool anyRed =
        std::any_of(problem.physics.species.begin(), problem.physics.species.end(),
                    [](const Species& s) { return s.inHematocrit && !s.freedom.fixed && s.count > 0; });
    for (const Species& species : problem.physics.species)
      if (species.inHematocrit || !anyRed)
        (species.freedom.fixed ? fixed_ : free_) +=
            asked(species) * meanVolume(species, problem.physics.shapes);
  }

  Densest operator()() {
    packed_ = static_cast<std::int64_t>(fixed_ / lumen_ / rung);
    beyond_ = topRung;
    bisect(coarse);
    if (goesOn() && !found_.packing) pack(countsAt(0));  // fixed cells alone
    for (++parts_; goesOn() && mayHave(parts_); ++parts_) climbOn();
    if (goesOn() && control_.limited()) found_.whole = whole_(problem_.execution.limits.maxSweeps);
    found_.ended = !control_.stopped();
    return std::move(found_);
  }

 private:
  using Counts = std::vector<std::int64_t>;

  static double asked(const Species& species) {
    return species.asked > 0.0 ? species.asked : static_cast<double>(species.count);
  }

  bool goesOn() { return !found_.whole && !control_.stopped(); }

  /// Number of cells of each species at a multiple of `rung`.
  Counts countsAt(std::int64_t rungs) const {
    const double volume = static_cast<double>(rungs) * rung * lumen_ - fixed_;
    const double share = free_ > 0.0 ? std::clamp(volume / free_, 0.0, 1.0) : 0.0;
    Counts counts;
    for (const Species& species : problem_.physics.species)
      counts.push_back(species.freedom.fixed
                           ? species.count
                           : std::min<std::int64_t>(species.count, std::llround(share * asked(species))));
    return counts;
  }
  std::int64_t cellsAt(std::int64_t rungs) const {
    std::int64_t cells = 0;
    for (const std::int64_t count : countsAt(rungs)) cells += count;
    return cells;
  }

  /// Whether trials may have this many parts.
  bool mayHave(std::int64_t parts) const {
    const std::int64_t sweeps = sweepsOfRelax(parts);
    return sweeps <= problem_.execution.limits.maxSweeps &&
           (control_.limited() || parts <= mostParts || sweeps * cellsAt(beyond_) <= sweepsOfFewCells);
  }

  /// Bisects between what could be packed and what could not.
  void bisect(std::int64_t rungs) {
    while (beyond_ - packed_ > rungs && cellsAt(beyond_) - cellsAt(packed_) > 1 && goesOn()) {
      const std::int64_t middle = packed_ + (beyond_ - packed_) / 2;
      (packs(middle) ? packed_ : beyond_) = middle;
    }
  }

  /// Increases the fraction as long as trials succeed, starting with the one that failed with fewer parts.
  void climbOn() {
    while (packs(beyond_) && goesOn()) {
      packed_ = beyond_;
      beyond_ += climb;
    }
    bisect(1);
  }

  /// Whether this fraction can be packed; if it comprises all requested cells, these are tried.
  bool packs(std::int64_t rungs) {
    const Counts counts = countsAt(rungs);
    if (cellsAt(rungs) >= problem_.physics.cellCount()) return found_.whole = whole_(sweepsOfRelax(parts_));
    if (counts == countsAt(packed_) && found_.packing) return true;
    return pack(counts);
  }

  /// Begins a trial, or continues the last one if that failed.
  bool pack(const Counts& counts) {
    if (!trial_ || trial_->counts != counts) trial_ = std::make_unique<Trial>(part(counts), counts, control_);
    const std::int64_t before = trial_->attempt.sweeps();
    sweepsOfOthers_ = found_.sweeps - before;
    const bool all = trial_->attempt.certifyAll(sweepsOfRelax(parts_));
    found_.sweeps += trial_->attempt.sweeps() - before;
    if (!all) return false;
    found_.packing = trial_->attempt.takeResult();
    trial_.reset();
    return true;
  }

  /// The problem with this many cells.
  PackingProblem part(const Counts& counts) {
    PackingProblem part = problem_;
    part.resume.reset();
    part.checkpoints.reset();
    if (part.engine) part.engine = part.engine->forTrials();
    part.execution.observe = {};
    part.execution.limits.maxSweeps = std::max(part.execution.limits.maxSweeps, sweepsOfRelax(fewestParts));
    if (problem_.execution.progress)
      part.execution.progress = [this](Progress progress) {
        if (!problem_.engine) progress.stage = "search for the densest packing";
        progress.sweep += sweepsOfOthers_;
        problem_.execution.progress(progress);
      };
    for (std::size_t s = 0; s < counts.size(); ++s) part.physics.species[s].resize(counts[s]);
    return part;
  }

  struct Trial {
    Trial(PackingProblem part, Counts of, RunControl& control)
        : problem(std::move(part)), counts(std::move(of)), attempt(problem, control) {}
    PackingProblem problem;
    Counts counts;
    Attempt attempt;  ///< refers to `problem`
  };

  const PackingProblem& problem_;
  RunControl& control_;
  const WholeAttempt& whole_;
  const double lumen_;               ///< [µm³]
  double fixed_ = 0.0, free_ = 0.0;  ///< volume of such cells that is part of the hematocrit [µm³]
  std::unique_ptr<Trial> trial_;     ///< the last one, if it failed
  std::int64_t sweepsOfOthers_ = 0;  ///< of all other trials
  std::int64_t parts_ = fewestParts;
  /// The densest packing so far, and the next fraction that was tried without success [multiples of `rung`].
  std::int64_t packed_ = 0, beyond_ = topRung;
  Densest found_;
};

}  // namespace

Densest findDensest(const PackingProblem& problem, RunControl& control, const WholeAttempt& whole) {
  return Search(problem, control, whole)();
}

}  // namespace packmesh
