// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How hard to push, and for how long.
#pragma once

#include <cstdint>
#include <functional>

#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// How far a schedule has come.
struct SchedulePosition {
  std::int64_t part = 0;   ///< of relax(): 0 is hot, then annealings
  std::int64_t sweep = 0;  ///< of the part
};

/// What a schedule may use up, and whom it tells.
struct ScheduleLimits {
  std::int64_t maxSweeps = 0;                   ///< all sweeps of the Relaxation together
  std::function<bool()> stop;                   ///< polled before every sweep
  std::function<void()> anew;                   ///< called before sweeps that begin anew
  std::function<void(const char* stage)> tell;  ///< called after every sweep
};

/// Sweeps until no penetration is deeper than `tolerance` [µm].
///
/// First 60 sweeps at full over-relaxation, which resolve everything up to a fraction of about 0.55. Above,
/// it keeps the cells agitated: it acts as a temperature. Too much of it locks them in each other, so from
/// then on it is lowered as far as their mean penetration is beyond a limit: 240 sweeps more, enough up to
/// about 0.59. Then limit and over-relaxation fall slowly, as in simulated annealing, over 2000 sweeps, then,
/// starting hot again, over 2.5 times as many, and so on. It gives up at the end of a part when the cells are
/// still so deep in each other that they are jammed (from a fraction of about 0.65 on after the first part).
/// @param at where to begin; kept up to date
/// @return whether it got there within the limits, or left so few contacts that repairing them one by one
/// will; false: a limit was met, or the cells are jammed
bool relax(Relaxation& relaxation, double tolerance, const ScheduleLimits& limits, SchedulePosition& at);
inline bool relax(Relaxation& relaxation, double tolerance, const ScheduleLimits& limits) {
  SchedulePosition start;
  return relax(relaxation, tolerance, limits, start);
}

/// Sweeps that so many parts of relax() have: the first one, annealings.
std::int64_t sweepsOfRelax(std::int64_t parts);

/// Sweeps a nearly resolved state, at most `sweeps` times, moving only cells with penetrations deeper than
/// `tolerance` [µm], until there are none.
/// @param at where to begin; kept up to date
bool settle(Relaxation& relaxation, double tolerance, std::int64_t sweeps, const ScheduleLimits& limits,
            SchedulePosition& at);
inline bool settle(Relaxation& relaxation, double tolerance, std::int64_t sweeps,
                   const ScheduleLimits& limits) {
  SchedulePosition start;
  return settle(relaxation, tolerance, sweeps, limits, start);
}

}  // namespace packmesh
