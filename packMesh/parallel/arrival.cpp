// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/arrival.h"

#include <mpi.h>

#include <chrono>
#include <thread>

namespace packmesh {

struct Arrival::Impl {
  MPI_Comm comm = MPI_COMM_NULL;
};

Arrival::Arrival(const Communicator& ranks) {
  if (ranks.alone()) return;
  impl_ = std::make_unique<Impl>();
  MPI_Comm_dup(*static_cast<const MPI_Comm*>(ranks.mpi()), &impl_->comm);
}

Arrival::~Arrival() = default;

bool Arrival::ofAll(double seconds) {
  if (!impl_) return true;
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  MPI_Request request;
  MPI_Ibarrier(impl_->comm, &request);
  for (int arrived = 0;;) {
    MPI_Test(&request, &arrived, MPI_STATUS_IGNORE);
    if (arrived) return true;
    if (Clock::now() > end) return false;  // the program ends, so the request can remain pending
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace packmesh
