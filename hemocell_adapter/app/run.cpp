// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "hemocell_adapter/app/realisations.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/session/session.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/version.h"
#include "packMesh/io/atomic_files.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isSameFile(int descriptor, const fs::path& path) {
  struct stat open, there;
  return ::fstat(descriptor, &open) == 0 && ::stat(path.c_str(), &there) == 0 &&
         open.st_dev == there.st_dev && open.st_ino == there.st_ino;
}

/// What the holder of a lock wrote into its file.
std::string holderIn(const fs::path& path) {
  std::ifstream in(path);
  std::string holder;
  return std::getline(in, holder) && !holder.empty() ? " (" + holder + ")" : "";
}

/// Time to wait for a lock [s]: ranks of a run that was stopped may end slightly later than the run.
constexpr std::chrono::seconds patience(2);
constexpr std::chrono::milliseconds pause(50);

void tellHolder(int descriptor) {
  const std::string holder = fmt::format("process {} on {}\n", processNumber(), hostName());
  if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, holder.data(), holder.size(), 0) < 0)
    log::detail("The lock file cannot be written: " + std::string(std::strerror(errno)));
}

/// Removes what runs that were killed have left in a folder.
template <class Chosen>
void removeTemporary(const fs::path& folder, const Chosen& chosen) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? fs::path(".") : folder, ignored))
    if (chosen(entry.path())) fs::remove(entry.path(), ignored);
}

}  // namespace

/// @return false if another process has the lock @throws OutputError
bool RunLock::tryToTake(const fs::path& path) {
  for (;;) {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (descriptor < 0)
      throw OutputError(
          fmt::format("{}: cannot be opened as a lock: {}", path.string(), std::strerror(errno)));
    int failed = 0;
    do {
      failed = ::flock(descriptor, LOCK_EX | LOCK_NB) != 0 ? errno : 0;
    } while (failed == EINTR);
    if (failed == EWOULDBLOCK) {
      ::close(descriptor);
      return false;
    }
    if (failed != 0) log::detail(fmt::format("{}: the file system has no locks", path.string()));
    // The previous holder may have ended and removed the file since it was opened.
    if (failed == 0 && !isSameFile(descriptor, path)) {
      ::close(descriptor);
      continue;
    }
    path_ = path;
    descriptor_ = descriptor;
    return true;
  }
}

void RunLock::take(const fs::path& path, const fs::path& target, const char* kind, const char* advice) {
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!tryToTake(path)) {
    if (std::chrono::steady_clock::now() >= until) {
      std::error_code ignored;
      throw OutputError(fmt::format("{}: another packMesh is writing {}{}; wait until it has ended, or {}",
                                    fs::absolute(target, ignored).lexically_normal().string(), kind,
                                    holderIn(path), advice));
    }
    std::this_thread::sleep_for(pause);
  }
  tellHolder(descriptor_);
}

void RunLock::makeFolder(const fs::path& folder) {
  std::vector<fs::path> missing;  // innermost first
  std::error_code error;
  for (fs::path one = folder; !one.empty() && !fs::exists(one, error); one = one.parent_path())
    if (one.has_filename()) missing.push_back(one);
  for (auto one = missing.rbegin(); one != missing.rend(); ++one) {
    if (!fs::create_directory(*one, error)) break;
    made_.push_back(*one);
  }
  std::error_code ignored;
  if (!folder.empty() && !fs::is_directory(folder, ignored))
    throw OutputError(fmt::format("{}: the folder cannot be created: {}", folder.string(), error.message()));
}

RunLock RunLock::ofFolder(const fs::path& folder) {
  RunLock lock;
  lock.makeFolder(folder);
  lock.take(folder / ".packMesh.lock", folder, "into this folder", "write into another one (--output-dir)");
  removeTemporary(folder, [](const fs::path& file) { return isAbandoned(file, "new"); });
  return lock;
}

