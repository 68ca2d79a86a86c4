// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The plan of a run: the attempts that are made in sequence to meet a request, with their clearances
/// and limits.
///
/// HemoCell needs no clearance to load a cell, but its cells move: a vertex that moves onto a wall node is
/// deleted together with its cell, and membranes nearer than the range of the immersed boundary interact from
/// the first step. So more than is demanded is tried first. docs/explanation/method.md reports the
/// measurements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// The clearances that are tried in sequence for undeformed cells, the widest first; the last are those
/// demanded, the only ones with a reserve, which takes as long as a complete packing.
std::vector<Clearances> clearanceLevels(const Problem& problem);

/// The least clearance to a solid wall that packing aims at if none is demanded [µm].
double leastWallRoom(const Request& request);

/// Whether packing aims at larger clearances than demanded, if they can be achieved.
bool triesMoreClearance(const Request& request);

/// One attempt.
struct Rung {
  enum class Cells {
    undeformed,
    probe,  ///< undeformed, for a moment: only whether they can be packed easily
    soft,
  };
  Cells cells = Cells::undeformed;
  Clearances clearances;
  std::size_t otherwise = 0;      ///< the next rung if this one fails; if there is none, the run ends
  double until = 1.0;             ///< share of the time limit at which it ends
  double share = 1.0;             ///< of the time until then, that it may take
  std::int64_t most = 0;          ///< sweeps or iterations; 0: as many as the request allows
  std::int64_t sweepsForFew = 0;  ///< further ones if only few contacts are left then
  bool someCloser = false;        ///< a few cells may keep less
  bool fewerCells = false;        ///< if not all can be packed, as many as possible are
  bool savesStates = true;        ///< from which a run continues
  bool savesFailed = true;        ///< of soft cells: also that of an attempt that failed
  bool smoothWalls = false;       ///< of fluid nodes, for soft cells
  double lessRoomThan = 0.0;  ///< soft cells may be nearer to the wall than they should [µm]; 0: they may not

  bool isSoft() const { return cells == Cells::soft; }
  /// "soft cells, 0.35 µm to the wall, at most 4000 iterations". @param limited the run has a time limit
  std::string text(bool limited) const;
};

/// The rungs in the order in which they are tried: the first that succeeds is the packing, unless it is a
/// probe, after which the next one follows.
struct Plan {
  std::vector<Rung> rungs;
  bool widens = false;  ///< afterwards: the clearance between membranes is enlarged as far as possible

  /// One line for each rung: "1. undeformed cells, ...; otherwise 3". @param limited as above
  std::vector<std::string> lines(bool limited) const;
};

/// What a run continues from.
enum class Begin {
  anew,
  undeformed,  ///< a state of undeformed cells
  soft,        ///< a state of soft cells
};

/// The plan for a problem. Deterministic: the same on all ranks.
Plan planOf(const Problem& problem, LumenSample& sample, Begin begin = Begin::anew);

/// Wall time that a rung may take [s], given the time limit and what has passed; 0: no limit.
double secondsOf(const Rung& rung, double limit, double elapsed);

/// Time for the largest clearance if no limit is given [s].
constexpr double defaultSearch = 60.0;
/// The clearance to try next for the largest one, between one that succeeded and one that failed (0: none has
/// failed) [µm]; empty: the one that succeeded is the largest, up to 2 %.
std::optional<double> widerClearance(double succeeded, double failed);
/// The rung for that.
Rung widerRung(const Problem& problem, const Clearances& clearances);

}  // namespace packmesh::hemocell
