// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Errors when several ranks work together: all stop, one tells why.
#pragma once

#include <functional>

#include "hemocell_adapter/base/agreed_failure.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// What the exception that is being handled means for users. Pre: called in a catch block.
Failure failureOfException();

/// All ranks do `work`, in which they do not talk to each other.
/// @throws AgreedFailure on all ranks when it fails on any of them: the failure of the first one
void together(const Communicator& ranks, const std::function<void()>& work);

/// Only the first rank does `work`. @throws AgreedFailure on all ranks when it fails
void onFirstRank(const Communicator& ranks, const std::function<void()>& work);

}  // namespace packmesh::hemocell
