// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certifier.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <tuple>

#include "packMesh/certificate/overlap_finder.h"
#include "packMesh/core/vector.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

bool OverlapSearch::finish(std::int64_t found) {
  const bool fits = found < room();
  const bool kept = fits || (more_ && size_ == 1);
  if (kept) {
    kept_ += found;
    begin_ = fits ? end() : cells_;
    size_ *= 2;
    return true;
  }
  if (!more_) most_ = examples;
  more_ = true;
  size_ = 1;
  if (kept_ >= most_) begin_ = cells_;
  return false;
}

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Initial limit of the gaps measured, above the required gap [µm]: measuring gaps of a micrometre costs many
/// times as much as gaps of a hundredth, and few packings need it.
constexpr double firstLevel = 0.02;

/// Of a cell that is searched for examples of overlaps: so many of its neighbours are tested at most, and so
/// many of its pairs found.
constexpr std::size_t mostCandidates = 4096, mostExamples = 5;

bool isEarlier(const NearPair& a, const NearPair& b) {
  const auto key = [](const NearPair& p) {
    return std::make_tuple(p.second, p.shift[0], p.shift[1], p.shift[2]);
  };
  return key(a) < key(b);
}

std::string tooNear(double gap, double required) {
  int digits = 6;
  while (digits < 17 && toText(gap, digits) == toText(required, digits)) ++digits;
  return "is " + toText(gap, digits) + " µm from the wall, less than the required " +
         toText(required, digits) + " µm";
}

}  // namespace

Certifier::Certifier(const CertificateInput& input, LimitedSearch* search)
    : input_(input),
      cells_(input_),
      changed_(cells_.count(), true),
      nearest_(cells_.count(), infinite),
      partner_(cells_.count(), -1),
      pairGap_(input.largestGap, input.requiredGap + firstLevel, input.requiredGap),
      wallGaps_(cells_.count(), infinite),
      wallGap_(input.largestWallGap, input.largestWallGap) {
  certificate_.gapsMeasuredUpTo = input.largestGap;
  certificate_.wallGapsMeasuredUpTo = input.largestWallGap;
  for (const Shape* const shape : input_.shapes)
    if (const Shape* const undeformed = shape->undeformed().get())
      finders_.try_emplace(undeformed, undeformed->mesh());
  neighbors_.emplace(cells_.neighbors());
  examineAll(search);
  finish();
}

void Certifier::update(const std::vector<std::int64_t>& changed) {
  changed_.assign(cells_.count(), false);
  for (const std::int64_t cell : changed) changed_[cell] = true;
  forgetChanged();
  neighbors_.reset();
  neighbors_.emplace(cells_.neighbors());
  examineChanged();
  finish();
}

void Certifier::forgetChanged() {
  pairGap_.forgetLeast();
  wallGap_.forgetLeast();
  for (std::int64_t i = 0; i < cells_.count(); ++i) {
    if (changed_[i]) {
      const auto notYet = [&](std::int64_t other) { return !(changed_[other] && other < i); };
      neighbors_->forEachNear(i, input_.requiredGap, notYet, [&](const NearPair& pair) {
        if (cells_.isOwn(pair.first)) --certificate_.pairsTested;
      });
      nearest_[i] = wallGaps_[i] = infinite;
      partner_[i] = -1;
    } else if (partner_[i] >= 0 && changed_[partner_[i]]) {
      stale_.push_back(static_cast<std::int32_t>(i));
    } else {
      pairGap_.add(nearest_[i]);
    }
    wallGap_.add(wallGaps_[i]);
  }
  auto& pairs = certificate_.overlapping;
  pairs.erase(
      std::remove_if(pairs.begin(), pairs.end(),
                     [&](const OverlappingPair& p) { return changed_[p.first] || changed_[p.second]; }),
      pairs.end());
  const auto forget = [&](auto& faults) {
    faults.erase(
        std::remove_if(faults.begin(), faults.end(), [&](const auto& one) { return changed_[one.cell]; }),
        faults.end());
  };
  forget(certificate_.misplaced);
  forget(certificate_.selfIntersecting);
}

template <class Examine>
void Certifier::forEach(const std::vector<std::int32_t>& cells, const Examine& examine,
                        const std::function<bool()>& isKept) {
  PerThread<Findings> found(input_.threads, {pairGap_, wallGap_});
  std::atomic<bool> stops{!certificate_.complete};
  cells_.forEachPart(static_cast<std::int64_t>(cells.size()),
                     [&](std::int64_t begin, std::int64_t end, int thread) {
                       for (std::int64_t k = begin; k < end; ++k) {
                         if (thread == 0 && input_.stop && input_.stop()) stops = true;
                         if (stops) return;
                         examine(cells[k], found[thread]);
                         if (input_.upToFirstFault && found[thread].any()) stops = true;
                       }
                     });
  certificate_.complete = !stops;
  if (isKept && !isKept()) return;
  found.forEach([&](const Findings& some) { take(some); });
}

