// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One session: a request becomes a problem, the problem a packing that may be handed out. Program,
/// plug-in and Python are front ends of it, and say only what becomes of the packing.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/problem/problem.h"
#include "hemocell_adapter/session/ladder.h"
#include "packMesh/core/timer.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Least memory of a cell [bytes]: undeformed, with hardly any neighbours (912 were measured as the
/// difference of 500,000 and 100,000 cells, at a hematocrit of 0.2 1345); and of a deformed red cell (120,000
/// with the contacts of a hematocrit of 0.60). Nothing feasible is to be refused.
constexpr double leastOfCell = 900.0, leastOfDeformedCell = 60e3;

/// Memory available to this process [bytes]: within the limits of the machine, its control group and its
/// address space, the first two shared among the ranks of the machine.
double availableMemory(const Communicator& ranks);

/// All ranks call, alone.
/// @param ofEach least memory of a cell [bytes]
/// @throws InputError with figures when this rank's share of so many cells does not fit
void requireMemory(std::int64_t cells, const Communicator& ranks, double ofEach = leastOfCell);

/// @throws InputError if the box is not periodic along an axis along which it is repeated, or if there are
///   too many cells
void requireTileable(const Problem& problem);

/// The problem of packing a larger box with cells that are there: those of `result`, whose species are the
/// problem's, with all images of a cell in succession. All ranks call; each gets all cells.
/// @param clearances that the packing has
/// @throws InputError as requireTileable()
Problem tiledProblem(const Problem& problem, const Clearances& clearances, const PackingResult& result);

/// What becomes of a packing, in the words of messages.
struct Delivery {
  const char* nothing;       ///< of one that failed
  const char* bestEffort;    ///< what could be done with one of fewer cells: "(best effort) ..."
  const char* fewer;         ///< what is done with it
  const char* interrupted;   ///< of one that was interrupted
  const char* continueFrom;  ///< the same, if its state was saved: text before the name of the file
  bool countedLater;         ///< HemoCell itself is asked which cells it keeps
};
inline constexpr Delivery writtenToFiles = {"nothing was written",
                                            "writes that one",
                                            "writing that one",
                                            "nothing was written",
                                            "no .pos was written; to continue: packMesh --restart ",
                                            false};
inline constexpr Delivery returnedToPython = {"no cells are returned",
                                              "returns that one",
                                              "returning that one",
                                              "nothing was written",
                                              "no cells are returned; to continue: restart from ",
                                              false};
inline constexpr Delivery addedToHemocell = {"no cells were added",
                                             "adds those",
                                             "adding those",
                                             "no cells were added",
                                             "no cells were added; the state is in ",
                                             true};

/// A function that throws AgreedFailure, inside together(), when `maxSeconds` (0: no limit) have passed since
/// now, and when the caller asks for an end.
std::function<void()> endOfPreparation(double maxSeconds, const Delivery& delivery,
                                       std::function<bool()> interrupted = {});

/// A session of one front end. All ranks call everything together. References its arguments.
class Session {
 public:
  Session(const Delivery& delivery, Hooks hooks, const Communicator& ranks)
      : delivery_(delivery), hooks_(std::move(hooks)), ranks_(ranks) {}

  /// Makes the problem of a request, and tells its notices. With a profile it is packed quickly, without a
  /// certificate for anybody, to see how cells arrange themselves. The time limit and interruptions end it.
  /// @throws AgreedFailure
  std::shared_ptr<const Problem> prepare(const CompletedRequest& completed);

  /// Packs by the plan (plan.h), and verifies; repeats the packing in a larger box if that is requested.
  /// @param output of which checkpoints and states of the engine are written
  /// @throws AgreedFailure if not all cells could be packed (unless the request is content with those that
  ///   were, --best-effort), if the packing failed verification, or if it was interrupted; InputError
  Packing pack(const std::shared_ptr<const Problem>& requested, const OutputRequest& output);

  /// Of the lumen of a problem, kept for the last one that was asked for.
  LumenSample& sampleOf(const std::shared_ptr<const Problem>& problem);

  /// Whether the last checkpoint has been written, also after a failure; whether there is one of this run.
  bool stateSaved() const { return stateSaved_; }
  bool stateSavedOnce() const { return stateSavedOnce_; }
  /// After a failure: the option with which a restart may get farther; empty: none would help by itself.
  const std::string& raise() const { return raise_; }
  const Timer& timer() const { return timer_; }

 private:
  [[noreturn]] void throwInterrupted(const OutputRequest& output) const;
  std::shared_ptr<const Problem> correctByPilots(std::shared_ptr<const Problem> problem) const;
  Packing verify(Packing packing);
  Packing repeatInTiles(Packing before);

  const Delivery& delivery_;
  Hooks hooks_;
  const Communicator& ranks_;
  Timer timer_;
  std::shared_ptr<const Problem> sampled_;
  std::optional<LumenSample> sample_;  ///< of `sampled_`
  bool stateSaved_ = false, stateSavedOnce_ = false;
  std::string raise_;
};

/// The summary of a packing, of its regions and its profile. All ranks call.
void logSummary(const Packing& packing);

}  // namespace packmesh::hemocell
