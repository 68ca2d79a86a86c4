// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/shared_pages.h"

#include <mpi.h>

#include <algorithm>
#include <exception>
#include <mutex>

namespace packmesh {

struct SharedPages::Window {
  MPI_Win win;
};

int SharedPages::ownerOf(std::int64_t page, std::int64_t pages, int ranks) {
  const std::int64_t share = (pages + ranks - 1) / ranks;
  return static_cast<int>(page / share);
}

std::int64_t SharedPages::firstOf(int rank, std::int64_t pages, int ranks) {
  const std::int64_t share = (pages + ranks - 1) / ranks;
  return std::min(rank * share, pages);
}

SharedPages::SharedPages(const Communicator& ranks, std::int64_t pages, int words,
                         std::vector<std::uint64_t> own)
    : ranks_(ranks), pages_(pages), words_(words), own_(std::move(own)) {
  if (ranks_.alone()) return;
  window_ = std::make_unique<Window>();
  MPI_Win_create(own_.data(), static_cast<MPI_Aint>(own_.size() * sizeof(std::uint64_t)),
                 sizeof(std::uint64_t), MPI_INFO_NULL, *static_cast<const MPI_Comm*>(ranks_.mpi()),
                 &window_->win);
  MPI_Win_lock_all(MPI_MODE_NOCHECK, window_->win);
}

SharedPages::~SharedPages() {
  // A rank that fails alone must not wait for the others here; its caller ends them.
  if (!window_ || std::uncaught_exceptions() > 0) return;
  MPI_Win_unlock_all(window_->win);
  MPI_Win_free(&window_->win);
}

void SharedPages::read(std::int64_t page, std::uint64_t* words) const {
  const int owner = ownerOf(page, pages_, ranks_.size());
  const std::int64_t at = (page - firstOf(owner, pages_, ranks_.size())) * words_;
  if (owner == ranks_.rank()) {
    std::copy_n(&own_[at], words_, words);
    return;
  }
  static std::mutex one;  // of several threads uses MPI at a time
  const std::lock_guard lock(one);
  MPI_Get(words, words_, MPI_UINT64_T, owner, at, words_, MPI_UINT64_T, window_->win);
  MPI_Win_flush(owner, window_->win);
}

}  // namespace packmesh