void Certifier::take(const Findings& findings) {
  pairGap_.join(findings.pairGap);
  wallGap_.join(findings.wallGap);
  for (const Findings::Near& near : findings.near)
    if (near.gap < nearest_[near.cell]) {
      nearest_[near.cell] = near.gap;
      partner_[near.cell] = near.partner;
    }
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(certificate_.overlapping, findings.overlapping);
  append(certificate_.misplaced, findings.misplaced);
  append(certificate_.selfIntersecting, findings.selfIntersecting);
  certificate_.pairsTested += findings.pairsTested;
}

void Certifier::examineAll(LimitedSearch* search) {
  std::vector<std::int32_t> own = neighbors_->spatialOrder();
  own.erase(std::remove_if(own.begin(), own.end(), [&](std::int32_t i) { return !cells_.isOwn(i); }),
            own.end());
  if (search) searchInRounds(own, *search);
  forEach(own, [&](std::int64_t i, Findings& found) {
    if (!search) examinePairs(i, true, true, found);
    examineWall(i, true, found);
    examineMembrane(i, found);
  });
}

/// @param cells of this rank
void Certifier::searchInRounds(const std::vector<std::int32_t>& cells, LimitedSearch& search) {
  OverlapSearch& rounds = search.rounds;
  // The first cell here whose number is not less.
  const auto here = [&](std::int64_t number) -> std::int64_t {
    if (!search.numbers) return number;
    return std::lower_bound(search.numbers->begin(), search.numbers->end(), number) - search.numbers->begin();
  };
  while (!rounds.over()) {
    const std::int64_t first = here(rounds.begin()), behind = here(rounds.end());
    std::vector<std::int32_t> round;
    for (const std::int32_t i : cells)
      if (first <= i && i < behind) round.push_back(i);
    const std::int64_t most = rounds.room();
    std::atomic<std::int64_t> room{most};
    const auto examine = [&](std::int64_t i, Findings& found) {
      if (room <= 0) return;
      if (!rounds.more()) return examinePairs(i, true, true, found, &room);
      const std::size_t before = found.overlapping.size();
      findExamples(i, found);
      room -= static_cast<std::int64_t>(found.overlapping.size() - before);
    };
    forEach(round, examine, [&] {
      const std::int64_t found = std::min(most, most - room);
      return rounds.finish(search.sum ? search.sum(found) : found);
    });
  }
  certificate_.moreOverlaps = rounds.more();
}

void Certifier::examineChanged() {
  std::vector<std::int32_t> changed;
  for (std::int64_t i = 0; i < cells_.count(); ++i)
    if (changed_[i]) changed.push_back(static_cast<std::int32_t>(i));
  forEach(changed, [&](std::int64_t i, Findings& found) {
    examinePairs(i, false, true, found);
    examineWall(i, true, found);
    examineMembrane(i, found);
  });
  measureLater(stale_);
  stale_.clear();
}

