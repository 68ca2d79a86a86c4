// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/communicator.h"

#include <mpi.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <stdexcept>

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

std::string Communicator::broadcast(const std::string& text, int root) const {
  if (!impl_) return text;
  std::int64_t length = static_cast<std::int64_t>(text.size());
  MPI_Bcast(&length, 1, MPI_INT64_T, root, impl_->comm);
  std::string result = impl_->rank == root ? text : std::string(length, '\0');
  MPI_Bcast(result.data(), count(result.size()), MPI_CHAR, root, impl_->comm);
  return result;
}

std::vector<Communicator::Bytes> Communicator::exchangeBytes(std::vector<Bytes> to) const {
  if (!impl_) return to;
  const int ranks = impl_->size;
  std::vector<std::int64_t> sending(ranks), receiving(ranks);
  for (int r = 0; r < ranks; ++r) sending[r] = count(to[r].size());
  MPI_Alltoall(sending.data(), 1, MPI_INT64_T, receiving.data(), 1, MPI_INT64_T, impl_->comm);
  std::vector<Bytes> received(ranks);
  std::vector<MPI_Request> requests;
  constexpr int tag = 1;
  for (int r = 0; r < ranks; ++r) {
    if (r == impl_->rank || receiving[r] == 0) continue;
    received[r].resize(receiving[r]);
    requests.emplace_back();
    MPI_Irecv(received[r].data(), count(received[r].size()), MPI_BYTE, r, tag, impl_->comm, &requests.back());
  }
  for (int r = 0; r < ranks; ++r) {
    if (r == impl_->rank || sending[r] == 0) continue;
    requests.emplace_back();
    MPI_Isend(to[r].data(), count(to[r].size()), MPI_BYTE, r, tag, impl_->comm, &requests.back());
    ++impl_->traffic.messages;
    impl_->traffic.bytes += sending[r];
  }
  MPI_Waitall(count(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  received[impl_->rank] = std::move(to[impl_->rank]);
  return received;
}

Communicator::Bytes Communicator::toFirstRank(int from, const Bytes& bytes) const {
  constexpr int tag = 3;
  if (impl_->rank == from) {
    MPI_Send(bytes.data(), count(bytes.size()), MPI_BYTE, 0, tag, impl_->comm);
    ++impl_->traffic.messages;
    impl_->traffic.bytes += static_cast<std::int64_t>(bytes.size());
  }
  Bytes received;
  if (impl_->rank == 0) {
    MPI_Status status;
    int length = 0;
    MPI_Probe(from, tag, impl_->comm, &status);
    MPI_Get_count(&status, MPI_BYTE, &length);
    received.resize(length);
    MPI_Recv(received.data(), length, MPI_BYTE, from, tag, impl_->comm, MPI_STATUS_IGNORE);
  }
  return received;
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
    ++impl_->traffic.messages;
    impl_->traffic.bytes += static_cast<std::int64_t>(peer.send.size());
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

}  // namespace packmesh
