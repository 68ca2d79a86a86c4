// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/mpi_session.h"

#include <mpi.h>

namespace packmesh {

MpiSession::MpiSession() {
  int provided = 0;  // see mpiPermitsThreads()
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
}

bool mpiPermitsThreads() {
  int provided = MPI_THREAD_SINGLE;
  MPI_Query_thread(&provided);
  return provided >= MPI_THREAD_FUNNELED;
}

MpiSession::~MpiSession() {
  MPI_Finalize();
}

}  // namespace packmesh
