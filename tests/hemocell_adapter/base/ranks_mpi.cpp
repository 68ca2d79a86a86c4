// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/ranks.h"

#include <mpi.h>

#include <cstdlib>

#include "hemocell_adapter/base/messages.h"
#include "packMesh/core/error.h"
#include "packMesh/parallel/communicator.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;

namespace {
int provided = -1;  ///< what MPI is to provide; negative: what it does
}

/// Instead of MPI's own, by its profiling interface.
extern "C" int MPI_Query_thread(int* level) {
  const int result = PMPI_Query_thread(level);
  if (provided >= 0) *level = provided;
  return result;
}

TEST_CASE("Ranks have one thread where MPI was initialised for one", "[mpi]") {
  const Communicator ranks = Communicator::world();
  const log::Level level = log::level();
  log::setLevel(log::Level::silent);
  for (const int permitted : {MPI_THREAD_SERIALIZED, MPI_THREAD_FUNNELED, MPI_THREAD_SINGLE}) {
    provided = permitted;
    const bool several = permitted != MPI_THREAD_SINGLE;
    CHECK(mpiPermitsThreads() == several);
    CHECK(makeThreads(1, ranks).count() == 1);
    if (several || ranks.alone()) {
      CHECK(makeThreads(3, ranks).count() == 3);
      continue;
    }
    CHECK_THROWS_AS(makeThreads(3, ranks), UsageError);
    CHECK_THROWS_WITH(makeThreads(3, ranks), Contains("MPI_Init_thread") && Contains("3"));
    setenv("OMP_NUM_THREADS", "4", 1);
    CHECK(makeThreads({}, ranks).count() == 1);
    unsetenv("OMP_NUM_THREADS");
  }
  provided = -1;
  log::setLevel(level);
  CHECK(mpiPermitsThreads());
}