void Certifier::finish() {
  sortByCells(certificate_.overlapping);
  const auto sort = [](auto& faults) {
    std::sort(faults.begin(), faults.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
  };
  sort(certificate_.misplaced);
  sort(certificate_.selfIntersecting);
  summarise();
}

/// @param isNew the pairs have not been examined at their present positions: search for violations, not only
/// gaps
/// @param room if given: for so many pairs; then the search ends
void Certifier::examinePairs(std::int64_t cell, bool onlyLater, bool isNew, Findings& found,
                             std::atomic<std::int64_t>* room) {
  SmallestGap& smallest = found.pairGap;
  const auto reach = [&] { return std::max(smallest.limit(), isNew ? input_.requiredGap : 0.0); };
  smallest.measured();
  // Pairs of changed cells are examined from the first of them.
  const auto wanted = [&](std::int64_t other) { return other >= cell || !(onlyLater || changed_[other]); };
  neighbors_->forEachNear(cell, reach(), wanted, [&](const NearPair& pair) {
    if (!cells_.isOwn(pair.first)) return;
    if (room && *room <= 0) return;
    if (isUnlisted()) return;
    if (isNew && pair.apart < input_.requiredGap) ++found.pairsTested;
    if (!(pair.apart < reach())) return;
    const MeshPairResult result = cells_.relation(pair, reach());
    smallest.measured();
    if (isNew) {
      if (const auto fault = cells_.faultOf(pair, result)) {
        found.overlapping.push_back(*fault);
        if (room) --*room;
        return;
      }
    }
    if (result.relation != MeshRelation::apart) touching_ = true;
    if (result.relation != MeshRelation::apart || !std::isfinite(result.gap)) return;
    found.near.push_back({pair.first, static_cast<std::int32_t>(pair.second), result.gap});
    smallest.add(result.gap);
  });
}

/// Tests the neighbours of a cell in the order of their numbers until a few overlap.
void Certifier::findExamples(std::int64_t cell, Findings& found) const {
  std::vector<NearPair> near;
  const auto keepFirst = [&] {
    if (near.size() <= mostCandidates) return;
    std::nth_element(near.begin(), near.begin() + mostCandidates, near.end(), isEarlier);
    near.resize(mostCandidates);
  };
  neighbors_->forEachLater(cell, input_.requiredGap, [&](const NearPair& pair) {
    near.push_back(pair);
    if (near.size() == 2 * mostCandidates) keepFirst();
  });
  keepFirst();
  std::sort(near.begin(), near.end(), isEarlier);
  std::size_t examples = 0;
  for (const NearPair& pair : near) {
    const auto fault = cells_.faultOf(pair, cells_.relation(pair, input_.requiredGap));
    if (!fault) continue;
    found.overlapping.push_back(*fault);
    if (++examples == mostExamples) return;
  }
}

/// Measures the gaps to later cells.
void Certifier::measureLater(const std::vector<std::int32_t>& cells) {
  for (const std::int32_t cell : cells) {
    nearest_[cell] = infinite;
    partner_[cell] = -1;
  }
  forEach(cells, [&](std::int64_t i, Findings& found) { examinePairs(i, true, false, found); });
}

/// @param isNew the cell has not been examined at its present position: search for violations, not only the
/// gap
void Certifier::examineWall(std::int64_t cell, bool isNew, Findings& found) {
  const Wall* wall = cells_.wall(cell);
  if (!wall || !cells_.isOwn(cell)) return;
  found.wallGap.measured();
  const double required = input_.wallGapOf((*input_.cells)[cell].species);
  const double reach = std::max(found.wallGap.limit(), isNew ? required : 0.0);
  wallGaps_[cell] = infinite;
  if (wall->isAway(cells_.sphere(cell), reach)) return;
  WallVerdict verdict = wall->examine(cells_.mesh(cell), reach);
  if (isNew && verdict.violation)
    found.misplaced.push_back({cell, std::move(*verdict.violation), 0.0});
  else if (isNew && verdict.gap < required)
    found.misplaced.push_back({cell, tooNear(verdict.gap, required), verdict.gap, required});
  wallGaps_[cell] = verdict.gap;
  found.wallGap.add(verdict.gap);
}

/// Tests a deformed cell for self-intersection. Templates do not intersect themselves.
void Certifier::examineMembrane(std::int64_t cell, Findings& found) const {
  if (!cells_.isOwn(cell) || !cells_.shape(cell).undeformed()) return;
  const SelfIntersectionFinder& finder = finders_.at(cells_.shape(cell).undeformed().get());
  if (const auto pair = finder(placedVertices(cells_.shape(cell).mesh(), cells_.placement(cell))))
    found.selfIntersecting.push_back({cell, pair->first, pair->second});
}

void Certifier::settlePairGap() {
  bool ofAllCells = !certificate_.moreOverlaps;
  while (certificate_.complete && !isUnlisted() && !(ofAllCells && pairGap_.settled())) {
    pairGap_.beginAgain();
    ofAllCells = true;
    measureLater(neighbors_->spatialOrder());
  }
}

void Certifier::settleWallGap() {
  while (certificate_.complete && !wallGap_.settled()) {
    wallGap_.beginAgain();
    forEach(neighbors_->spatialOrder(),
            [&](std::int64_t i, Findings& found) { examineWall(i, false, found); });
  }
}

void Certifier::summarise() {
  certificate_.cells = 0;
  certificate_.cellVolume = 0.0;
  for (std::int64_t i = 0; i < cells_.count(); ++i) {
    if (!cells_.isOwn(i)) continue;
    ++certificate_.cells;
    certificate_.cellVolume += cells_.volume(i);
  }

  const auto touches = [](const auto& fault) { return fault.gap == 0.0; };
  const auto& pairs = certificate_.overlapping;
  const bool overlap = std::any_of(pairs.begin(), pairs.end(), touches);
  if (overlap) {
    certificate_.minimumGap = 0.0;
  } else if (!pairs.empty() && !certificate_.moreOverlaps) {
    const auto nearer = [](const OverlappingPair& a, const OverlappingPair& b) { return a.gap < b.gap; };
    certificate_.minimumGap = std::min_element(pairs.begin(), pairs.end(), nearer)->gap;
  } else {
    settlePairGap();
    certificate_.minimumGap = isUnlisted() ? 0.0 : pairGap_.least();
  }
  const auto& misplaced = certificate_.misplaced;
  const bool outside = std::any_of(misplaced.begin(), misplaced.end(), touches);
  if (!outside) settleWallGap();
  certificate_.minimumWallGap = outside ? 0.0 : wallGap_.least();
}

Certificate certify(const CertificateInput& input) {
  return Certifier(input).certificate();
}

Certificate certify(CertificateInput input, double largestGap) {
  input.largestGap = input.largestWallGap = largestGap;
  return certify(input);
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input,
                                          const std::vector<std::int64_t>& movedCells) {
  const PeriodicNeighbors neighbors = CertifiedCells(input).neighbors();
  std::vector<Vec3> positions;
  for (const PlacedCell& cell : *input.cells) positions.push_back(cell.placement.translation);
  return OverlapFinder(input, neighbors, std::move(positions))(movedCells);
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input) {
  std::vector<std::int64_t> all(input.cells->size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
  return findOverlaps(input, all);
}

}  // namespace packmesh
