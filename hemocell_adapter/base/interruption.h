// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signals: interruption and checkpoint requests.
#pragma once

#include <filesystem>

namespace packmesh::hemocell {

/// From now on SIGINT, SIGTERM, SIGHUP and SIGXCPU end the program immediately, with a message and exit code
/// 130, and SIGUSR1 requests a checkpoint. A SIGHUP that is already ignored remains ignored (nohup).
void catchSignals();

/// From now on these signals are ignored. For the end of the program, when launchers can send them to ranks
/// that finish slightly later than the first.
void ignoreInterruption();

/// From now on the first signal only sets a flag. For packing, which polls the flag, and for writing, which
/// must not be cut short. A second signal, at least two seconds later, still ends the program.
void pollInterruption();

/// True if the flag is set.
bool interrupted();

/// Registers a file or an empty folder to be removed if a signal ends the program immediately. @return a
/// number for keepWhenEnded(), negative if too many files are registered
int removeWhenEndedAtOnce(const std::filesystem::path& file);
void keepWhenEnded(int number);

/// True if SIGUSR1 was received since the request was last cleared.
bool checkpointAsked();
void forgetCheckpointAsked();

}  // namespace packmesh::hemocell
