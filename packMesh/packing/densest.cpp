// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/densest.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "packMesh/packing/attempt.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Bisection begins between nothing and this volume fraction, which no cells reach.
constexpr double mostFraction = 0.8;

/// Steps of the climb, and how finely it is known in the end what can be packed [fraction of the cells].
constexpr double climb = 0.02, resolution = 0.005;

/// Parts of relax() in a trial: of the bisection, and at most where no time limit ends the search.
constexpr std::int64_t fewestParts = 1, mostParts = 2;

class Search {
 public:
  Search(const PackingProblem& problem, RunControl& control)
      : problem_(problem), control_(control), lumen_(problem.container->volume()), part_(problem) {
    part_.resume.reset();
    part_.checkpoints.reset();
    if (problem.progress)
      part_.progress = [this](Progress progress) {
        progress.stage = "search for the densest packing";
        progress.sweep += found_.sweeps;
        problem_.progress(progress);
      };
    for (const Species& species : problem.species)
      (species.freedom.fixed ? fixed_ : free_) +=
          static_cast<double>(species.count) * species.shape->volume();
  }

  Densest operator()() {
    packed_ = fixed_ / lumen_;
    bisect(mostFraction);
    if (!found_.packing && !control_.stopped()) pack(countsAt(packed_));  // fixed cells alone
    for (++parts_; !control_.stopped() && mayHave(parts_); ++parts_) climbOn();
    found_.ended = !control_.stopped();
    return std::move(found_);
  }

 private:
  using Counts = std::vector<std::int64_t>;

  /// Cells of each species when all together fill a fraction of the lumen.
  Counts countsAt(double fraction) const {
    const double share = free_ > 0.0 ? std::clamp((fraction * lumen_ - fixed_) / free_, 0.0, 1.0) : 0.0;
    Counts counts;
    for (const Species& species : problem_.species)
      counts.push_back(species.freedom.fixed ? species.count
                                             : std::llround(share * static_cast<double>(species.count)));
    return counts;
  }
  std::int64_t cellsAt(double fraction) const {
    std::int64_t cells = 0;
    for (const std::int64_t count : countsAt(fraction)) cells += count;
    return cells;
  }

  /// Whether trials may have so many parts.
  bool mayHave(std::int64_t parts) const {
    return sweepsOfRelax(parts) <= problem_.limits.maxSweeps && (control_.limited() || parts <= mostParts);
  }

  /// Narrows down what can be packed between what is and `beyond`, which cannot.
  void bisect(double beyond) {
    while (!control_.stopped()) {
      const std::int64_t cells = cellsAt(packed_), more = cellsAt(beyond);
      if (static_cast<double>(more - cells) <= std::max(1.0, resolution * static_cast<double>(cells))) return;
      const double middle = 0.5 * (packed_ + beyond);
      (packs(middle) ? packed_ : beyond) = middle;
    }
  }

  /// Goes up as long as trials succeed.
  void climbOn() {
    for (double above = packed_; !control_.stopped();) {
      above = packed_ * (1.0 + climb);
      if (!packs(above)) return bisect(above);
      packed_ = above;
    }
  }

  /// Whether that fraction can be packed. All that were asked for have been tried already.
  bool packs(double fraction) {
    const Counts counts = countsAt(fraction);
    if (cellsAt(fraction) >= problem_.cellCount()) return false;
    if (counts == countsAt(packed_) && found_.packing) return true;
    return pack(counts);
  }

  bool pack(const Counts& counts) {
    part_.limits.maxSweeps = sweepsOfRelax(parts_);
    for (std::size_t s = 0; s < counts.size(); ++s) {
      const std::vector<Pose>& start = problem_.species[s].start;
      const auto started = std::min(static_cast<std::int64_t>(start.size()), counts[s]);
      part_.species[s].count = counts[s];
      part_.species[s].start.assign(start.begin(), start.begin() + started);
    }
    Attempt trial(part_, control_);
    const bool all = trial.certifyAll();
    PackingResult result = trial.takeResult();
    found_.sweeps += result.statistics.sweeps;
    if (all) found_.packing = std::move(result);
    return all;
  }

  const PackingProblem& problem_;
  RunControl& control_;
  const double lumen_;               ///< [µm³]
  double fixed_ = 0.0, free_ = 0.0;  ///< volume of such cells [µm³]
  PackingProblem part_;              ///< of a trial
  std::int64_t parts_ = fewestParts;
  double packed_ = 0.0;  ///< the densest that could be packed so far [fraction]
  Densest found_;
};

}  // namespace

Densest findDensest(const PackingProblem& problem, RunControl& control) {
  return Search(problem, control)();
}

}  // namespace packmesh
