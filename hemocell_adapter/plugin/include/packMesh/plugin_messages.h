// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the plug-in says, on one rank. Part of packMesh/hemocell.h. C++11.
#pragma once

#include <mpi.h>

#include <iostream>
#include <string>

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
}  // namespace packmesh
