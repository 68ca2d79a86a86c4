// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Communication between the ranks of one packing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace packmesh {

/// Messages sent by this rank since the program began.
struct Traffic {
  std::int64_t messages = 0, bytes = 0;
};

/// A group of MPI ranks, or a single rank without MPI. Copies refer to the same group.
///
/// All functions except rank(), size(), alone(), traffic() and abort() are collective: all ranks of the group
/// call them in the same order. Reductions are exact (integers, maxima), so results do not depend on the
/// number of ranks.
class Communicator {
 public:
  /// A single rank; does not need MPI.
  Communicator() = default;
  /// All ranks of the program. Pre: an MpiSession exists.
  static Communicator world();
  /// A copy of the communicator of a program that uses MPI itself. Its ranks all call.
  /// @param mpi pointer to its MPI_Comm
  static Communicator copyOf(const void* mpi);

  int rank() const;
  int size() const;
  bool alone() const { return impl_ == nullptr; }

  std::int64_t sum(std::int64_t value) const;
  void sum(std::vector<std::int64_t>& values) const;
  double max(double value) const;
  double min(double value) const;
  std::int64_t min(std::int64_t value) const;
  /// Sums over the ranks before this one. Pre: the size is the same on all ranks
  std::vector<std::int64_t> sumBefore(const std::vector<std::int64_t>& values) const;
  /// Sums and maxima over all ranks, in one message. Pre: the sizes are the same on all ranks
  void sumAndMax(std::vector<std::int64_t>& sums, std::vector<double>& maxima) const;
  bool any(bool value) const { return !alone() ? max(value ? 1.0 : 0.0) > 0.0 : value; }
  /// The text of rank `root`, on all ranks.
  std::string broadcast(const std::string& text, int root) const;

  /// Sends to[r] to rank r, for every r. @return what each rank sent to this one, by rank
  template <class T>
  std::vector<std::vector<T>> exchange(const std::vector<std::vector<T>>& to) const {
    std::vector<Bytes> send;
    send.reserve(to.size());
    for (const std::vector<T>& items : to) send.push_back(bytesOf(items));
    std::vector<std::vector<T>> received;
    received.reserve(to.size());
    for (const Bytes& bytes : exchangeBytes(std::move(send))) received.push_back(itemsOf<T>(bytes));
    return received;
  }

  /// The items of all ranks, in rank order.
  template <class T>
  std::vector<T> gatherAll(const std::vector<T>& mine) const {
    if (alone()) return mine;
    std::vector<T> all;
    for (const std::vector<T>& items : exchange(std::vector<std::vector<T>>(size(), mine)))
      all.insert(all.end(), items.begin(), items.end());
    return all;
  }

  /// On rank 0 calls visit(items) for the items of each rank, in rank order; holds those of one rank at a
  /// time. `visit` must not throw.
  template <class T, class Visit>
  void visitInOrder(const std::vector<T>& mine, Visit&& visit) const {
    if (rank() == 0) visit(mine);
    for (int r = 1; r < size(); ++r) {
      const Bytes bytes = toFirstRank(r, rank() == r ? bytesOf(mine) : Bytes());
      if (rank() == 0) visit(itemsOf<T>(bytes));
    }
  }

  using Bytes = std::vector<std::byte>;
  /// A rank with which messages are exchanged repeatedly.
  struct Peer {
    int rank = 0;
    Bytes send;
    Bytes received;  ///< as large as the longest message; the message is the first `length` bytes
    std::size_t length = 0;
  };
  /// Begins to send `send` to every peer and to receive the peers' messages. Collective among mutual peers.
  /// Call endSwap() and awaitSent() before the next beginSwap().
  void beginSwap(std::vector<Peer>& peers) const;
  /// Waits for the messages that the peers sent in their beginSwap(). Pre: the same peers
  void endSwap(std::vector<Peer>& peers) const;
  /// Waits until `send` can be reused.
  void awaitSent() const;

  /// Pointer to the MPI_Comm for libraries that use MPI themselves (HDF5); nullptr if alone.
  const void* mpi() const;

  /// Messages sent by this rank.
  const Traffic& traffic() const;

  /// Ends all ranks immediately. For errors that the other ranks cannot detect.
  [[noreturn]] void abort(int exitCode) const;

 private:
  struct Impl;
  explicit Communicator(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  std::vector<Bytes> exchangeBytes(std::vector<Bytes> to) const;
  /// The bytes of rank `from`, on rank 0.
  Bytes toFirstRank(int from, const Bytes& bytes) const;

  template <class T>
  static Bytes bytesOf(const std::vector<T>& items) {
    static_assert(std::is_trivially_copyable_v<T>);
    Bytes bytes(items.size() * sizeof(T));
    if (!items.empty()) std::memcpy(bytes.data(), items.data(), bytes.size());
    return bytes;
  }
  template <class T>
  static std::vector<T> itemsOf(const Bytes& bytes) {
    std::vector<T> items(bytes.size() / sizeof(T));
    if (!items.empty()) std::memcpy(items.data(), bytes.data(), bytes.size());
    return items;
  }

  std::shared_ptr<Impl> impl_;
};

}  // namespace packmesh
