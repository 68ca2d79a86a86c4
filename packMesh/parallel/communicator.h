// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Communication between the ranks of one packing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace packmesh {

/// Messages sent by this rank since the program began, its shares of gathers among them; without reductions.
struct Traffic {
  std::int64_t messages = 0, bytes = 0;

  void add(std::int64_t length) {
    ++messages;
    bytes += length;
  }
};

/// Whether the bytes of a value are all of it, so that they can be sent: it owns nothing.
template <class T>
inline constexpr bool isSelfContained = std::is_trivially_destructible_v<T>;

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
  /// Sets the bits that are set on any rank. Pre: the size is the same on all ranks
  void unite(std::vector<std::uint64_t>& bits) const;
  bool any(bool value) const { return !alone() ? max(value ? 1.0 : 0.0) > 0.0 : value; }
  /// The text of rank `root`, on all ranks.
  std::string broadcast(const std::string& text, int root) const;

  /// The value of the first rank, on all ranks. While it works alone, the others sleep.
  template <class T>
  T fromFirst(T value) const {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!alone()) sendFromFirst(&value, sizeof(T));
    return value;
  }

  /// Sends to[r] to rank r, for every r. @return what each rank sent to this one, by rank
  template <class T>
  std::vector<std::vector<T>> exchange(std::vector<std::vector<T>> to) const {
    if (alone()) return to;
    std::vector<std::vector<T>> received;
    exchange(to, received);
    received[rank()] = std::move(to[rank()]);
    return received;
  }
  /// The same into `received`, whose memory is used again; nothing is sent to this rank itself.
  template <class T>
  void exchange(const std::vector<std::vector<T>>& to, std::vector<std::vector<T>>& received) const {
    static_assert(isSelfContained<T>);
    received.resize(to.size());
    if (alone()) return;
    std::vector<std::int64_t> lengths;
    for (const std::vector<T>& items : to) lengths.push_back(static_cast<std::int64_t>(items.size()));
    lengths = exchangedLengths(lengths);
    std::vector<Outgoing> out;
    std::vector<Incoming> in;
    for (std::size_t r = 0; r < to.size(); ++r) {
      if (static_cast<int>(r) != rank()) received[r].resize(static_cast<std::size_t>(lengths[r]));
      in.push_back({received[r].data(), received[r].size() * sizeof(T)});
      out.push_back({to[r].data(), to[r].size() * sizeof(T)});
    }
    exchangeParts(out, in);
  }

  /// The items of all ranks, in rank order.
  template <class T>
  std::vector<T> gatherAll(const std::vector<T>& mine) const {
    static_assert(isSelfContained<T>);
    std::vector<T> all;
    if (alone()) {
      all = mine;
      return all;
    }
    const std::vector<std::int64_t> lengths = gatheredLengths(static_cast<std::int64_t>(mine.size()));
    all.resize(static_cast<std::size_t>(std::accumulate(lengths.begin(), lengths.end(), std::int64_t(0))));
    gatherParts(mine.data(), lengths, all.data(), sizeof(T));
    return all;
  }

  /// Rows of any lengths, vectors or texts, as single items above.
  template <class Row>
  std::vector<std::vector<Row>> exchangeRows(std::vector<std::vector<Row>> to) const {
    if (alone()) return to;
    std::vector<std::vector<std::int64_t>> lengths;
    std::vector<std::vector<typename Row::value_type>> items;
    for (std::vector<Row>& rows : to) {
      lengths.push_back(lengthsOf(rows));
      items.push_back(joined(rows));
      rows = {};  // they may be large
    }
    lengths = exchange(std::move(lengths));
    items = exchange(std::move(items));
    std::vector<std::vector<Row>> received;
    for (std::size_t r = 0; r < items.size(); ++r) {
      received.push_back(divided<Row>(items[r], lengths[r]));
      items[r] = {};
    }
    return received;
  }
  template <class Row>
  std::vector<Row> gatherRows(const std::vector<Row>& mine) const {
    if (alone()) return mine;
    const std::vector<std::int64_t> lengths = gatherAll(lengthsOf(mine));
    return divided<Row>(gatherAll(joined(mine)), lengths);
  }

  /// On rank 0 calls visit(part) for the bytes of all ranks, in rank order, in parts; holds one that another
  /// rank has sent at a time. `visit` must not throw.
  void streamToFirst(const std::vector<std::string_view>& mine,
                     const std::function<void(std::string_view)>& visit) const;

  /// Longer data are sent in pieces of so many bytes: MPI counts by int. Tests set less; the same on all
  /// ranks.
  static std::size_t longestMessage;

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
  struct Outgoing {
    const void* data;
    std::size_t bytes;
  };
  struct Incoming {
    void* data;
    std::size_t bytes;
  };
  template <class Row>
  static std::vector<std::int64_t> lengthsOf(const std::vector<Row>& rows) {
    std::vector<std::int64_t> lengths;
    for (const Row& row : rows) lengths.push_back(static_cast<std::int64_t>(row.size()));
    return lengths;
  }
  template <class Row>
  static std::vector<typename Row::value_type> joined(const std::vector<Row>& rows) {
    std::size_t size = 0;
    for (const Row& row : rows) size += row.size();
    std::vector<typename Row::value_type> items;
    items.reserve(size);
    for (const Row& row : rows) items.insert(items.end(), row.begin(), row.end());
    return items;
  }
  template <class Row>
  static std::vector<Row> divided(const std::vector<typename Row::value_type>& items,
                                  const std::vector<std::int64_t>& lengths) {
    std::vector<Row> rows;
    rows.reserve(lengths.size());
    auto next = items.begin();
    for (const std::int64_t length : lengths) {
      rows.emplace_back(next, next + length);
      next += length;
    }
    return rows;
  }
  void sendFromFirst(void* data, std::size_t bytes) const;
  std::vector<std::int64_t> exchangedLengths(const std::vector<std::int64_t>& to) const;
  std::vector<std::int64_t> gatheredLengths(std::int64_t mine) const;
  /// Between this rank and all others. Pre: the lengths were exchanged.
  void exchangeParts(const std::vector<Outgoing>& to, const std::vector<Incoming>& from) const;
  /// @param lengths items of each rank
  void gatherParts(const void* mine, const std::vector<std::int64_t>& lengths, void* all,
                   std::size_t bytesPerItem) const;

  std::shared_ptr<Impl> impl_;
};

/// A barrier with time limit, on its own communicator, so that it does not interfere with other messages:
/// ranks outside it may be anywhere in the program.
class Arrival {
 public:
  /// Collective. Pre: an MpiSession exists unless `ranks` is alone
  explicit Arrival(const Communicator& ranks);
  ~Arrival();

  /// True if all ranks call this within `seconds` [s]: then no rank waits for another, and the program can
  /// end normally. Call once per program.
  bool ofAll(double seconds);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;  ///< nullptr if alone
};

/// Initialises MPI on construction and finalises it on destruction. One per program.
class MpiSession {
 public:
  MpiSession();
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
};

/// Whether a rank may have threads of which one uses MPI: whoever initialised MPI, this program or its host,
/// asked for that and was given it. Pre: MPI is initialised
bool mpiPermitsThreads();

}  // namespace packmesh
