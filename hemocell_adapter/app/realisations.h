// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Several packings of one problem, each with its own seed and folder.
#pragma once

#include <functional>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/output/realisation_table.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Result of a run.
struct RunEnd {
  ExitCode code = ExitCode::ok;
  RealisationFigures figures;  ///< if a packing was written
};

/// Runs the realisations of a request in sequence, starting with the first or with outputs.realisation if
/// that is larger, the very first with its seed, in their folders (realisationFolder) of its folder.
/// `restart` applies to the first one that is run. A failure does not prevent the remaining ones from
/// running; an interruption does. Means and standard deviations are printed and the figures of each
/// realisation written to realisations.csv; those of realisations made before are taken from there. All ranks
/// call.
/// @return ok if all are; otherwise the code of the first that failed
ExitCode runRealisations(const CompletedRequest& series, const OutputRequest& outputs,
                         const Communicator& ranks,
                         const std::function<RunEnd(const CompletedRequest&, const OutputRequest&)>& run);

}  // namespace packmesh::hemocell
