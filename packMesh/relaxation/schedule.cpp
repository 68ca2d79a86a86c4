// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/schedule.h"

#include <algorithm>
#include <cmath>

#include "packMesh/core/tolerances.h"

namespace packmesh {
namespace {

/// Above about 1.05 penetrations increase at high volume fractions.
constexpr double hotOmega = 1.0;
/// Over-relaxation factor at the end of an annealing.
constexpr double coolOmega = 0.96;
/// Over-relaxation factor at the end of repairs, where nothing has to rearrange, and at the beginning of
/// those of dense packings, which more would agitate.
constexpr double repairOmega = 0.55, calibrationOmega = 0.95;

/// Fraction of the tolerance used while cells are settled: contacts within the rest of it are not resolved.
constexpr double settledFraction = 0.2;

constexpr std::int64_t hotSweeps = 300;
/// By then everything is resolved up to a fraction of 0.55; earlier, cells placed at random are still far
/// from equilibrium.
constexpr std::int64_t untemperedSweeps = 60;
/// At 0.60 everything is resolved early in the first annealing, at 0.61 in the second.
constexpr double firstAnnealing = 2000.0;
constexpr double annealingGrowth = 2.5;
constexpr std::int64_t annealings = 2;

/// Compactions: sweeps at a constant limit of the mean penetration [of half the thickness of a cell], each
/// time more by a factor, then a reduction of omega. At 0.62, cells rearrange most with a limit of 0.16 to
/// 0.18; with 0.23 they are agitated too much to find denser arrangements, with 0.12 too little to leave
/// those they have.
constexpr double firstCompaction = 5000.0, compactionGrowth = 1.3, compactingDepth = 0.18;
constexpr std::int64_t coolingSweeps = 1500;
constexpr double cooledOmega = 0.88;
/// Sum of the penetrations of a cell after a compaction below which calibration is tried [of half the
/// thickness].
constexpr double shallow = 0.05;
/// More than any run has time for.
constexpr double longestPart = 1e12;

/// Limits of the mean penetration above which omega is reduced, as fractions of half the thickness of a cell:
/// the initial one and that at the end of an annealing. Half the value needs twice the sweeps at 0.60; with
/// slightly larger values, cells may remain locked permanently from 0.61 on.
constexpr double hotDepth = 0.23, coolDepth = 0.13;
/// Reduction of omega per excess of the mean penetration over its limit.
constexpr double tempering = 2.3;
constexpr double leastOmega = 0.6;

/// With fewer contacts per cell that can move than this (a jammed packing has 7), those left after the first
/// sweeps are pairs that oscillate between two states indefinitely: thin parts that have pierced each other.
constexpr double fewContacts = 0.5;

/// With fewer contacts per cell than this, most cells are at rest and a sweep takes little time. In a large
/// packing a few such pairs are left when a small one is complete.
constexpr double veryFewContacts = 0.05;

/// Mean penetrations [of half the thickness of a cell] at the end of the first part, of the first annealing
/// and of later ones, above which more sweeps do not help: red cells that could be separated eventually had
/// at most 0.24, 0.16 and 0.12, in boxes, tubes and spheres of any size. In a jammed packing cells have at
/// least so many contacts each.
constexpr double jammedDepths[] = {0.3, 0.18, 0.15};
constexpr double jammedContacts = 2.0;

/// Whether the cells are jammed, as determined at the end of a part of relax().
bool jammed(const Relaxation& relaxation, std::int64_t part) {
  const SweepSums& last = relaxation.lastSweep();
  return static_cast<double>(last.contacts) >
             jammedContacts * static_cast<double>(relaxation.movableCount()) &&
         last.meanDepth() > jammedDepths[std::min<std::int64_t>(part, 2)] * relaxation.halfThickness();
}

bool onlyFewContacts(const Relaxation& relaxation) {
  return static_cast<double>(relaxation.lastSweep().contacts) <
         fewContacts * static_cast<double>(relaxation.movableCount());
}

bool spent(const Relaxation& relaxation, const ScheduleLimits& limits) {
  const bool few = static_cast<double>(relaxation.lastSweep().contacts) <
                   veryFewContacts * static_cast<double>(relaxation.movableCount());
  const std::int64_t sweeps = relaxation.sweeps();
  // Contacts increase again when a pair comes apart: whether they are few counts only when the limit is
  // reached.
  const bool enough =
      sweeps >= limits.maxSweeps + limits.sweepsForFew || (sweeps == limits.maxSweeps && !few);
  return enough || (limits.stop && limits.stop());
}

/// A value that changes linearly from the first sweep to the last.
double between(double from, double to, std::int64_t sweep, std::int64_t sweeps) {
  return from + (to - from) * (static_cast<double>(sweep) / static_cast<double>(sweeps));
}

/// Reduces omega in proportion to the excess of the mean penetration over its limit [of half a cell's
/// thickness].
double tempered(double omega, double depth, const Relaxation& relaxation) {
  const double excess = relaxation.lastSweep().meanDepth() / relaxation.halfThickness() - depth;
  return std::max(leastOmega, omega - tempering * std::max(0.0, excess));
}

/// Sweeps with the value of `omega` at each of them.
/// @return whether no penetration is deeper than `deepest` [µm]
bool sweepWith(const std::function<double(std::int64_t sweep)>& omega, std::int64_t sweeps,
               Relaxation& relaxation, double deepest, const ScheduleLimits& limits, std::int64_t& at,
               const char* stage, double slack = 0.0) {
  for (; at < sweeps && !spent(relaxation, limits); ++at) {
    if (limits.beforeRebuild && relaxation.rebuildsNext()) {
      relaxation.forgetLists();
      limits.beforeRebuild();
    }
    const SweepSums sums = relaxation.sweep(omega(at), slack);
    if (limits.tell) limits.tell(stage);
    if (sums.thorough && sums.deepest <= deepest) return true;
  }
  return false;
}

std::int64_t geometric(double first, double ratio, std::int64_t number) {
  return static_cast<std::int64_t>(
      std::min(first * std::pow(ratio, static_cast<double>(number)), longestPart));
}

/// Number of sweeps of a compaction before the cells are cooled.
std::int64_t sweepsOfAgitation(std::int64_t part) {
  return geometric(firstCompaction, compactionGrowth, part - annealings - 1);
}

/// Number of sweeps in a part of relax().
std::int64_t sweepsOf(std::int64_t part) {
  if (part == 0) return hotSweeps;
  if (isCompaction(part)) return sweepsOfAgitation(part) + coolingSweeps;
  return geometric(firstAnnealing, annealingGrowth, part - 1);
}

}  // namespace

bool isCompaction(std::int64_t part) {
  return part > annealings;
}

bool isTooDeepToCalibrate(const Relaxation& relaxation) {
  return relaxation.lastSweep().total() >
         shallow * relaxation.halfThickness() * static_cast<double>(relaxation.movableCount());
}

std::int64_t sweepsOfRelax(std::int64_t parts) {
  std::int64_t sweeps = 0;
  for (std::int64_t part = 0; part < parts; ++part) sweeps += sweepsOf(part);
  return sweeps;
}

bool relax(Relaxation& relaxation, const ScheduleLimits& limits, SchedulePosition& at) {
  const auto hot = [&](std::int64_t sweep) {
    return sweep < untemperedSweeps ? hotOmega : tempered(hotOmega, hotDepth, relaxation);
  };
  const auto annealing = [&](std::int64_t sweep) {
    const std::int64_t sweeps = sweepsOf(at.part);
    return tempered(between(hotOmega, coolOmega, sweep, sweeps), between(hotDepth, coolDepth, sweep, sweeps),
                    relaxation);
  };
  const auto compaction = [&](std::int64_t sweep) {
    const std::int64_t agitated = sweepsOfAgitation(at.part);
    const double omega =
        sweep < agitated ? hotOmega : between(hotOmega, cooledOmega, sweep - agitated, coolingSweeps);
    return tempered(omega, compactingDepth, relaxation);
  };
  while (!spent(relaxation, limits)) {
    const bool first = at.part == 0;
    if (!first && at.sweep == 0 && onlyFewContacts(relaxation)) return true;
    const std::int64_t sweeps = sweepsOf(at.part);
    const bool compacting = isCompaction(at.part);
    constexpr double deepest = tolerance::relaxationTolerance;
    if (first        ? sweepWith(hot, sweeps, relaxation, deepest, limits, at.sweep, "relaxation")
        : compacting ? sweepWith(compaction, sweeps, relaxation, deepest, limits, at.sweep, "compaction",
                                 tolerance::compactionSlack)
                     : sweepWith(annealing, sweeps, relaxation, deepest, limits, at.sweep, "annealing"))
      return true;
    if (at.sweep < sweeps) continue;  // this part is complete
    if (compacting && !isTooDeepToCalibrate(relaxation)) return true;
    if (limits.unresolved && limits.unresolved()) {
      at = {};
      return false;
    }
    if (jammed(relaxation, at.part)) return false;
    at = {at.part + 1, 0};
  }
  return false;
}

bool relaxDeepContacts(Relaxation& relaxation, std::int64_t sweeps, const ScheduleLimits& limits,
                       SchedulePosition& at, bool compacted) {
  const double first = compacted ? calibrationOmega : hotOmega;
  const auto omega = [=](std::int64_t sweep) { return between(first, repairOmega, sweep, sweeps); };
  const double slack =
      compacted ? tolerance::compactionSlack : (1.0 - settledFraction) * tolerance::relaxationTolerance;
  return sweepWith(omega, sweeps, relaxation, settledFraction * tolerance::relaxationTolerance, limits,
                   at.sweep, compacted ? "calibration" : "repair", slack);
}

}  // namespace packmesh
