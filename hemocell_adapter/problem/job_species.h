// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The kinds of cells of a job.
#pragma once

#include "hemocell_adapter/problem/job.h"

namespace packmesh::hemocell {

/// The species to pack: those of `<packing>` and of the options, plus RBC (and PLT) if a hematocrit requires
/// them. `settings` are the merged ones, `options` those of the command line alone, which take precedence.
/// May clear job.hematocrit (counts on the command line replace one in the file).
void choosePackedSpecies(Job& job, Settings settings, const Settings& options);

/// Replaces state files by requests for the species in them. @throws InputError
void nameSpeciesOfStates(Settings& settings);

/// The species to check: one for each .pos file in the folder, or kind of cell in the states to start from,
/// whose template can be determined.
void chooseCheckedSpecies(Job& job, const Settings& settings);

}  // namespace packmesh::hemocell
