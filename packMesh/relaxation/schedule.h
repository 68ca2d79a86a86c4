// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Schedule of the over-relaxation factor and of the number of sweeps.
#pragma once

#include <cstdint>
#include <functional>

#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// Limits of a schedule, and its callbacks.
struct ScheduleLimits {
  std::int64_t maxSweeps = 0;     ///< total of the Relaxation
  std::int64_t sweepsForFew = 0;  ///< added to it if few contacts are left then (0.05 per cell)
  std::function<bool()> stop;     ///< polled before every sweep
  /// Called at the end of a part that has not resolved all; true ends relax() at the beginning of its first
  /// part.
  std::function<bool()> unresolved;
  std::function<void()> beforeRebuild;          ///< called before sweeps that begin with a rebuild
  std::function<void(const char* stage)> tell;  ///< called after every sweep
};

/// Sweeps until no penetration is deeper than tolerance::relaxationTolerance.
///
/// The first 60 sweeps use full over-relaxation, which resolves everything up to a fraction of about 0.55. At
/// higher fractions it keeps the cells agitated, like a temperature; if it is too large, cells lock. From
/// then on it is therefore reduced in proportion to the excess of the mean penetration over a limit: another
/// 240 sweeps, sufficient up to about 0.59. Then the limit and the over-relaxation decrease slowly, as in
/// simulated annealing, over 2000 sweeps, then, after a restart of the annealing, over 2.5 times as many.
/// After that come compactions, in which contacts are only resolved to within tolerance::compactionSlack: the
/// cells are agitated at the most effective limit for some thousand sweeps, then cooled for 1500. It ends
/// without success at the end of a part if the cells still penetrate so deeply that they are jammed (from a
/// fraction of about 0.65 on after the first part).
/// @param at position to start from; kept up to date
/// @return true if the tolerance was reached within the limits, or if so few contacts are left that repairing
///   them one by one will succeed, or so shallow ones after a compaction that calibrating them may; false if
///   a limit was reached or the cells are jammed
bool relax(Relaxation& relaxation, const ScheduleLimits& limits, SchedulePosition& at);
inline bool relax(Relaxation& relaxation, const ScheduleLimits& limits) {
  SchedulePosition start;
  return relax(relaxation, limits, start);
}

/// Total number of sweeps in this many parts of relax(): the first one, annealings, compactions.
std::int64_t sweepsOfRelax(std::int64_t parts);

/// Whether a part of relax() is a compaction, after which the clearances of pairs are calibrated.
bool isCompaction(std::int64_t part);

/// At most `sweeps` sweeps of a nearly resolved state that move only cells with penetrations deeper than
/// tolerance::relaxationTolerance, until there are none.
/// @param at position to start from; kept up to date
/// @param compacted the state is one after a compaction, and the clearances of pairs are calibrated
bool relaxDeepContacts(Relaxation& relaxation, std::int64_t sweeps, const ScheduleLimits& limits,
                       SchedulePosition& at, bool compacted = false);
inline bool relaxDeepContacts(Relaxation& relaxation, std::int64_t sweeps, const ScheduleLimits& limits) {
  SchedulePosition start;
  return relaxDeepContacts(relaxation, sweeps, limits, start);
}

/// Whether the penetrations that are left are too deep for calibration.
bool isTooDeepToCalibrate(const Relaxation& relaxation);

}  // namespace packmesh
