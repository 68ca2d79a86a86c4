// SPDX-License-Identifier: AGPL-3.0-or-later
// Tests that run on several ranks: started by mpirun, every rank runs all of them in the same order.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "packMesh/parallel/communicator.h"

int main(int argc, char** argv) {
  const packmesh::MpiSession mpi;
  const packmesh::Communicator ranks = packmesh::Communicator::world();
  const int failed = Catch::Session().run(argc, argv);
  return ranks.sum(failed) > 0 ? 1 : 0;
}
