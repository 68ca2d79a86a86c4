// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/ranks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <optional>
#include <string>

#include "hemocell_adapter/base/messages.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/launcher.h"
#include "packMesh/parallel/threads.h"

namespace packmesh::hemocell {

Failure failureOfException() {
  try {
    throw;
  } catch (const AgreedFailure& error) {
    return {error.code(), error.what()};
  } catch (const UsageError& error) {
    return {ExitCode::usage, error.what()};
  } catch (const InfeasibleError& error) {
    return {ExitCode::outOfReach, error.what()};
  } catch (const OutputError& error) {
    return {ExitCode::cannotWrite, error.what()};
  } catch (const InputError& error) {
    return {ExitCode::badInput, error.what()};
  } catch (const std::filesystem::filesystem_error& error) {
    const std::string file = error.path1().string();
    return {ExitCode::badInput, (file.empty() ? "a file" : file) + ": " + error.code().message()};
  } catch (const std::bad_alloc&) {
    return {ExitCode::badInput, "not enough memory for a problem of this size"};
  } catch (const std::exception& error) {
    return {ExitCode::internal, std::string("internal error, please report it: ") + error.what()};
  }
}

void endUnlessOfAll(const Failure& failure, Arrival& failures, const Communicator& ranks) {
  const double patience = 2.0 + 0.5 * ranks.rank();  // [s]
  if (ranks.alone() || failures.ofAll(patience)) return;
  log::setLevel(log::Level::normal);
  log::error(fmt::format("rank {}: {}", ranks.rank(), failure.message));
  ranks.abort(int(failure.code));
}

void together(const Communicator& ranks, const std::function<void()>& work) {
  std::optional<Failure> failure;
  try {
    work();
  } catch (...) {
    if (ranks.alone()) throw;
    failure = failureOfException();
  }
  const std::int64_t first = ranks.min(std::int64_t(failure ? ranks.rank() : ranks.size()));
  if (first == ranks.size() || ranks.alone()) return;
  Failure agreed;
  agreed.code = static_cast<ExitCode>(
      std::stoi(ranks.broadcast(failure ? std::to_string(int(failure->code)) : "", int(first))));
  agreed.message = ranks.broadcast(failure ? failure->message : "", int(first));
  throw AgreedFailure(agreed);
}

void onFirstRank(const Communicator& ranks, const std::function<void()>& work) {
  together(ranks, [&] {
    if (ranks.rank() == 0) work();
  });
}

void requireConnected() {
  const LaunchedTasks tasks = launchedTasks();
  if (!areConnected(tasks)) throw AgreedFailure({ExitCode::notConnected, notConnectedText(tasks)});
}

Threads makeThreads(std::optional<std::int64_t> requested, const Communicator& ranks) {
  const int cores = availableCores();
  std::int64_t threads = ranks.alone() ? cores : 1;
  if (requested) {
    threads = *requested;
  } else if (const auto number =
                 numberInEnvironment("OMP_NUM_THREADS", ',')) {  // "4,2": numbers of nested levels
    if (*number < 1 || *number > maxThreads)
      throw UsageError(
          fmt::format("the variable OMP_NUM_THREADS: expected an integer from 1 to {}, found '{}'",
                      maxThreads, std::getenv("OMP_NUM_THREADS")));
    threads = *number;
  } else if (const auto cpus = numberInEnvironment("SLURM_CPUS_PER_TASK"); cpus && *cpus > 0) {
    threads = std::min<std::int64_t>(*cpus, cores);
  }
  if (threads > 1 && !ranks.alone() && !mpiPermitsThreads()) {
    const char* why = "MPI was initialised for one thread per rank (MPI_THREAD_SINGLE)";
    if (requested)
      throw UsageError(fmt::format(
          "threads: {} requested, but {}; call MPI_Init_thread() with MPI_THREAD_FUNNELED, or use more ranks",
          threads, why));
    log::warning(fmt::format("{}: one thread instead of {}", why, threads));
    threads = 1;
  }
  return Threads(static_cast<int>(std::min<std::int64_t>(threads, std::max(16, 4 * cores))));
}

}  // namespace packmesh::hemocell
