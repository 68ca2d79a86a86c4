// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/densest.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
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

/// Where cells are relocated: sweeps of a trial in addition to those of its parts, the share of the cells
/// that are added at once to a packing at first, and how often a single one is tried: with other places each
/// time, more often where cells are so few that this is quick, if enough of them may give way.
constexpr std::int64_t relocationSweeps = 1500, firstShare = 8, fewestFailures = 2, mostFailures = 10;

class Search {
 public:
  Search(const PackingProblem& problem, RunControl& control, const WholeAttempt& whole)
      : problem_(problem), control_(control), whole_(whole), lumen_(problem.physics.container->volume()) {
    for (int s = 0; s < int(problem.physics.species.size()); ++s)
      relocates_ = relocates_ || problem.physics.species[s].freedom.fixed || control.spaces().of(s);
    exceeds_ = relocates_ && !problem.engine &&
               std::none_of(problem.physics.species.begin(), problem.physics.species.end(),
                            [](const Species& s) { return s.freedom.fixed || !s.deformed.empty(); });
    const bool anyRed =
        std::any_of(problem.physics.species.begin(), problem.physics.species.end(),
                    [](const Species& s) { return s.inHematocrit && !s.freedom.fixed && s.count > 0; });
    for (const Species& species : problem.physics.species)
      if (species.inHematocrit || !anyRed)
        (species.freedom.fixed ? fixed_ : free_) +=
            requestedCount(species) * meanVolume(species, problem.physics.shapes);
  }

  Densest operator()() {
    packed_ = static_cast<std::int64_t>(fixed_ / lumen_ / rung);
    beyond_ = topRung;
    bisect(coarse);
    if (goesOn() && !found_.packing) pack(countsAt(0));  // fixed cells alone
    if (relocates_ && !problem_.engine)
      fillUp();
    else
      for (++parts_; goesOn() && mayHave(parts_); ++parts_) climbOn();
    if (goesOn() && control_.limited()) found_.whole = whole_(problem_.execution.limits.maxSweeps);
    found_.ended = !control_.stopped();
    return std::move(found_);
  }

 private:
  using Counts = std::vector<std::int64_t>;

  static double requestedCount(const Species& species) {
    return species.asked > 0.0 ? species.asked : static_cast<double>(species.count);
  }

  bool goesOn() { return !found_.whole && !hasAll_ && !control_.stopped(); }

