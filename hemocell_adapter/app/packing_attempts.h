// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One scene packed with one pair of clearances after another, with progress, states and signals.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "hemocell_adapter/app/progress_log.h"
#include "hemocell_adapter/problem/clearances.h"

namespace packmesh::hemocell {

/// References what it is given. All ranks call everything together.
class PackingAttempts {
 public:
  PackingAttempts(Scene& scene, const Communicator& ranks)
      : scene_(scene), ranks_(ranks), progress_(scene, ranks.size()) {}

  /// Packs; the scene is left with these clearances. The first attempt goes on from the job's `restart`.
  /// @return nothing when the clearances are impossible and fewer cells are not wanted
  /// @throws InputError, AgreedFailure
  std::optional<PackingResult> operator()(const Clearances& clearances, const AttemptLimits& limits);

  /// The level whose state the job's `restart` is; 0 without one, the last where it is of none.
  std::size_t firstLevel(const std::vector<Clearances>& levels);

  /// Whether the last attempt left its state on the disk.
  bool saved() const { return saved_; }

 private:
  PackingProblem problemWith(const Clearances& clearances);

  Scene& scene_;
  const Communicator& ranks_;
  ProgressLog progress_;
  bool begun_ = false, saved_ = false;
};

}  // namespace packmesh::hemocell
