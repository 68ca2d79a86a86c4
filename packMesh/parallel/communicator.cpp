// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/communicator.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <thread>

namespace packmesh {

struct Communicator::Impl {
  MPI_Comm comm;
  int rank = 0, size = 1;
  Traffic traffic;
  std::vector<MPI_Request> receives, sends;  ///< of the current swap

  explicit Impl(MPI_Comm group) : comm(group) {
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &size);
  }

  template <class T>
  T reduced(T value, MPI_Datatype type, MPI_Op op) const {
    T result;
    MPI_Allreduce(&value, &result, 1, type, op, comm);
    return result;
  }
};

namespace {

int count(std::size_t bytes) {
  if (bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::length_error("a message between ranks is longer than MPI can send: use more ranks");
  return static_cast<int>(bytes);
}

/// Calls piece(offset, length) for consecutive pieces of `bytes` bytes that MPI can count.
template <class Piece>
void forEachPiece(std::size_t bytes, const Piece& piece) {
  for (std::size_t at = 0; at < bytes; at += Communicator::longestMessage)
    piece(at, static_cast<int>(std::min(Communicator::longestMessage, bytes - at)));
}

/// Reduction operation of sumAndMax(): the first word is the number of sums, which follow it; then the
/// maxima.
void addAndCompare(void* in, void* inOut, int* length, MPI_Datatype* type) {
  int bytes = 0;
  MPI_Type_size(*type, &bytes);
  const int words = bytes / static_cast<int>(sizeof(std::int64_t));
  const auto* from = static_cast<const std::int64_t*>(in);
  auto* to = static_cast<std::int64_t*>(inOut);
  for (int i = 0; i < *length; ++i, from += words, to += words) {
    for (int k = 1; k <= from[0]; ++k) to[k] += from[k];
    for (int k = static_cast<int>(from[0]) + 1; k < words; ++k) {
      double a, b;
      std::memcpy(&a, from + k, sizeof a);
      std::memcpy(&b, to + k, sizeof b);
      if (a > b) to[k] = from[k];
    }
  }
}

}  // namespace

Communicator Communicator::world() {
  auto impl = std::make_shared<Impl>(MPI_COMM_WORLD);
  return impl->size > 1 ? Communicator(std::move(impl)) : Communicator();
}

Communicator Communicator::copyOf(const void* mpi) {
  int size = 1;
  MPI_Comm_size(*static_cast<const MPI_Comm*>(mpi), &size);
  if (size == 1) return {};
  MPI_Comm copy;
  MPI_Comm_dup(*static_cast<const MPI_Comm*>(mpi), &copy);
  const auto release = [](Impl* impl) {
    int ended = 0;  // by a program that uses MPI itself, before its last objects end
    MPI_Finalized(&ended);
    if (!ended) MPI_Comm_free(&impl->comm);
    delete impl;
  };
  return Communicator(std::shared_ptr<Impl>(new Impl(copy), release));
}

int Communicator::rank() const {
  return impl_ ? impl_->rank : 0;
}
int Communicator::size() const {
  return impl_ ? impl_->size : 1;
}

const void* Communicator::mpi() const {
  return impl_ ? &impl_->comm : nullptr;
}

std::int64_t Communicator::sum(std::int64_t value) const {
  return impl_ ? impl_->reduced(value, MPI_INT64_T, MPI_SUM) : value;
}
void Communicator::sum(std::vector<std::int64_t>& values) const {
  if (impl_)
    MPI_Allreduce(MPI_IN_PLACE, values.data(), count(values.size()), MPI_INT64_T, MPI_SUM, impl_->comm);
}
double Communicator::max(double value) const {
  return impl_ ? impl_->reduced(value, MPI_DOUBLE, MPI_MAX) : value;
}
double Communicator::min(double value) const {
  return impl_ ? impl_->reduced(value, MPI_DOUBLE, MPI_MIN) : value;
}
std::int64_t Communicator::min(std::int64_t value) const {
  return impl_ ? impl_->reduced(value, MPI_INT64_T, MPI_MIN) : value;
}

std::vector<std::int64_t> Communicator::sumBefore(const std::vector<std::int64_t>& values) const {
  const std::vector<std::int64_t> all = gatherAll(values);
  std::vector<std::int64_t> sums(values.size(), 0);
  for (std::size_t i = 0; i < rank() * values.size(); ++i) sums[i % values.size()] += all[i];
  return sums;
}

void Communicator::sumAndMax(std::vector<std::int64_t>& sums, std::vector<double>& maxima) const {
  if (!impl_) return;
  static_assert(sizeof(double) == sizeof(std::int64_t));
  std::vector<std::int64_t> words(1 + sums.size() + maxima.size());
  words[0] = static_cast<std::int64_t>(sums.size());
  std::copy(sums.begin(), sums.end(), words.begin() + 1);
  std::memcpy(words.data() + 1 + sums.size(), maxima.data(), maxima.size() * sizeof(double));
  MPI_Datatype type;
  MPI_Op operation;
  MPI_Type_contiguous(count(words.size()), MPI_INT64_T, &type);
  MPI_Type_commit(&type);
  MPI_Op_create(addAndCompare, 1, &operation);
  MPI_Allreduce(MPI_IN_PLACE, words.data(), 1, type, operation, impl_->comm);
  MPI_Op_free(&operation);
  MPI_Type_free(&type);
  std::copy_n(words.begin() + 1, sums.size(), sums.begin());
  std::memcpy(maxima.data(), words.data() + 1 + sums.size(), maxima.size() * sizeof(double));
}

void Communicator::unite(std::vector<std::uint64_t>& bits) const {
  constexpr std::size_t atOnce = 1 << 20;  // MPI has a copy of what it reduces
  for (std::size_t from = 0; impl_ && from < bits.size(); from += atOnce)
    MPI_Allreduce(MPI_IN_PLACE, bits.data() + from, count(std::min(atOnce, bits.size() - from)), MPI_UINT64_T,
                  MPI_BOR, impl_->comm);
}

std::string Communicator::broadcast(const std::string& text, int root) const {
  if (!impl_) return text;
  std::int64_t length = static_cast<std::int64_t>(text.size());
  MPI_Bcast(&length, 1, MPI_INT64_T, root, impl_->comm);
  std::string result = impl_->rank == root ? text : std::string(length, '\0');
  MPI_Bcast(result.data(), count(result.size()), MPI_CHAR, root, impl_->comm);
  return result;
}

/// MPI waits for messages by asking for them all the time.
void Communicator::sendFromFirst(void* data, std::size_t bytes) const {
  constexpr int tag = 4;
  if (impl_->rank == 0) {
    for (int r = 1; r < impl_->size; ++r) {
      MPI_Send(data, count(bytes), MPI_BYTE, r, tag, impl_->comm);
      impl_->traffic.add(static_cast<std::int64_t>(bytes));
    }
    return;
  }
  for (int sent = 0;;) {
    MPI_Iprobe(0, tag, impl_->comm, &sent, MPI_STATUS_IGNORE);
    if (sent) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  MPI_Recv(data, count(bytes), MPI_BYTE, 0, tag, impl_->comm, MPI_STATUS_IGNORE);
}

std::size_t Communicator::longestMessage = std::size_t(1) << 30;

std::vector<std::int64_t> Communicator::exchangedLengths(const std::vector<std::int64_t>& to) const {
  std::vector<std::int64_t> from(to.size());
  MPI_Alltoall(to.data(), 1, MPI_INT64_T, from.data(), 1, MPI_INT64_T, impl_->comm);
  return from;
}

std::vector<std::int64_t> Communicator::gatheredLengths(std::int64_t mine) const {
  std::vector<std::int64_t> all(impl_->size);
  MPI_Allgather(&mine, 1, MPI_INT64_T, all.data(), 1, MPI_INT64_T, impl_->comm);
  return all;
}

void Communicator::exchangeParts(const std::vector<Outgoing>& to, const std::vector<Incoming>& from) const {
  constexpr int tag = 1;
  std::vector<MPI_Request> requests;
  for (int r = 0; r < impl_->size; ++r) {
    if (r == impl_->rank) continue;
    forEachPiece(from[r].bytes, [&](std::size_t at, int length) {
      requests.emplace_back();
      MPI_Irecv(static_cast<std::byte*>(from[r].data) + at, length, MPI_BYTE, r, tag, impl_->comm,
                &requests.back());
    });
  }
  for (int r = 0; r < impl_->size; ++r) {
    if (r == impl_->rank) continue;
    forEachPiece(to[r].bytes, [&](std::size_t at, int length) {
      requests.emplace_back();
      MPI_Isend(static_cast<const std::byte*>(to[r].data) + at, length, MPI_BYTE, r, tag, impl_->comm,
                &requests.back());
      impl_->traffic.add(length);
    });
  }
  MPI_Waitall(count(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

void Communicator::gatherParts(const void* mine, const std::vector<std::int64_t>& lengths, void* all,
                               std::size_t bytesPerItem) const {
  std::vector<std::size_t> starts = {0};
  for (const std::int64_t length : lengths)
    starts.push_back(starts.back() + static_cast<std::size_t>(length) * bytesPerItem);
  auto* const out = static_cast<std::byte*>(all);
  const std::size_t own = starts[impl_->rank + 1] - starts[impl_->rank];
  if (starts.back() <= longestMessage) {
    const std::vector<int> offsets(starts.begin(), starts.end() - 1);
    std::vector<int> counts;
    for (const std::int64_t length : lengths) counts.push_back(static_cast<int>(length * bytesPerItem));
    MPI_Allgatherv(mine, count(own), MPI_BYTE, out, counts.data(), offsets.data(), MPI_BYTE, impl_->comm);
  } else {
    if (own > 0) std::memcpy(out + starts[impl_->rank], mine, own);
    for (int r = 0; r < impl_->size; ++r)
      forEachPiece(starts[r + 1] - starts[r], [&](std::size_t at, int length) {
        MPI_Bcast(out + starts[r] + at, length, MPI_BYTE, r, impl_->comm);
      });
  }
  if (own > 0) impl_->traffic.add(static_cast<std::int64_t>(own));
}

void Communicator::streamToFirst(const std::vector<std::string_view>& mine,
                                 const std::function<void(std::string_view)>& visit) const {
  constexpr int tag = 3;
  if (rank() == 0)
    for (const std::string_view piece : mine) visit(piece);
  if (alone()) return;
  std::int64_t length = 0;
  for (const std::string_view piece : mine) length += static_cast<std::int64_t>(piece.size());
  const std::vector<std::int64_t> lengths = gatheredLengths(length);
  const std::size_t longest = std::min(longestMessage, std::size_t{1} << 24);
  for (std::string_view piece : mine)
    for (; rank() > 0 && !piece.empty(); piece.remove_prefix(std::min(longest, piece.size()))) {
      const int part = count(std::min(longest, piece.size()));
      MPI_Send(piece.data(), part, MPI_BYTE, 0, tag, impl_->comm);
      impl_->traffic.add(part);
    }
  std::string part;
  for (int r = 1; rank() == 0 && r < size(); ++r)
    for (std::int64_t left = lengths[r]; left > 0; left -= static_cast<std::int64_t>(part.size())) {
      MPI_Status status;
      int bytes = 0;
      MPI_Probe(r, tag, impl_->comm, &status);
      MPI_Get_count(&status, MPI_BYTE, &bytes);
      part.resize(static_cast<std::size_t>(bytes));
      MPI_Recv(part.data(), bytes, MPI_BYTE, r, tag, impl_->comm, MPI_STATUS_IGNORE);
      visit(part);
    }
}

void Communicator::beginSwap(std::vector<Peer>& peers) const {
  if (!impl_) return;
  constexpr int tag = 2;
  for (Peer& peer : peers) {
    impl_->receives.emplace_back();
    MPI_Irecv(peer.received.data(), count(peer.received.size()), MPI_BYTE, peer.rank, tag, impl_->comm,
              &impl_->receives.back());
  }
  for (const Peer& peer : peers) {
    impl_->sends.emplace_back();
    MPI_Isend(peer.send.data(), count(peer.send.size()), MPI_BYTE, peer.rank, tag, impl_->comm,
              &impl_->sends.back());
    impl_->traffic.add(static_cast<std::int64_t>(peer.send.size()));
  }
}

void Communicator::endSwap(std::vector<Peer>& peers) const {
  if (!impl_) return;
  std::vector<MPI_Status> statuses(peers.size());
  MPI_Waitall(count(peers.size()), impl_->receives.data(), statuses.data());
  impl_->receives.clear();
  for (std::size_t p = 0; p < peers.size(); ++p) {
    int bytes = 0;
    MPI_Get_count(&statuses[p], MPI_BYTE, &bytes);
    peers[p].length = static_cast<std::size_t>(bytes);
  }
}

void Communicator::awaitSent() const {
  if (!impl_) return;
  MPI_Waitall(count(impl_->sends.size()), impl_->sends.data(), MPI_STATUSES_IGNORE);
  impl_->sends.clear();
}

const Traffic& Communicator::traffic() const {
  static const Traffic none;
  return impl_ ? impl_->traffic : none;
}

void Communicator::abort(int exitCode) const {
  if (impl_) MPI_Abort(impl_->comm, exitCode);
  std::exit(exitCode);
}

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
