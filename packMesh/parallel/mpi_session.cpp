// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/mpi_session.h"

#include <mpi.h>

namespace packmesh {

MpiSession::MpiSession() {
  MPI_Init(nullptr, nullptr);
}

MpiSession::~MpiSession() {
  MPI_Finalize();
}

}  // namespace packmesh
