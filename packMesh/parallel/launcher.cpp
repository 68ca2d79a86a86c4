// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/launcher.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <string_view>

namespace packmesh {

std::optional<std::int64_t> numberInEnvironment(const char* variable, char end) {
  constexpr const char* blanks = " \t\r\n";
  const char* value = std::getenv(variable);
  std::string_view text = value ? value : "";
  if (text.find_first_not_of(blanks) == text.npos) return {};
  text = text.substr(0, text.find(end));
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  text = text.substr(0, text.find_last_not_of(blanks) + 1);
  std::int64_t number = -1;
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && last == text.data() + text.size() ? number : -1;
}

namespace {

bool isSet(const char* variable) {
  return std::getenv(variable) != nullptr;
}

/// The number of or among tasks in a variable, if it is one.
std::optional<int> taskNumber(const char* variable) {
  const std::optional<std::int64_t> value = numberInEnvironment(variable);
  if (!value || *value < 0) return {};
  return static_cast<int>(std::min<std::int64_t>(*value, 1 << 30));
}

/// "Open MPI v4.1.4", "MPICH Version: 4.0.2"
std::string mpiLibrary() {
  char text[MPI_MAX_LIBRARY_VERSION_STRING] = {};
  int length = 0;
  MPI_Get_library_version(text, &length);
  std::string name(text);
  name.resize(std::min(name.find_first_of(",\n"), name.size()));
  for (std::size_t tab; (tab = name.find('\t')) != std::string::npos;) name.replace(tab, 1, " ");
  return name;
}

bool isOpenMpi() {
  return mpiLibrary().rfind("Open MPI", 0) == 0;
}

}  // namespace

bool hasControllingTerminal() {
  const int terminal = ::open("/dev/tty", O_RDONLY | O_NOCTTY | O_CLOEXEC);
  if (terminal >= 0) ::close(terminal);
  return terminal >= 0;
}

LaunchedTasks launchedTasks(bool hasTerminal) {
  // mpirun starts its daemons by srun: its tasks have variables of Slurm, too. Its own are read first.
  if (const auto count = taskNumber("OMPI_COMM_WORLD_SIZE"))
    return {Launcher::ofOpenMpi, false, *count, taskNumber("OMPI_COMM_WORLD_RANK").value_or(0)};
  if (isSet("MPI_LOCALNRANKS") && isSet("PMI_SIZE"))
    return {Launcher::hydra, false, taskNumber("PMI_SIZE").value_or(1), taskNumber("PMI_RANK").value_or(0)};
  // The shell of srun --pty is a single process, whatever the number of tasks. Tasks that srun starts from it
  // inherit the variable, but not the terminal.
  if (isSet("SLURM_PTY_PORT") && hasTerminal) return {};
  // Batch scripts have variables of Slurm, but are no step.
  const auto steps = taskNumber("SLURM_STEP_NUM_TASKS");
  const auto ofPmix = taskNumber("PMIX_RANK");
  if (steps)
    return {ofPmix            ? Launcher::pmix
            : isSet("PMI_FD") ? Launcher::slurmPmi2
                              : Launcher::slurm,
            true, *steps, taskNumber("SLURM_PROCID").value_or(0)};
  if (ofPmix) return {Launcher::pmix, false, *ofPmix + 1, *ofPmix};
  return {Launcher::none, false, taskNumber("PMI_SIZE").value_or(1), taskNumber("PMI_RANK").value_or(0)};
}

bool canBeRanks(const LaunchedTasks& tasks) {
  switch (tasks.launcher) {
    case Launcher::pmix:
      return tasks.several() || !tasks.bySlurm;  // others do not state the number of tasks
    case Launcher::hydra:
    case Launcher::slurm:  // others than Open MPI can ask srun by PMI-1
    case Launcher::slurmPmi2:
      return tasks.several() && !isOpenMpi();
    case Launcher::ofOpenMpi:
    case Launcher::none:
      break;
  }
  return tasks.several();
}

bool areConnected(const LaunchedTasks& tasks) {
  int size = 1;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size > 1 || !tasks.several();
}

std::string notConnectedText(const LaunchedTasks& tasks) {
  const std::string library = mpiLibrary();
  std::string text = fmt::format(
      "{} started {} copies of the program, but {} does not connect them; nothing was packed or written. ",
      tasks.bySlurm ? "srun" : "mpirun", tasks.count, library);
  const char* type = isOpenMpi() ? "pmix" : "pmi2";
  const bool tried = tasks.launcher == (isOpenMpi() ? Launcher::pmix : Launcher::slurmPmi2);
  if (!tasks.bySlurm)
    text += fmt::format("Start it with the mpirun of {} (mpirun --version)", library);
  else if (tried)
    text += fmt::format(
        "Slurm's --mpi={} does not suit this library: use its mpirun in the job instead of srun", type);
  else
    text += fmt::format(
        "Add --mpi={}: srun --mpi={} ... (srun --mpi=list prints what Slurm offers); or use the mpirun of {} "
        "in the job instead of srun",
        type, type, library);
  if (tasks.bySlurm) text += ". For a single copy, add --ntasks=1";
  return text;
}

}  // namespace packmesh
