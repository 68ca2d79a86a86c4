// SPDX-License-Identifier: AGPL-3.0-or-later
// The packMesh executable: understands the command line, does the job, tells scripts how it went.
#include <fmt/format.h>

#include <cstdlib>
#include <exception>
#include <new>

#include "hemocell_adapter/command_line.h"
#include "hemocell_adapter/exit_codes.h"
#include "hemocell_adapter/interruption.h"
#include "hemocell_adapter/job.h"
#include "hemocell_adapter/log.h"
#include "hemocell_adapter/run.h"
#include "packMesh/version.h"

namespace {

using namespace packmesh::hemocell;

/// A number that the MPI launcher puts into the environment, `fallback` without one.
int launcherNumber(std::initializer_list<const char*> variables, int fallback) {
  for (const char* variable : variables) {
    if (const char* text = std::getenv(variable)) return std::atoi(text);
  }
  return fallback;
}

int ranks() {
  return launcherNumber({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}, 1);
}
int rank() {
  return launcherNumber({"OMPI_COMM_WORLD_RANK", "PMI_RANK"}, 0);
}

ExitCode run(const std::string& program, const std::vector<std::string>& arguments) {
  const CommandLine commandLine = parseCommandLine(program, arguments);
  switch (commandLine.command) {
    case Command::help:
      fmt::print("{}", helpText(commandLine.asPackCells));
      return ExitCode::ok;
    case Command::version:
      fmt::print("packMesh {} ({})\n", packmesh::version(), packmesh::gitHash());
      return ExitCode::ok;
    case Command::reference:
      fmt::print("{}", referenceText());
      return ExitCode::ok;
    case Command::pack:
    case Command::check:
      break;
  }
  const Settings options = commandLine.settings();
  if (options.quiet.value_or(false)) log::setLevel(log::Level::quiet);
  if (options.verbose.value_or(false)) log::setLevel(log::Level::verbose);
  if (ranks() > 1) {
    throw UsageError(
        fmt::format("started on {} ranks, but one rank packs everything: start it without mpirun, or with "
                    "mpirun -n 1",
                    ranks()));
  }
  catchInterruption();
  const Job job = makeJob(commandLine);
  return commandLine.command == Command::check ? runCheck(job) : runPacking(job);
}

int failed(ExitCode code, const std::string& message) {
  if (rank() == 0) log::error(message);
  return int(code);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return int(
        run(argc > 0 ? argv[0] : "packMesh", std::vector<std::string>(argv + (argc > 0), argv + argc)));
  } catch (const UsageError& error) {
    return failed(ExitCode::usage, error.what());
  } catch (const OutputError& error) {
    return failed(ExitCode::cannotWrite, error.what());
  } catch (const packmesh::InputError& error) {
    return failed(ExitCode::badInput, error.what());
  } catch (const std::bad_alloc&) {
    return failed(ExitCode::badInput, "not enough memory for a problem of this size");
  } catch (const std::exception& error) {
    return failed(ExitCode::internal, std::string("a fault of packMesh, please report it: ") + error.what());
  }
}
