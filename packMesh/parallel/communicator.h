// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The ranks that work on one packing together, and how they talk.
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

/// What this rank has sent since the program began.
struct Traffic {
  std::int64_t messages = 0, bytes = 0;
};

/// A group of MPI ranks, or one rank alone without MPI. Copies are of the same group.
///
/// Every function but rank(), size(), alone(), traffic() and abort() must be called by all ranks of the group
/// in the same order. What is reduced is exact (integers, maxima): results never depend on the number of
/// ranks.
class Communicator {
 public:
  /// One rank; MPI need not be there.
  Communicator() = default;
  /// All ranks of the program. Pre: an MpiSession lives.
  static Communicator world();

  int rank() const;
  int size() const;
  bool alone() const { return impl_ == nullptr; }

  std::int64_t sum(std::int64_t value) const;
  void sum(std::vector<std::int64_t>& values) const;
  double max(double value) const;
  double min(double value) const;
  std::int64_t min(std::int64_t value) const;
  /// The sums of the one and the maxima of the other, in one message. Pre: as many of each on all ranks
  void sumAndMax(std::vector<std::int64_t>& sums, std::vector<double>& maxima) const;
  bool any(bool value) const { return !alone() ? max(value ? 1.0 : 0.0) > 0.0 : value; }
  /// The text of rank `root`.
  std::string broadcast(const std::string& text, int root) const;

  /// Sends to[r] to every rank r. @return what each rank had for this one, by rank
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

  /// What all ranks have, in the order of the ranks.
  template <class T>
  std::vector<T> gatherAll(const std::vector<T>& mine) const {
    if (alone()) return mine;
    std::vector<T> all;
    for (const std::vector<T>& items : exchange(std::vector<std::vector<T>>(size(), mine)))
      all.insert(all.end(), items.begin(), items.end());
    return all;
  }

  /// On rank 0 calls visit(items) for what every rank has, in the order of the ranks; holds that of one rank
  /// at a time. `visit` must not throw.
  template <class T, class Visit>
  void visitInOrder(const std::vector<T>& mine, Visit&& visit) const {
    if (rank() == 0) visit(mine);
    for (int r = 1; r < size(); ++r) {
      const Bytes bytes = toFirstRank(r, rank() == r ? bytesOf(mine) : Bytes());
      if (rank() == 0) visit(itemsOf<T>(bytes));
    }
  }

  using Bytes = std::vector<std::byte>;
  /// A rank to talk to again and again.
  struct Peer {
    int rank = 0;
    Bytes send;
    Bytes received;  ///< as large as the longest message may be; the message is its first `length` bytes
    std::size_t length = 0;
  };
  /// Begins to send every peer what is in `send`, and to receive theirs. Collective among ranks that are each
  /// other's peers; one at a time: endSwap() and awaitSent() come before the next.
  void beginSwap(std::vector<Peer>& peers) const;
  /// Waits for what peers sent in their beginSwap(). Pre: the same peers
  void endSwap(std::vector<Peer>& peers) const;
  /// Waits until what was sent has left `send`.
  void awaitSent() const;

  /// For libraries that talk by themselves (HDF5): points to an MPI_Comm; nullptr when alone.
  const void* mpi() const;

  /// What this rank has sent.
  const Traffic& traffic() const;

  /// Ends all ranks at once. For errors that other ranks cannot know of.
  [[noreturn]] void abort(int exitCode) const;

 private:
  struct Impl;
  explicit Communicator(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}
  std::vector<Bytes> exchangeBytes(std::vector<Bytes> to) const;
  /// What rank `from` has, on rank 0.
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
