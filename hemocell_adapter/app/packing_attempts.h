// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Packing of one scene with a sequence of clearances, with progress, states and signals.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "hemocell_adapter/app/progress_log.h"
#include "hemocell_adapter/problem/clearances.h"
#include "packMesh/core/timer.h"

namespace packmesh::hemocell {

/// What a packing asks and tells while it runs; empty: the signals of base/interruption.h, a ProgressLog.
struct RunHooks {
  std::function<bool()> interrupted;
  std::function<void(const Progress&)> progress;
};

/// References its arguments. All ranks call everything together.
class PackingAttempts {
 public:
  PackingAttempts(Scene& scene, const Communicator& ranks, const RunHooks& hooks = {});

  /// Packs; the scene then has these clearances. The first attempt continues from the job's `restart`.
  /// @return nothing if the clearances are impossible and fewer cells are not requested
  /// @throws InputError, AgreedFailure
  std::optional<PackingResult> operator()(const Clearances& clearances, const AttemptLimits& limits);

  /// Packs with the widest clearances that are found quickly, as packWithRoom() does, and reports effort and
  /// clearances unless interrupted. @param timer since packing began
  RoomyPacking withRoom(const Timer& timer);

  /// The level to which the state of the job's `restart` belongs; 0 without one, the last if it belongs to
  /// none.
  std::size_t firstLevel(const std::vector<Clearances>& levels);

  /// Whether the state of the last attempt has been written.
  bool saved() const { return saved_; }

 private:
  PackingProblem problemWith(const Clearances& clearances);

  Scene& scene_;
  const Communicator& ranks_;
  ProgressLog progress_;
  RunHooks hooks_;
  bool begun_ = false, saved_ = false;
};

}  // namespace packmesh::hemocell
