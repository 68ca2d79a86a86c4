// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Errors with several ranks: all ranks stop, one reports the error.
#pragma once

#include <functional>

#include "hemocell_adapter/base/agreed_failure.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// The failure that corresponds to the exception being handled. Pre: called in a catch block.
Failure failureOfException();

/// All ranks execute `work`, which must not communicate. Collective.
/// @throws AgreedFailure on all ranks if it fails on any rank, with the failure of the lowest such rank
void together(const Communicator& ranks, const std::function<void()>& work);

/// Only rank 0 executes `work`. Collective. @throws AgreedFailure on all ranks if it fails
void onFirstRank(const Communicator& ranks, const std::function<void()>& work);

}  // namespace packmesh::hemocell
