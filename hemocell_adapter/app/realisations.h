// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Several packings of one problem, each with a seed and a folder of its own.
#pragma once

#include <functional>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/output/realisation_table.h"
#include "hemocell_adapter/problem/job.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// How a run ended.
struct RunEnd {
  ExitCode code = ExitCode::ok;
  RealisationFigures figures;  ///< when a packing was written
};

/// Runs `job.realisations` of the job one after the other, from job.firstRealisation on, the first of all
/// with job.seed, in their folders (realisationFolder) of its output directory. `job.restart` is for the one
/// that comes first. One that fails does not keep others from running; an interruption does. Means and
/// spreads are told and the figures of each written to realisations.csv; those of realisations made before
/// are taken from there. All ranks call.
/// @return ok when all are; otherwise the code of the first that failed
ExitCode runRealisations(const Job& job, const Communicator& ranks,
                         const std::function<RunEnd(const Job&)>& run);

}  // namespace packmesh::hemocell
