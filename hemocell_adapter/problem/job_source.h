// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Data that a job takes from the C++ code of its case.
#pragma once

#include "hemocell_adapter/problem/job.h"

namespace packmesh::hemocell {

/// The place of the pre-inlet: as specified by the settings, otherwise from the code. Contradictions and code
/// that is not understood cause a warning.
/// @throws UsageError, InputError if it cannot be determined
void choosePreInlet(Job& job, const Settings& settings);

/// The minimum distance from solid of each species: as specified, otherwise from the code, otherwise 0;
/// warnings as above, and if there is no code. Without a case it is not needed.
void settleDistancesFromSolid(Job& job);

}  // namespace packmesh::hemocell
