// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/relaxation/schedule.h"

#include <cmath>

namespace packmesh {
namespace {

/// Above about 1.05 penetrations grow at high fractions; 0.8 needs twenty times the sweeps of 1.0 at 0.58.
constexpr double hotOmega = 1.0;
/// Below, cells are only pushed apart and hardly rearrange any more.
constexpr double coldOmega = 0.8;
/// The end of repairs, where nothing is to rearrange.
constexpr double repairOmega = 0.55;

/// What is left of a tolerance when cells are settled: the rest of it is not touched.
constexpr double settledFraction = 0.2;

constexpr std::int64_t hotSweeps = 300;
/// At 0.60 the first annealing or the second one resolves everything.
constexpr std::int64_t firstAnnealing = 1200;
constexpr double annealingGrowth = 2.5;

/// With fewer contacts per cell than this (a jam has 7), those left after the first sweeps are pairs that
/// swing between two states for ever: thin parts that pierced each other.
constexpr double fewContacts = 0.5;

bool onlyFewContacts(const Relaxation& relaxation) {
  return static_cast<double>(relaxation.lastSweep().contacts) <
         fewContacts * static_cast<double>(relaxation.cellCount());
}

bool spent(const Relaxation& relaxation, const ScheduleLimits& limits) {
  return relaxation.sweeps() >= limits.maxSweeps || (limits.stop && limits.stop());
}

/// Sweeps with omega going evenly from `from` to `to`.
bool sweepFrom(double from, double to, std::int64_t sweeps, Relaxation& relaxation, double tolerance,
               const ScheduleLimits& limits, std::int64_t& at, const char* stage, double slack = 0.0) {
  for (; at < sweeps && !spent(relaxation, limits); ++at) {
    if (limits.anew && relaxation.beginsAnew()) limits.anew();
    const double progress = static_cast<double>(at) / static_cast<double>(sweeps);
    const SweepSums sums = relaxation.sweep(from + (to - from) * progress, slack);
    if (limits.tell) limits.tell(stage);
    if (sums.thorough && sums.deepest <= tolerance) return true;
  }
  return false;
}

}  // namespace

bool relax(Relaxation& relaxation, double tolerance, const ScheduleLimits& limits, SchedulePosition& at) {
  for (; !spent(relaxation, limits); at = {at.part + 1, 0}) {
    if (at.part == 0) {
      if (sweepFrom(hotOmega, hotOmega, hotSweeps, relaxation, tolerance, limits, at.sweep, "relaxation"))
        return true;
      continue;
    }
    if (at.sweep == 0 && onlyFewContacts(relaxation)) return true;
    const double sweeps = firstAnnealing * std::pow(annealingGrowth, static_cast<double>(at.part - 1));
    if (sweepFrom(hotOmega, coldOmega, static_cast<std::int64_t>(sweeps), relaxation, tolerance, limits,
                  at.sweep, "annealing"))
      return true;
  }
  return false;
}

bool settle(Relaxation& relaxation, double tolerance, std::int64_t sweeps, const ScheduleLimits& limits,
            SchedulePosition& at) {
  return sweepFrom(hotOmega, repairOmega, sweeps, relaxation, settledFraction * tolerance, limits, at.sweep,
                   "repair", (1.0 - settledFraction) * tolerance);
}

}  // namespace packmesh
