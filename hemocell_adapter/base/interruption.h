// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Ctrl-C and other signals.
#pragma once

#include <filesystem>

namespace packmesh::hemocell {

/// From now on SIGINT, SIGTERM, SIGHUP and SIGXCPU end the program at once, with a message and exit code 130,
/// and SIGUSR1 asks for a checkpoint. A SIGHUP that is ignored stays so (nohup).
void catchSignals();

/// From now on these signals do nothing: for the end of the program, when all is done or told, and launchers
/// send them to the ranks that are a little later than the first.
void ignoreInterruption();

/// From now on the first signal only sets a flag. For packing, which asks for the flag, and for writing,
/// which is not to be cut short. A second signal, two seconds later or more, ends the program all the same.
void pollInterruption();

/// Whether the flag is set.
bool interrupted();

/// A file that goes away when a signal ends the program at once. @return a number for keepWhenEnded(),
/// negative when too many are known already
int removeWhenEndedAtOnce(const std::filesystem::path& file);
void keepWhenEnded(int number);

/// Whether SIGUSR1 came since this was forgotten.
bool checkpointAsked();
void forgetCheckpointAsked();

}  // namespace packmesh::hemocell
