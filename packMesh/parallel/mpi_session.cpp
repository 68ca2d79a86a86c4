// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/mpi_session.h"

#include <mpi.h>

namespace packmesh {

MpiSession::MpiSession() {
  int provided = 0;  // one thread at a time: SharedPages
  MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
}

MpiSession::~MpiSession() {
  MPI_Finalize();
}

}  // namespace packmesh
