// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The executable's commands: pack and check.
#pragma once

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Packs, verifies and writes. Existing .pos files are replaced by certified ones or not at all. All ranks
/// call; the files written do not depend on the number of ranks.
/// @throws UsageError, InputError, OutputError; AgreedFailure if there are several ranks
ExitCode runPacking(const Request& asked, const Communicator& ranks);

/// Examines the .pos files of a folder, or those of each of several realisations: one line for each, and all
/// details of the folder that contains them. All ranks call; what is said and written does not depend on
/// their number.
/// @return ok if all are clean; otherwise the highest code
/// @throws UsageError, InputError; AgreedFailure if there are several ranks
ExitCode runCheck(const Request& asked, const Communicator& ranks);

}  // namespace packmesh::hemocell
