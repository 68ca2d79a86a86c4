// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Several packings of one problem, each with a seed and a folder of its own.
#pragma once

#include <functional>

#include "hemocell_adapter/exit_codes.h"
#include "hemocell_adapter/job.h"

namespace packmesh::hemocell {

/// Runs `job.realisations` of the job one after the other, with seeds from job.seed on, in the folders
/// realisation_1, realisation_2 ... (as many digits as the last one has) of its output directory. One that
/// fails does not keep others from running; an interruption does.
/// @return ok when all are; otherwise the code of the first that failed
ExitCode runRealisations(const Job& job, const std::function<ExitCode(const Job&)>& run);

}  // namespace packmesh::hemocell
