// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Errors with several ranks: all ranks stop, one reports the error. The threads of a rank.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "hemocell_adapter/base/exit_codes.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"

namespace packmesh::hemocell {

/// The failure that corresponds to the exception being handled. Pre: called in a catch block.
Failure failureOfException();

/// Invalid input is invalid on all ranks: the first one reports it, and all end. A rank that fails alone ends
/// the others, which wait for it; lower ranks come first, so that only one of them reports.
/// Returns only if all ranks have failed, or there is only one; waits for the others for some seconds.
void endUnlessOfAll(const Failure& failure, Arrival& failures, const Communicator& ranks);

/// All ranks execute `work`, which must not communicate. Collective.
/// @throws AgreedFailure on all ranks if it fails on any rank, with the failure of the lowest such rank
void together(const Communicator& ranks, const std::function<void()>& work);

/// Only rank 0 executes `work`. Collective. @throws AgreedFailure on all ranks if it fails
void onFirstRank(const Communicator& ranks, const std::function<void()>& work);

/// For a program that uses MPI itself. @throws AgreedFailure if a launcher started several copies of it which
/// MPI does not connect: each would do all the work. Pre: MPI is initialised
void requireConnected();

/// The largest number of threads that a user can request.
inline constexpr int maxThreads = 1024;

/// The threads of each rank. There are not more than four per core, or sixteen: more never help.
/// @param requested if empty: OMP_NUM_THREADS; if that is not set: SLURM_CPUS_PER_TASK, as far as the rank
/// may use so many cores; otherwise as many as there are cores for a single rank, one for each of several
/// @throws UsageError if OMP_NUM_THREADS is not 1 ... maxThreads, or if several are requested of each of
/// several ranks whose MPI permits one thread only; where they were not requested, one is used, with a
/// warning
Threads makeThreads(std::optional<std::int64_t> requested, const Communicator& ranks);

}  // namespace packmesh::hemocell
