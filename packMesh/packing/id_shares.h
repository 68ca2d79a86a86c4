// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distribution of cells over the ranks by id, for placement and for results.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "packMesh/analysis/cell_measures.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/relaxation/body.h"

namespace packmesh {

/// Ids 0 .. cells-1 in equal shares, one per rank, in the order of the ranks.
class IdShares {
 public:
  IdShares(std::int64_t cells, Communicator communicator)
      : cells_(cells), communicator_(std::move(communicator)) {}

  /// The ids of a rank: [first, second).
  std::pair<std::int64_t, std::int64_t> of(int rank) const {
    const std::int64_t ranks = communicator_.size(), each = cells_ / ranks, rest = cells_ % ranks;
    const auto start = [&](std::int64_t r) { return r * each + std::min(r, rest); };
    return {start(rank), start(rank + 1)};
  }
  std::pair<std::int64_t, std::int64_t> own() const { return of(communicator_.rank()); }

  /// This rank's share of the bodies that all ranks bring, each on one rank; both sorted by id. All ranks
  /// call it.
  std::vector<BodyState> collect(std::vector<Body> bodies) const {
    std::vector<BodyState> states(bodies.begin(), bodies.end());
    bodies.clear();
    bodies.shrink_to_fit();  // they are large
    return collect(std::move(states));
  }

  /// The same for any plain type with an `id`.
  template <class T>
  std::vector<T> collect(std::vector<T> items) const {
    if (!communicator_.alone()) items = exchanged(std::move(items));
    return sorted(std::move(items));
  }

  /// The same for what is known of cells. @param ids of each of them
  template <class T>
  std::vector<T> collect(const std::vector<std::int64_t>& ids, const std::vector<T>& own) const {
    struct Known {
      std::int64_t id;
      T of;
    };
    std::vector<Known> known;
    known.reserve(ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i) known.push_back({ids[i], own[i]});
    known = collect(std::move(known));
    std::vector<T> share;
    share.reserve(known.size());
    for (const Known& one : known) share.push_back(one.of);
    return share;
  }
  CellMeasures collect(const std::vector<std::int64_t>& ids, const CellMeasures& own) const {
    std::vector<MeasuresOfCell> measured;
    for (std::size_t i = 0; i < ids.size(); ++i) measured.push_back(measuresOfCell(own, i));
    measured = collect(ids, measured);
    CellMeasures all;
    all.resize(measured.size());
    for (std::size_t i = 0; i < measured.size(); ++i) setMeasuresOfCell(all, i, measured[i]);
    return all;
  }
  /// The same for rows of numbers of any lengths.
  template <class T>
  std::vector<std::vector<T>> collect(const std::vector<std::int64_t>& ids,
                                      std::vector<std::vector<T>> rows) const {
    std::vector<std::vector<std::int64_t>> idsTo(communicator_.size());
    std::vector<std::vector<std::vector<T>>> to(communicator_.size());
    for (std::size_t i = 0; i < ids.size(); ++i) {
      idsTo[rankOf(ids[i])].push_back(ids[i]);
      to[rankOf(ids[i])].push_back(std::move(rows[i]));
    }
    idsTo = communicator_.exchange(std::move(idsTo));
    to = communicator_.exchangeRows(std::move(to));
    struct Known {
      std::int64_t id;
      std::vector<T>* row;
    };
    std::vector<Known> known;
    for (std::size_t rank = 0; rank < to.size(); ++rank)
      for (std::size_t i = 0; i < to[rank].size(); ++i) known.push_back({idsTo[rank][i], &to[rank][i]});
    std::vector<std::vector<T>> share;
    for (const Known& one : sorted(std::move(known))) share.push_back(std::move(*one.row));
    return share;
  }

 private:
  /// Items are large; only their ids are sorted.
  template <class T>
  static std::vector<T> sorted(std::vector<T> items) {
    const auto before = [](const auto& a, const auto& b) { return a.id < b.id; };
    if (std::is_sorted(items.begin(), items.end(), before)) return items;
    struct Key {
      std::int64_t id, index;
    };
    std::vector<Key> order;
    order.reserve(items.size());
    for (const T& item : items) order.push_back({item.id, static_cast<std::int64_t>(order.size())});
    std::sort(order.begin(), order.end(), before);
    std::vector<T> out;
    out.reserve(items.size());
    for (const Key& key : order) out.push_back(items[key.index]);
    return out;
  }

  int rankOf(std::int64_t id) const {
    const std::int64_t ranks = communicator_.size(), each = cells_ / ranks, rest = cells_ % ranks;
    const std::int64_t first = rest * (each + 1);  // id of the first smaller share
    return static_cast<int>(id < first ? id / (each + 1) : rest + (id - first) / each);
  }

  template <class T>
  std::vector<T> exchanged(std::vector<T> items) const {
    std::vector<std::vector<T>> to(communicator_.size());
    for (const T& item : items) to[rankOf(item.id)].push_back(item);
    items.clear();
    items.shrink_to_fit();  // for the messages
    const std::vector<std::vector<T>> received = communicator_.exchange(to);
    to.clear();
    items.reserve(static_cast<std::size_t>(own().second - own().first));
    for (const std::vector<T>& some : received) items.insert(items.end(), some.begin(), some.end());
    return items;
  }

  std::int64_t cells_;
  Communicator communicator_;
};

}  // namespace packmesh
