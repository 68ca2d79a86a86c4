// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Data that is distributed over the ranks, and that each rank reads wherever it needs it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// Pages of equal size, in equal shares of consecutive pages on the ranks. Any rank can read any page without
/// the owner taking part (one-sided communication); its contents do not change. Threads can share it
/// (MPI_THREAD_SERIALIZED).
class SharedPages {
 public:
  /// All ranks call. @param own this rank's share, in order. @param words of a page
  SharedPages(const Communicator& ranks, std::int64_t pages, int words, std::vector<std::uint64_t> own);
  /// All ranks call, unless an exception ends them.
  ~SharedPages();
  SharedPages(const SharedPages&) = delete;
  SharedPages& operator=(const SharedPages&) = delete;

  /// Copies a page.
  void read(std::int64_t page, std::uint64_t* words) const;

  /// The rank that owns a page, and the first page of a rank; of `ranks` ranks.
  static int ownerOf(std::int64_t page, std::int64_t pages, int ranks);
  static std::int64_t firstOf(int rank, std::int64_t pages, int ranks);

 private:
  struct Window;
  Communicator ranks_;
  std::int64_t pages_;
  int words_;
  std::vector<std::uint64_t> own_;
  std::unique_ptr<Window> window_;
};

}  // namespace packmesh
