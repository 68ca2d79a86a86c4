// SPDX-License-Identifier: AGPL-3.0-or-later
// The packMesh executable: understands the command line, does the job, tells scripts how it went.
#include <fmt/format.h>

#include <chrono>
#include <limits>
#include <optional>
#include <thread>

#include "hemocell_adapter/app/run.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/version.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/launcher.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

using namespace packmesh;
using namespace packmesh::hemocell;

/// Memory is freed and requested again at every rebuild of the neighbour lists: returning it to the system
/// each time took an eighth of the time of a million cells, as it has to be zeroed again.
void keepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

/// Of a task that a launcher started without connecting it to the others: one tells the user.
ExitCode tellNotConnected(const LaunchedTasks& tasks) {
  if (tasks.number == 0)
    log::error(notConnectedText(tasks));
  else  // launchers can end all tasks with the first one
    std::this_thread::sleep_for(std::chrono::seconds(1));
  return ExitCode::notConnected;
}

/// What is printed instead of packing or checking.
std::string documentText(const CommandLine& commandLine) {
  switch (commandLine.command) {
    case Command::help:
      return helpText(commandLine.asPackCells);
    case Command::version:
      return fmt::format("packMesh {} ({})\n", packmesh::version(), packmesh::gitHash());
    case Command::reference:
      return referenceText();
    case Command::man:
      return manText();
    case Command::completion:
      return completionText();
    case Command::pack:
    case Command::check:
      break;
  }
  return {};
}

ExitCode run(const std::string& program, const std::vector<std::string>& arguments,
             const Communicator& ranks) {
  const InputRecord inputs;  // none of them is overwritten
  CommandLine commandLine;
  together(ranks, [&] {
    commandLine = parseCommandLine(program, arguments);
    if (commandLine.command == Command::pack) commandLine.request = continued(commandLine.request);
  });
  const bool first = ranks.rank() == 0;
  if (commandLine.command != Command::pack && commandLine.command != Command::check) {
    if (first) fmt::print("{}", documentText(commandLine));
    return ExitCode::ok;
  }
  const Request& asked = commandLine.request;
  if (first && asked.quiet) log::setLevel(log::Level::quiet);
  if (first && asked.verbose) log::setLevel(log::Level::verbose);
  catchSignals();
  return commandLine.command == Command::pack ? runPacking(asked, ranks) : runCheck(asked, ranks);
}

/// Runs, and reports errors. @return the exit code, the same on all ranks
ExitCode runAndTell(const std::string& program, const std::vector<std::string>& arguments,
                    const Communicator& ranks) {
  Arrival failures(ranks);
  try {
    return run(program, arguments, ranks);
  } catch (const AgreedFailure& failure) {
    log::error(failure.what());
    return failure.code();
  } catch (...) {
    const Failure failure = failureOfException();
    endUnlessOfAll(failure, failures, ranks);
    log::error(failure.message);
    return failure.code;
  }
}

}  // namespace

int main(int argc, char** argv) {
  keepFreedMemory();
  const std::vector<std::string> arguments(argv + (argc > 0), argv + argc);
  std::optional<MpiSession> mpi;
  Communicator ranks;
  const LaunchedTasks tasks = launchedTasks();
  if (canBeRanks(tasks)) {
    mpi.emplace();
    ranks = Communicator::world();
    if (ranks.rank() > 0) log::setLevel(log::Level::silent);
  }
  if (tasks.several() && ranks.size() == 1) return int(tellNotConnected(tasks));
  const ExitCode code = runAndTell(argc > 0 ? argv[0] : "packMesh", arguments, ranks);
  ignoreInterruption();
  return int(code);
}
