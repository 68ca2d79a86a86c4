// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How the plug-in stops. Part of packMesh/hemocell.h. C++11.
#pragma once

#include <mpi.h>

#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <string>

#include "packMesh/hemocell_system.h"

namespace packmesh {
namespace plugin {

inline void warn(const std::string& message) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) std::cerr << "(packMesh) (Warning) " << message << std::endl;
}

/// The message of the lowest rank that has one, on all ranks. Collective.
inline std::string agreed(std::string message) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  int from = message.empty() ? ranks : rank;
  MPI_Allreduce(MPI_IN_PLACE, &from, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (from == ranks) return std::string();
  int size = static_cast<int>(message.size());
  MPI_Bcast(&size, 1, MPI_INT, from, MPI_COMM_WORLD);
  message.resize(size);
  MPI_Bcast(&message[0], size, MPI_CHAR, from, MPI_COMM_WORLD);
  return message;
}

}  // namespace plugin

/// Why a function of the plug-in failed; thrown on all ranks, if throwFailures() was called.
class Failure : public std::runtime_error {
 public:
  Failure(int exitCode, const std::string& message) : std::runtime_error(message), exitCode_(exitCode) {}
  /// Exit code of the program packMesh for this failure; 70: HemoCell did not keep every cell.
  int exitCode() const { return exitCode_; }

 private:
  int exitCode_;
};

namespace plugin {

inline bool& failuresAreThrown() {
  static bool thrown = false;
  return thrown;
}

/// All ranks call, with the same message.
[[noreturn]] inline void stop(int code, const std::string& message) {
  if (failuresAreThrown()) throw Failure(code, message);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) std::cerr << "(packMesh) (Error) " << message << std::endl;
  MPI_Barrier(MPI_COMM_WORLD);  // else mpirun ends rank 0 before it has written
  std::exit(code);
}

/// Stops on all ranks, with the message of the lowest rank that failed. All ranks call.
inline void stopIfFailed(const Filling& filling) {
  int code = filling.exitCode;
  MPI_Allreduce(MPI_IN_PLACE, &code, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  const std::string message = agreed(filling.message);
  if (code != 0) stop(code, message);
}

}  // namespace plugin

/// From now on failures are thrown as Failure, on all ranks, for the case to catch. Otherwise the plug-in
/// prints the message and ends the program by std::exit(). All ranks call. (If a rank fails alone,
/// MPI_Abort() ends the others in either case.)
inline void throwFailures(bool thrown = true) {
  plugin::failuresAreThrown() = thrown;
}

}  // namespace packmesh
