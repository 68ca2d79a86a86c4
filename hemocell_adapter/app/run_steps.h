// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Steps that the program shares with packing for a running HemoCell.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/scene.h"
#include "packMesh/core/timer.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// The scene of a job, with its notices logged. All ranks call. @throws AgreedFailure
/// @param poll called again and again meanwhile; may throw to end the work (endOfPreparation())
Scene builtScene(const Job& job, const Communicator& ranks, const std::function<void()>& poll = {});

/// The cells of a result, on all ranks.
struct Counted {
  std::vector<std::int64_t> parts;  ///< by part of the scene
  Tally tally;                      ///< by species
};

/// Counts the cells, whose species are parts of the scene before and species of the scene after. All ranks
/// call.
Counted counted(const Scene& scene, PackingResult& result, const Communicator& ranks);

/// What HemoCell keeps of the cells of all ranks. All ranks call.
Kept keptOf(const Scene& scene, const std::vector<PlacedCell>& cells, const Communicator& ranks);

/// How messages speak of what becomes of a packing.
struct Delivery {
  const char* nothing;     ///< of one that failed
  const char* bestEffort;  ///< what could be done with one of fewer cells
  const char* fewer;       ///< what is done with it
  bool countedLater;       ///< HemoCell itself is asked which cells it keeps
};
inline constexpr Delivery writtenToFiles = {"nothing was written", "--best-effort writes that one",
                                            "writing that one (--best-effort)", false};
inline constexpr Delivery returnedToPython = {"no cells are returned", "best_effort returns that one",
                                              "returning that one (best_effort)", false};
inline constexpr Delivery addedToHemocell = {"no cells were added", "--best-effort adds those",
                                             "adding those (--best-effort)", true};

/// A function that throws Stopped when the time limit of a job is reached, measured by `timer`, and when the
/// caller asks for an end. References the job, the timer and the delivery.
std::function<void()> endOfPreparation(const Job& job, const Timer& timer, const Delivery& delivery,
                                       std::function<bool()> interrupted = {});

/// A packing that may be handed out.
struct Verified {
  Counted cells;
  Kept kept;
};

/// Counts the cells, verifies the certificate and that HemoCell keeps them. Pre: as counted(). All ranks
/// call.
/// @throws AgreedFailure if not all cells could be packed, unless the scene is content with those that were
/// (--best-effort), or if the packing failed verification
Verified verified(const Scene& scene, PackingResult& result, const Communicator& ranks,
                  const Delivery& delivery);

/// A packing repeated in a larger box.
struct RepeatedPacking {
  Scene scene;
  PackingResult result;
};

/// Repeats the packing in a larger box and certifies it again. The species of `result` are parts of the scene
/// before and species of the scene after; the outcome can be `interrupted`. All ranks call.
RepeatedPacking repeatedInTiles(const Scene& scene, PackingResult& result, const Communicator& ranks,
                                const std::function<bool()>& interrupted);

/// The summary of a run, of which all cells are packed.
void logSummary(const Scene& scene, const Counted& counted, const Certificate& certificate, const Kept& kept,
                const RunTimes& times);

}  // namespace packmesh::hemocell
