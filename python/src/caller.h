// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Python as the caller of the library: its lock, signals, callbacks, log and exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>

#include "hemocell_adapter/app/packing_attempts.h"
#include "packMesh/parallel/communicator.h"

/// Messages of the library go to the logger "packmesh", which prints nothing unless Python tells it to.
void logToPython();

/// Exceptions of the library become those of packmesh.errors.
void registerErrors();

/// One call of the library, which runs without Python's lock, while other threads of Python go on. Calls of
/// several threads take turns, as the library has a log and HDF5 that are not made for more.
class Caller {
 public:
  /// @param progress called with stage, sweep, scale, worst overlap and unresolved pairs; may be None
  explicit Caller(pybind11::object progress = pybind11::none()) : progress_(std::move(progress)) {}

  /// The messages of this rank alone are logged if it is the first.
  void listenTo(const packmesh::Communicator& ranks);

  /// Python's signals (KeyboardInterrupt) and what `progress` raises interrupt the packing.
  packmesh::hemocell::RunHooks hooks();

  /// @throws what `work` throws, but for what Python raised meanwhile
  template <class Work>
  auto run(Work&& work) {
    const pybind11::gil_scoped_release unlocked;
    const std::lock_guard<std::recursive_mutex> turn(mutex());
    begin();
    if constexpr (std::is_void_v<decltype(work())>) {
      try {
        work();
      } catch (...) {
        rethrowRaised();
        throw;
      }
      rethrowRaised();
    } else {
      std::optional<decltype(work())> result;
      try {
        result.emplace(work());
      } catch (...) {
        rethrowRaised();
        throw;
      }
      rethrowRaised();
      return std::move(*result);
    }
  }

 private:
  static std::recursive_mutex& mutex();
  static void begin();
  static void rethrowRaised();
  bool interrupted();
  void tell(const packmesh::Progress& progress);

  pybind11::object progress_;
  using Clock = std::chrono::steady_clock;
  Clock::time_point polled_ = Clock::now();
  std::optional<Clock::time_point> told_;
};
