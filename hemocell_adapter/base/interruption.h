// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signals: interruption and checkpoint requests.
#pragma once

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

/// True if SIGUSR1 was received since the request was last cleared.
bool checkpointAsked();
void forgetCheckpointAsked();

}  // namespace packmesh::hemocell
