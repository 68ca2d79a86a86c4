// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Messages to the user in HemoCell's style: `(packMesh) (Warning) ...`.
#pragma once

#include <functional>
#include <string>

namespace packmesh::hemocell::log {

/// silent: no messages; for all ranks except the first.
enum class Level { silent, quiet, normal, verbose };

void setLevel(Level level);
Level level();

/// What a message is; repair: a warning that a mesh of the user was changed.
enum class Kind { detail, info, warning, error, repair };
/// Messages are given to `sink` instead of being printed, unless silent; empty: they are printed.
void setSink(std::function<void(Kind, const std::string&)> sink);

/// True if standard output is a terminal used interactively (not under Slurm or mpirun).
bool isTerminal();
/// Prints a line to the terminal, unless quiet, that the next line replaces. Pre: isTerminal()
void status(const std::string& message);

/// Prints to standard output, unless quiet.
void info(const std::string& message);
/// Prints to standard output if verbose.
void detail(const std::string& message);
/// Prints to standard error, unless silent.
void warning(const std::string& message);
void repair(const std::string& message);
void error(const std::string& message);

}  // namespace packmesh::hemocell::log
