// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a job takes from the C++ code of its case.
#pragma once

#include "hemocell_adapter/problem/job.h"

namespace packmesh::hemocell {

/// The place of the pre-inlet: what the settings state, and where they do not, what the code says. Of a
/// contradiction, and of what is not understood, there is a warning.
/// @throws UsageError, InputError when it cannot be known
void choosePreInlet(Job& job, const Settings& settings);

/// The minimum distance from solid of each species: as stated, or else from the code, or else 0; warnings as
/// above, and where there is no code. Without a case there is none to be known.
void settleDistancesFromSolid(Job& job);

}  // namespace packmesh::hemocell