RunLock RunLock::ofFile(const fs::path& file) {
  RunLock lock;
  lock.makeFolder(file.parent_path());
  lock.take(lockName(file), file, "it", "write another one (--state)");
  removeTemporary(file.parent_path(), [&](const fs::path& one) {
    return isTemporaryOf(one, file, "new") || isTemporaryOf(one, checkpointOf(file), "new");
  });
  return lock;
}

RunLock::RunLock(RunLock&& other) noexcept
    : path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      made_(std::exchange(other.made_, {})) {}

RunLock::~RunLock() {
  if (descriptor_ >= 0) {
    ::unlink(path_.c_str());  // while it is locked: no other process can hold a lock on a file without a name
    ::close(descriptor_);
  }
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) ::rmdir(folder->c_str());
}

namespace {

RealisationFigures realisationFigures(const Packing& packing) {
  return {packing.outcome != Outcome::outOfReach,
          packing.cellCount,
          packing.tally.redMesh / packing.problem->lumen.container->volume(),
          packing.certificate.minimumGap,
          packing.certificate.minimumWallGap,
          packing.statistics.effort(),
          packing.times.cpu,
          packing.times.wall};
}

/// Writes a packing that cannot be written as it was requested, to be written elsewhere later.
void rescue(const Packing& packing) {
  if (!saveAsCheckpoint(packing)) return;
  const std::string file = checkpointFile(packing.output).string();
  const bool isNoRestart = packing.deformed.has_value();
  log::warning(isNoRestart
                   ? fmt::format("The packing is saved in {0}: a state with all cells, {1}", file,
                                 named("start", file))
                   : fmt::format("The packing is saved in {0}; to write it elsewhere: packMesh --restart "
                                 "{0} --output-dir FOLDER",
                                 file));
}

/// Writes the cells with the state of the packing, if one is requested; if they do not fit together, the
/// cells alone, unless only the state has them all.
/// @param stateWritten false: the state is missing
std::vector<fs::path> writeCells(const Packing& packing, bool& stateWritten) {
  const OutputRequest& output = packing.output;
  stateWritten = true;
  try {
    return writeCellFiles(packing, output, packing.state.has_value());
  } catch (const std::runtime_error&) {
    const Failure failure = failureOfException();
    if (!packing.state || failure.code != ExitCode::cannotWrite) throw;
    stateWritten = false;
    if (packing.problem->hasDeformed()) {
      rescue(packing);
      throw;
    }
    log::warning(failure.message);
  }
  try {
    return writeCellFiles(packing, output, false);
  } catch (const std::runtime_error&) {
    rescue(packing);
    throw;
  }
}

/// Writes the cells and everything else that is requested, and prints the summary.
/// @return false if the state is missing
bool write(const Packing& packing) {
  bool stateWritten = false;
  const std::vector<fs::path> files = writeCells(packing, stateWritten);
  logSummary(packing);
  for (const fs::path& file : files) log::info(fmt::format("Wrote {}", file.string()));
  if (packing.state && stateWritten)
    log::info(fmt::format("Wrote {0} ({1} cells; load it by packmesh::loadParticles(hemocell, \"{0}\"))",
                          packing.output.stateFile->string(), packing.cellCount));
  warnOfCellFiles(packing, packing.output.folder);
  writeViews(packing);
  return stateWritten;
}

bool writes(const Request& request) {
  return !request.dryRun && !request.validate;
}

/// Prevents other runs from writing the same files until the end of this one. Held by the first rank.
struct Locks {
  std::optional<RunLock> folder, state;
};

/// From here on a signal does not end the run at once: there are files to remove.
Locks locksOf(const OutputRequest& output, const Communicator& ranks) {
  pollInterruption();
  Locks locks;
  onFirstRank(ranks, [&] {
    locks.folder.emplace(RunLock::ofFolder(output.folder));
    if (output.stateFile) locks.state.emplace(RunLock::ofFile(*output.stateFile));
  });
  return locks;
}

/// Tests in advance whether the folders are writable.
void requireWritableFolders(const Request& request, const OutputRequest& output, const Communicator& ranks) {
  onFirstRank(ranks, [&] {
    requireWritable(output.folder);
    if (output.reportFile) requireWritable(output.reportFile->parent_path());
    requireReplaceableState(request, output);
  });
}

ExitCode tellForecast(const Problem& problem, const Timer& timer) {
  const ForecastText forecast = forecastText(problem, problem.ranks.size());
  for (const std::string& line : forecast.lines) log::info(line);
  constexpr double worthTelling = 1.0;  // [s]
  if (const double cpu = timer.cpu(); cpu > worthTelling)
    log::info(fmt::format("In addition, the lumen takes about {} of CPU, as in this dry run",
                          durationText(std::round(cpu))));
  log::info("A dry run: nothing was packed or written");
  if (forecast.seconds) log::detail(fmt::format("Expected CPU time: {:.4g} s", *forecast.seconds));
  return forecast.impossible && !problem.request.bestEffort ? ExitCode::outOfReach : ExitCode::ok;
}

/// Packs and writes.
RunEnd packAndWrite(Session& session, const std::shared_ptr<const Problem>& problem,
                    const OutputRequest& output) {
  const Locks locks = locksOf(output, problem->ranks);
  std::optional<Packing> packing;
  try {
    packing = session.pack(problem, output);
  } catch (const AgreedFailure& failure) {
    log::error(failure.what());
    if (failure.code() == ExitCode::outOfReach && session.stateSaved())
      log::info(fmt::format("To continue with higher limits: packMesh --restart {}{}{}",
                            checkpointFile(output).string(), session.raise().empty() ? "" : " ",
                            session.raise()));
    return {failure.code(), {}};
  }
  if (!write(*packing)) {
    log::error(fmt::format("{}: the state could not be saved", output.stateFile->string()));
    return {ExitCode::cannotWrite, realisationFigures(*packing)};
  }
  if (output.stateFile)
    onFirstRank(problem->ranks,
                [&] { removeCheckpoint(problem->request, output, session.stateSavedOnce()); });
  return {ExitCode::ok, realisationFigures(*packing)};
}

RunEnd packOnce(const CompletedRequest& completed, const OutputRequest& output, const Communicator& ranks) {
  const Request& request = completed.request;
  Session session(writtenToFiles, {interrupted, {}}, ranks);
  requireWritableFolders(request, output, ranks);
  const std::shared_ptr<const Problem> problem = session.prepare(completed);
  onFirstRank(ranks, [&] { requireWritableOutputs(*problem, output, true); });
  if (request.validate) {
    log::info(
        fmt::format("{} is valid", problem->simulation ? problem->simulation->file.string() : "The command"));
    return {};
  }
  for (const std::string& line : headLines(*problem)) log::info(line);
  log::detail(fmt::format("Preparation: {:.3f} s CPU", session.timer().cpu()));
  if (!request.dryRun) {
    for (const std::string& line : reachLines(*problem, session.sampleOf(problem))) log::info(line);
    return packAndWrite(session, problem, output);
  }
  return {tellForecast(*problem, session.timer()), {}};
}

}  // namespace

ExitCode runPacking(const Request& asked, const Communicator& ranks) {
  CompletedRequest completed;
  OutputRequest output;
  together(ranks, [&] {
    completed = requestToPack(asked);
    output = outputsToPack(completed);
  });
  const Request& request = completed.request;
  if (request.realisations == 1 || !writes(request)) return packOnce(completed, output, ranks).code;
  OutputRequest folder = output;
  folder.stateFile.reset();  // each realisation has its own
  const Locks locks = locksOf(folder, ranks);
  return runRealisations(completed, output, ranks,
                         [&](const CompletedRequest& one, const OutputRequest& outputOfOne) {
                           return packOnce(one, outputOfOne, ranks);
                         });
}

namespace {

/// What is printed instead of packing or checking.
std::string documentText(const CommandLine& commandLine) {
  switch (commandLine.command) {
    case Command::help:
      return helpText(commandLine.asPackCells);
    case Command::version:
      return fmt::format("packMesh {} ({})\n", version(), gitHash());
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

}  // namespace

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

}  // namespace packmesh::hemocell
