// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Python as the caller of the library: its lock, signals, callbacks, log and exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/session/ladder.h"
#include "packMesh/parallel/communicator.h"

/// Messages of the library go to the logger "packmesh", which prints nothing unless Python tells it to.
void logToPython();

/// Exceptions of the library become those of packmesh.errors.
void registerErrors();

/// One call of the library, which runs without Python's lock, while other threads of Python go on. Calls of
/// several threads take turns, as the library has a log and HDF5 that are not made for more.
class Caller {
 public:
  /// @param progress called with stage, sweep, scale, worst overlap, unresolved pairs, time, time that is
  /// left [s] or None, and a line that tells all that; may be None
  explicit Caller(pybind11::object progress = pybind11::none()) : progress_(std::move(progress)) {}

  /// The messages of this rank alone are logged if it is the first.
  void listenTo(const packmesh::Communicator& ranks);

  /// Python's signals (KeyboardInterrupt) and what `progress` raises interrupt the packing.
  packmesh::hemocell::Hooks hooks();

  /// All ranks execute `work`, which interruptions end on all ranks. Afterwards, if Python raised something
  /// on some ranks alone, it is raised on the others that this is so, and what it was. All ranks call.
  template <class Work>
  auto onAllRanks(const packmesh::Communicator& ranks, Work&& work) {
    std::optional<decltype(work())> result;
    std::exception_ptr failure;
    try {
      result.emplace(work());
    } catch (const packmesh::hemocell::AgreedFailure&) {
      failure = std::current_exception();
    }
    tellOtherRanks(ranks, failure != nullptr);
    if (failure) std::rethrow_exception(failure);
    return std::move(*result);
  }

  /// @throws what `work` throws, but for what Python raised meanwhile
  template <class Work>
  auto run(Work&& work) {
    const pybind11::gil_scoped_release unlocked;
    const Turn turn;
    begin();
    using Result = decltype(work());
    std::optional<std::conditional_t<std::is_void_v<Result>, char, Result>> result;
    try {
      if constexpr (std::is_void_v<Result>)
        work();
      else
        result.emplace(work());
    } catch (...) {
      rethrowRaised();
      throw;
    }
    rethrowRaised();
    if constexpr (!std::is_void_v<Result>) return std::move(*result);
  }

 private:
  /// Of one thread at a time. A forked process has no other threads: nobody's turn goes on there.
  class Turn {
   public:
    /// Waits. @throws pybind11::error_already_set if a signal ends that
    Turn();
    ~Turn();
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    std::recursive_timed_mutex* const turns_;
  };

  static void begin();
  static void rethrowRaised();
  static void tellOtherRanks(const packmesh::Communicator& ranks, bool failed);
  bool interrupted();
  void tell(const packmesh::Progress& progress, packmesh::hemocell::ProgressLog& log);

  pybind11::object progress_;
  using Clock = std::chrono::steady_clock;
  Clock::time_point polled_ = Clock::now();
  std::optional<Clock::time_point> told_;
};
