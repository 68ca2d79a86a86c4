// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What users read while the program runs, in the manner of HemoCell: `(packMesh) (Warning) ...`.
#pragma once

#include <string>

namespace packmesh::hemocell::log {

/// silent: nothing at all, for all ranks but the first.
enum class Level { silent, quiet, normal, verbose };

void setLevel(Level level);
Level level();

/// Whether standard output is a terminal that somebody may be looking at (not under Slurm or mpirun).
bool isTerminal();
/// A line that the next one, whichever, replaces: to the terminal, unless quiet. Pre: isTerminal()
void status(const std::string& message);

/// To standard output, unless quiet.
void info(const std::string& message);
/// To standard output when verbose.
void detail(const std::string& message);
/// To standard error, unless silent.
void warning(const std::string& message);
void error(const std::string& message);

}  // namespace packmesh::hemocell::log
