// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The tasks as which mpirun or srun started the program.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace packmesh {

/// The whole number in an environment variable, up to `end`, without the blanks around it; -1 if something
/// else is there. Empty: the variable is not set, or to nothing.
std::optional<std::int64_t> numberInEnvironment(const char* variable, char end = '\0');

/// What started the program.
enum class Launcher {
  none,       ///< or one that is not known
  ofOpenMpi,  ///< mpirun of Open MPI
  hydra,      ///< mpirun of MPICH, Intel MPI and others
  slurm,      ///< srun without a connection of the tasks
  slurmPmi2,  ///< srun --mpi=pmi2
  pmix,       ///< one that connects by PMIx: srun --mpi=pmix, prrte
};

/// The tasks that a launcher started, by the environment. Whether MPI connects them is another question.
struct LaunchedTasks {
  Launcher launcher = Launcher::none;
  bool bySlurm = false;  ///< srun started them
  int count = 1;         ///< at least; launchers by PMIx alone do not state it
  int number = 0;        ///< of this task, 0 ... count - 1

  bool several() const { return count > 1; }
};

/// Whether this process has a terminal; tasks of srun have none.
bool hasControllingTerminal();

LaunchedTasks launchedTasks(bool hasTerminal = hasControllingTerminal());

/// True if the tasks can be ranks of MPI. If not, initialising MPI would be in vain, take longer than many
/// packings, or end the program: so Open MPI does under Slurm if it has no connection.
bool canBeRanks(const LaunchedTasks& tasks);

/// False if there are several tasks, each alone in a world of its own. Pre: MPI is initialised
bool areConnected(const LaunchedTasks& tasks);

/// Why the tasks are not ranks of MPI, and what to do about it. Pre: there are several
std::string notConnectedText(const LaunchedTasks& tasks);

}  // namespace packmesh
