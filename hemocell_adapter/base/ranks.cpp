// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/ranks.h"

#include <cstdlib>
#include <filesystem>
#include <new>
#include <optional>

#include "packMesh/parallel/cores.h"

namespace packmesh::hemocell {

Failure failureOfException() {
  try {
    throw;
  } catch (const AgreedFailure& error) {
    return {error.code(), error.what()};
  } catch (const UsageError& error) {
    return {ExitCode::usage, error.what()};
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

Threads teamOf(std::optional<std::int64_t> requested, const Communicator& ranks) {
  if (requested) return Threads(static_cast<int>(*requested));
  // A list, "4,2", has the numbers of nested levels.
  if (const char* text = std::getenv("OMP_NUM_THREADS"))
    if (const int threads = std::atoi(text); threads > 0) return Threads(threads);
  return Threads(ranks.alone() ? availableCores() : 1);
}

}  // namespace packmesh::hemocell
