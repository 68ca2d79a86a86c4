// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/node_memory.h"

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <exception>
#include <stdexcept>

namespace packmesh {
namespace {

/// Sets the bits that any node has on all of them. The first ranks of all nodes call.
void unite(std::uint64_t* words, std::size_t size, MPI_Comm firstRanks) {
  constexpr std::size_t atOnce = 1 << 20;  // MPI counts by int, and has a copy of what it reduces
  for (std::size_t from = 0; from < size; from += atOnce)
    MPI_Allreduce(MPI_IN_PLACE, words + from, static_cast<int>(std::min(atOnce, size - from)), MPI_UINT64_T,
                  MPI_BOR, firstRanks);
}

}  // namespace

struct NodeMemory::Window {
  MPI_Comm node = MPI_COMM_NULL;  ///< the ranks of this node
  MPI_Win win = MPI_WIN_NULL;

  Window(const Communicator& ranks, int ranksPerNode) {
    const MPI_Comm all = *static_cast<const MPI_Comm*>(ranks.mpi());
    MPI_Comm_split_type(all, MPI_COMM_TYPE_SHARED, ranks.rank(), MPI_INFO_NULL, &node);
    int rank = 0, size = 1;
    MPI_Comm_rank(node, &rank);
    MPI_Comm_size(node, &size);
    if (size <= ranksPerNode) return;
    MPI_Comm part;
    MPI_Comm_split(node, rank / ranksPerNode, rank, &part);
    MPI_Comm_free(&node);
    node = part;
  }
  ~Window() {
    // A rank that fails alone must not wait for the others here; its caller ends them.
    int ended = 0;
    MPI_Finalized(&ended);
    if (ended || std::uncaught_exceptions() > 0) return;
    if (win != MPI_WIN_NULL) MPI_Win_free(&win);
    MPI_Comm_free(&node);
  }

  bool first() const {
    int rank = 0;
    MPI_Comm_rank(node, &rank);
    return rank == 0;
  }

  /// Memory of `size` words; nullptr if there is too little.
  std::uint64_t* allocate(std::size_t size) {
    const MPI_Aint bytes = first() ? static_cast<MPI_Aint>(size * sizeof(std::uint64_t)) : 0;
    void* memory = nullptr;
    MPI_Comm_set_errhandler(node, MPI_ERRORS_RETURN);
    if (MPI_Win_allocate_shared(bytes, sizeof(std::uint64_t), MPI_INFO_NULL, node, &memory, &win) !=
        MPI_SUCCESS)
      return nullptr;
    MPI_Aint length = 0;
    int unit = 0;
    MPI_Win_shared_query(win, 0, &length, &unit, &memory);
    return static_cast<std::uint64_t*>(memory);
  }
};

NodeMemory::NodeMemory(const Communicator& ranks, std::size_t size, const Words& bits, int ranksPerNode) {
  if (ranks.alone()) {
    own_.assign(size, 0);
    for (const auto& [word, more] : bits) own_[word] |= more;
    words_ = own_.data();
    return;
  }
  window_ = std::make_unique<Window>(ranks, ranksPerNode);
  std::uint64_t* words = window_->allocate(size);
  if (ranks.any(!words))
    throw std::runtime_error(fmt::format(
        "the ranks of a node cannot share {} MB: see its limit of shared memory (/dev/shm, or TMPDIR)",
        size * sizeof(std::uint64_t) / 1000000));
  words_ = words;
  const bool first = window_->first();
  if (first) std::fill_n(words, size, 0);
  MPI_Win_fence(0, window_->win);
  for (const auto& [word, more] : bits) __atomic_fetch_or(words + word, more, __ATOMIC_RELAXED);
  MPI_Win_fence(0, window_->win);
  MPI_Comm firstRanks;
  MPI_Comm_split(*static_cast<const MPI_Comm*>(ranks.mpi()), first ? 0 : MPI_UNDEFINED, ranks.rank(),
                 &firstRanks);
  if (first) {
    unite(words, size, firstRanks);
    MPI_Comm_free(&firstRanks);
  }
  MPI_Win_fence(0, window_->win);
}

NodeMemory::~NodeMemory() = default;

}  // namespace packmesh
