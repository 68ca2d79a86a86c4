// SPDX-License-Identifier: AGPL-3.0-or-later
// Tests that run on several ranks: started by mpirun, every rank runs all of them in the same order.
#include "packMesh/parallel/communicator.h"
#include "tests/support/catch_session.h"

int main(int argc, char** argv) {
  const packmesh::MpiSession mpi;
  const packmesh::Communicator ranks = packmesh::Communicator::world();
  return ranks.sum(packmesh::test::runTests(argc, argv)) > 0 ? 1 : 0;
}
