// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/parallel/communicator.h"
#include "tests/support/catch.h"

using namespace packmesh;

TEST_CASE("Reductions include all ranks", "[mpi]") {
  const Communicator ranks = Communicator::world();
  const int n = ranks.size(), r = ranks.rank();
  REQUIRE(ranks.sum(std::int64_t(r + 1)) == n * (n + 1) / 2);
  REQUIRE(ranks.max(double(r)) == n - 1);
  REQUIRE(ranks.min(double(-r)) == 1 - n);
  REQUIRE(ranks.min(std::int64_t(n - r)) == 1);
  REQUIRE(ranks.any(r == n - 1));
  REQUIRE_FALSE(ranks.any(false));
  std::vector<std::int64_t> sums = {1, r, -r};
  ranks.sum(sums);
  REQUIRE(sums == std::vector<std::int64_t>{n, n * (n - 1) / 2, -n * (n - 1) / 2});
  sums = {1, r};
  std::vector<double> maxima = {-1.0 - r, r - 0.5, 1e300};
  ranks.sumAndMax(sums, maxima);
  REQUIRE(sums == std::vector<std::int64_t>{n, n * (n - 1) / 2});
  REQUIRE(maxima == std::vector<double>{-1.0, n - 1.5, 1e300});
  std::vector<std::uint64_t> bits(3 << 19);  // in more than one piece
  bits.front() = bits.back() = std::uint64_t(1) << r;
  ranks.unite(bits);
  REQUIRE((bits.front() == (1u << n) - 1 && bits.back() == bits.front() && bits[1] == 0));
  for (int root = 0; root < n; ++root)
    REQUIRE(ranks.broadcast("rank " + std::to_string(r), root) == "rank " + std::to_string(root));
  struct Told {
    int rank;
    double half;
  };
  for (int k = 0; k < 3; ++k) {
    const std::int64_t before = ranks.traffic().messages;
    const Told told = ranks.fromFirst(Told{r, 0.5 * (r + k)});
    REQUIRE((told.rank == 0 && told.half == 0.5 * k));
    REQUIRE(ranks.traffic().messages - before == (r == 0 ? n - 1 : 0));
  }
}

TEST_CASE("exchange and gathers deliver all items, whole or in pieces, and empty messages", "[mpi]") {
  const Communicator ranks = Communicator::world();
  const int n = ranks.size(), r = ranks.rank();
  const std::size_t longest = Communicator::longestMessage;
  Communicator::longestMessage = GENERATE(as<std::size_t>(), 1 << 30, 7, 4);
  std::vector<std::vector<int>> to(n);
  for (int other = 0; other < n; ++other) to[other].assign((r + other) % 3, 100 * r + other);
  const std::vector<std::vector<int>> received = ranks.exchange(to);
  CHECK(int(received.size()) == n);
  for (int other = 0; other < n; ++other)
    CHECK(received[other] == std::vector<int>((r + other) % 3, 100 * other + r));

  std::vector<int> expected;
  for (int other = 0; other < n; ++other) expected.insert(expected.end(), other, other);
  CHECK(ranks.gatherAll(std::vector<int>(r, r)) == expected);
  CHECK(ranks.gatherAll(std::vector<int>()).empty());

  std::vector<std::string> rows;
  std::vector<std::vector<std::string>> rowsTo(n), rowsFrom(n);
  for (int other = 0; other < n; ++other) {
    rows.insert(rows.end(), other, std::string(other, 'x'));
    rowsTo[other] = {"", std::to_string(r), std::string(r + other, 'y')};
    rowsFrom[other] = {"", std::to_string(other), std::string(r + other, 'y')};
  }
  CHECK(ranks.gatherRows(std::vector<std::string>(r, std::string(r, 'x'))) == rows);
  CHECK(ranks.exchangeRows(rowsTo) == rowsFrom);

  const std::string own(3 * r, char('a' + r));
  std::string all, streamed;
  for (int other = 0; other < n; ++other) all += std::string(3 * other, char('a' + other));
  ranks.streamToFirst({own.substr(0, r), "", std::string_view(own).substr(r)},
                      [&](std::string_view part) { streamed += part; });
  CHECK(streamed == (r == 0 ? all : ""));
  Communicator::longestMessage = longest;
}

TEST_CASE("Peers exchange messages of any length up to the longest, repeatedly", "[mpi]") {
  const Communicator ranks = Communicator::world();
  const std::int64_t before = ranks.traffic().bytes;
  std::vector<Communicator::Peer> peers;
  for (int other = 0; other < ranks.size(); ++other) {
    if (other == ranks.rank()) continue;
    peers.emplace_back();
    peers.back().rank = other;
    peers.back().received.resize(10);
  }
  for (int round = 0; round < 20; ++round) {
    for (Communicator::Peer& peer : peers)
      peer.send.assign((round + ranks.rank()) % 11, std::byte(ranks.rank()));
    ranks.beginSwap(peers);
    ranks.endSwap(peers);
    for (const Communicator::Peer& peer : peers) {
      REQUIRE(peer.length == std::size_t((round + peer.rank) % 11));
      for (std::size_t k = 0; k < peer.length; ++k) REQUIRE(peer.received[k] == std::byte(peer.rank));
    }
    ranks.awaitSent();
  }
  REQUIRE((ranks.alone() || ranks.traffic().bytes > before));
}

TEST_CASE("Failed ranks find out whether all others have failed, too", "[mpi]") {
  const Communicator ranks = Communicator::world();
  Arrival all(ranks), some(ranks);
  REQUIRE(all.ofAll(600.0));
  if (ranks.rank() == 0) REQUIRE(some.ofAll(0.05) == ranks.alone());
  ranks.sum(std::int64_t(1));
  if (ranks.rank() > 0) REQUIRE(some.ofAll(600.0));  // now that the first one has been there
  ranks.sum(std::int64_t(1));
  REQUIRE(Arrival(Communicator()).ofAll(0.0));
}
