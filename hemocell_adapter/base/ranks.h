// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Errors with several ranks: all ranks stop, one reports the error. The threads of a rank.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "hemocell_adapter/base/agreed_failure.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"

namespace packmesh::hemocell {

/// The failure that corresponds to the exception being handled. Pre: called in a catch block.
Failure failureOfException();

/// All ranks execute `work`, which must not communicate. Collective.
/// @throws AgreedFailure on all ranks if it fails on any rank, with the failure of the lowest such rank
void together(const Communicator& ranks, const std::function<void()>& work);

/// Only rank 0 executes `work`. Collective. @throws AgreedFailure on all ranks if it fails
void onFirstRank(const Communicator& ranks, const std::function<void()>& work);

/// The threads of each rank. @param requested if empty: OMP_NUM_THREADS; if that is not set either: as many
/// as there are cores for a single rank, one for each of several
Threads teamOf(std::optional<std::int64_t> requested, const Communicator& ranks);

}  // namespace packmesh::hemocell