  /// Number of cells of each species at a multiple of `rung`, also more than requested if exceeds_.
  Counts countsAt(std::int64_t rungs) const {
    const double volume = static_cast<double>(rungs) * rung * lumen_ - fixed_;
    const double share = free_ > 0.0 ? std::max(0.0, volume / free_) : 0.0;
    Counts counts;
    for (const Species& species : problem_.physics.species) {
      const std::int64_t count =
          std::llround((exceeds_ ? share : std::min(share, 1.0)) * requestedCount(species));
      counts.push_back(species.freedom.fixed ? species.count
                       : exceeds_            ? count
                                             : std::min<std::int64_t>(species.count, count));
    }
    return counts;
  }
  std::int64_t cellsAt(std::int64_t rungs) const {
    std::int64_t cells = 0;
    for (const std::int64_t count : countsAt(rungs)) cells += count;
    return cells;
  }
  std::int64_t movableCellsAt(std::int64_t rungs) const {
    std::int64_t cells = cellsAt(rungs);
    for (const Species& species : problem_.physics.species)
      if (species.freedom.fixed) cells -= species.count;
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

  /// Adds cells to the densest packing so far, fewer at once after each failure, until single ones find no
  /// place.
  void fillUp() {
    std::int64_t step = std::max<std::int64_t>(1, packed_ / firstShare);
    for (std::int64_t failures = 0; failures < failuresPermitted() && goesOn();) {
      std::int64_t next = packed_ + step;
      while (next < topRung && cellsAt(next) == cellsAt(packed_)) ++next;
      if (cellsAt(next) == cellsAt(packed_)) return;
      ++filling_;
      const bool all = cellsAt(next) >= problem_.physics.cellCount();
      if (!(all && problem_.execution.limits.maxSweeps < sweepsOfTrial()) && pack(countsAt(next))) {
        packed_ = next;
        failures = 0;
      } else if (step > 1 && cellsAt(next) - cellsAt(packed_) > 1) {
        step /= 2;
      } else {
        ++failures;
      }
    }
  }

  /// Whether this fraction can be packed; if it comprises all requested cells, these are tried first.
  bool packs(std::int64_t rungs) {
    const Counts counts = countsAt(rungs);
    if (cellsAt(rungs) >= problem_.physics.cellCount()) {
      found_.whole = whole_(sweepsOfRelax(parts_));
      if (found_.whole || !exceeds_ || problem_.execution.limits.maxSweeps < sweepsOfTrial())
        return found_.whole;
    }
    if (counts == countsAt(packed_) && found_.packing) return true;
    return pack(counts);
  }

  /// Begins a trial, or continues the last one if that failed.
  bool pack(const Counts& counts) {
    if (!trial_ || trial_->counts != counts || filling_ > 0)
      trial_ = std::make_unique<Trial>(part(counts), counts, control_);
    const std::int64_t before = trial_->attempt.sweeps();
    sweepsOfOthers_ = found_.sweeps - before;
    const bool all = trial_->attempt.certifyAll(sweepsOfTrial());
    found_.sweeps += trial_->attempt.sweeps() - before;
    if (!all) return false;
    std::optional<PackingResult> last = std::move(found_.packing);
    found_.packing = trial_->attempt.takeResult();
    trial_.reset();
    return keepRequested(counts, std::move(last));
  }

  /// If the packing that was found has more cells than requested, only the first ones: they have nothing to
  /// do but to be certified.
  /// @param last the packing before @return false: they were not, and that one is kept
  bool keepRequested(const Counts& counts, std::optional<PackingResult> last) {
    Counts requested;
    for (const Species& species : problem_.physics.species) requested.push_back(species.count);
    if (!std::equal(counts.begin(), counts.end(), requested.begin(), std::greater_equal<>())) return true;
    hasAll_ = counts == requested;
    if (hasAll_) return true;
    ++filling_;
    Trial few(part(requested), requested, control_);
    hasAll_ = few.attempt.certifyAll(sweepsOfTrial());
    found_.sweeps += few.attempt.sweeps();
    found_.packing = hasAll_ ? few.attempt.takeResult() : std::move(last);
    return hasAll_;
  }

  /// The problem with this many cells.
  PackingProblem part(const Counts& counts) {
    PackingProblem part = problem_;
    part.resume.reset();
    part.checkpoints.reset();
    if (part.engine) part.engine = part.engine->forTrials();
    part.execution.observe = {};
    part.execution.limits.maxSweeps = std::max(part.execution.limits.maxSweeps, sweepsOfRelax(fewestParts));
    if (filling_ > 0) part.physics.seed += std::uint64_t(filling_);  // other places each time
    if (problem_.execution.progress)
      part.execution.progress = [this](Progress progress) {
        if (!problem_.engine) progress.stage = "search for the densest packing";
        progress.sweep += sweepsOfOthers_;
        problem_.execution.progress(progress);
      };
    for (std::size_t s = 0; s < counts.size(); ++s) {
      Species& species = part.physics.species[s];
      if (filling_ > 0 && !species.freedom.fixed) startAsPacked(int(s), species);
      species.resize(counts[s]);
    }
    return part;
  }

  /// Begins with the cells of a species in the densest packing so far.
  void startAsPacked(int s, Species& species) const {
    if (!found_.packing) return;
    std::vector<double> numbers;
    for (std::size_t i = 0; i < found_.packing->cells.size(); ++i) {
      if (found_.packing->cells[i].species != s) continue;
      const Pose& pose = found_.packing->poses[i];
      numbers.insert(numbers.end(), pose.position.data(), pose.position.data() + 3);
      numbers.insert(numbers.end(), pose.orientation.coeffs().data(), pose.orientation.coeffs().data() + 4);
    }
    numbers = problem_.execution.communicator.gatherAll(numbers);
    species.start.clear();
    species.inColumns = false;
    for (std::size_t i = 0; 7 * i < numbers.size(); ++i) {
      const double* const at = numbers.data() + 7 * i;
      const Pose pose{1.0, Quaternion(at[6], at[3], at[4], at[5]), Vec3(at[0], at[1], at[2])};
      if (i < species.deformed.size())
        species.deformed[i].start = pose;
      else
        species.start.push_back(pose);
    }
  }

  std::int64_t failuresPermitted() const {
    const std::int64_t cells = std::max<std::int64_t>(1, cellsAt(packed_));
    const std::int64_t most = std::clamp(movableCellsAt(packed_), fewestFailures, mostFailures);
    return std::clamp(sweepsOfFewCells / (sweepsOfTrial() * cells), fewestFailures, most);
  }

  std::int64_t sweepsOfTrial() const { return sweepsOfRelax(parts_) + (relocates_ ? relocationSweeps : 0); }

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
  bool relocates_ = false;  ///< cells that are stuck are put elsewhere
  /// Trials can have more cells than requested, so that they are those of any request.
  bool exceeds_ = false;
  bool hasAll_ = false;       ///< found_.packing has all requested cells
  std::int64_t filling_ = 0;  ///< number of the trial that adds cells to a packing; 0: none does
  Densest found_;
};

}  // namespace

Densest findDensest(const PackingProblem& problem, RunControl& control, const WholeAttempt& whole) {
  return Search(problem, control, whole)();
}

}  // namespace packmesh
