// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certifier.h"

#include <cmath>

#include "packMesh/core/vector_text.h"

namespace packmesh {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Initial limit of the gaps measured, above the required gap [µm]: measuring gaps of a micrometre costs many
/// times as much as gaps of a hundredth, and few packings need it.
constexpr double firstLevel = 0.02;

std::string tooNear(double gap, double required) {
  int digits = 6;
  while (digits < 17 && toText(gap, digits) == toText(required, digits)) ++digits;
  return "is " + toText(gap, digits) + " µm from the wall, less than the required " +
         toText(required, digits) + " µm";
}

}  // namespace

Certifier::Certifier(const CertificateInput& input, double largestGap)
    : input_(input),
      cells_(input_),
      changed_(cells_.count(), true),
      nearest_(cells_.count(), infinite),
      partner_(cells_.count(), -1),
      pairGap_(largestGap, input.requiredGap + firstLevel, input.requiredGap),
      wallGaps_(cells_.count(), infinite),
      wallGap_(largestGap, largestGap) {
  neighbors_.emplace(cells_.neighbors());
  examineChanged();
}

void Certifier::update(const std::vector<std::int64_t>& changed) {
  allChanged_ = false;
  changed_.assign(cells_.count(), false);
  for (const std::int64_t cell : changed) changed_[cell] = true;
  forgetChanged();
  neighbors_.reset();
  neighbors_.emplace(cells_.neighbors());
  examineChanged();
}

void Certifier::forgetChanged() {
  pairGap_.forgetLeast();
  wallGap_.forgetLeast();
  for (std::int64_t i = 0; i < cells_.count(); ++i) {
    if (changed_[i]) {
      neighbors_->forEachNear(i, input_.requiredGap, false, [&](const NearPair& pair) {
        const std::int64_t other = pair.first == i ? pair.second : pair.first;
        if (cells_.isOwn(pair.first) && !(changed_[other] && other < i)) --certificate_.pairsTested;
      });
      nearest_[i] = wallGaps_[i] = infinite;
      partner_[i] = -1;
    } else if (partner_[i] >= 0 && changed_[partner_[i]]) {
      stale_.push_back(i);
    } else {
      pairGap_.found(nearest_[i]);
    }
    wallGap_.found(wallGaps_[i]);
  }
  auto& pairs = certificate_.overlapping;
  pairs.erase(
      std::remove_if(pairs.begin(), pairs.end(),
                     [&](const OverlappingPair& p) { return changed_[p.first] || changed_[p.second]; }),
      pairs.end());
  auto& misplaced = certificate_.misplaced;
  misplaced.erase(std::remove_if(misplaced.begin(), misplaced.end(),
                                 [&](const MisplacedCell& m) { return changed_[m.cell]; }),
                  misplaced.end());
}

bool Certifier::stopped() {
  if (input_.stop && input_.stop()) certificate_.complete = false;
  if (input_.upToFirstFault && !(certificate_.overlapping.empty() && certificate_.misplaced.empty()))
    certificate_.complete = false;
  return !certificate_.complete;
}

/// True if the search for overlaps stops. Checked between cells, so that the overlaps of a cell are all found
/// or none.
bool Certifier::enoughOverlaps() {
  if (static_cast<std::int64_t>(certificate_.overlapping.size()) < input_.mostOverlaps) return false;
  return certificate_.moreOverlaps = true;
}

void Certifier::examineChanged() {
  for (std::int64_t i = 0; i < cells_.count() && !stopped(); ++i)
    if (changed_[i] && (cells_.isOwn(i) || !allChanged_)) {
      if (!enoughOverlaps()) examinePairs(i, allChanged_, true);
      examineWall(i, true);
    }
  for (const std::int64_t i : stale_) measureLater(i);
  stale_.clear();
  sortByCells(certificate_.overlapping);
  std::sort(certificate_.misplaced.begin(), certificate_.misplaced.end(),
            [](const MisplacedCell& a, const MisplacedCell& b) { return a.cell < b.cell; });
  summarise();
}

/// @param isNew the pairs have not been examined at their present positions: search for violations, not only
/// gaps
void Certifier::examinePairs(std::int64_t cell, bool onlyLater, bool isNew) {
  const auto reach = [&] { return std::max(pairGap_.limit(), isNew ? input_.requiredGap : 0.0); };
  pairGap_.measured();
  neighbors_->forEachNear(cell, reach(), onlyLater, [&](const NearPair& pair) {
    const std::int64_t other = pair.first == cell ? pair.second : pair.first;
    if (!cells_.isOwn(pair.first)) return;
    if (!onlyLater && changed_[other] && other < cell) return;  // already examined from the other cell
    if (isNew && pair.apart < input_.requiredGap) ++certificate_.pairsTested;
    if (!(pair.apart < reach())) return;
    const MeshPairResult result = cells_.relation(pair, reach());
    pairGap_.measured();
    if (isNew) {
      if (const auto fault = cells_.faultOf(pair, result)) {
        certificate_.overlapping.push_back(*fault);
        return;
      }
    }
    if (result.relation != MeshRelation::apart || !(result.gap < nearest_[pair.first])) return;
    nearest_[pair.first] = result.gap;
    partner_[pair.first] = static_cast<std::int32_t>(pair.second);
    pairGap_.found(result.gap);
  });
}

void Certifier::measureLater(std::int64_t cell) {
  nearest_[cell] = infinite;
  partner_[cell] = -1;
  examinePairs(cell, true, false);
}

/// @param isNew the cell has not been examined at its present position: search for violations, not only the
/// gap
void Certifier::examineWall(std::int64_t cell, bool isNew) {
  const Wall* wall = cells_.wall(cell);
  if (!wall || !cells_.isOwn(cell)) return;
  wallGap_.measured();
  const double required = input_.wallGapOf((*input_.cells)[cell].species);
  const double reach = std::max(wallGap_.limit(), isNew ? required : 0.0);
  wallGaps_[cell] = infinite;
  if (wall->isAway(cells_.sphere(cell), reach)) return;
  WallVerdict verdict = wall->examine(cells_.mesh(cell), reach);
  if (isNew && verdict.violation)
    certificate_.misplaced.push_back({cell, std::move(*verdict.violation), 0.0});
  else if (isNew && verdict.gap < required)
    certificate_.misplaced.push_back({cell, tooNear(verdict.gap, required), verdict.gap});
  wallGaps_[cell] = verdict.gap;
  wallGap_.found(verdict.gap);
}

void Certifier::settlePairGap() {
  bool ofAllCells = !certificate_.moreOverlaps;
  while (certificate_.complete && !(ofAllCells && pairGap_.settled())) {
    pairGap_.beginAgain();
    ofAllCells = true;
    for (std::int64_t i = 0; i < cells_.count() && !stopped(); ++i) measureLater(i);
  }
}

void Certifier::settleWallGap() {
  while (certificate_.complete && !wallGap_.settled()) {
    wallGap_.beginAgain();
    for (std::int64_t i = 0; i < cells_.count() && !stopped(); ++i) examineWall(i, false);
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
    certificate_.minimumGap = pairGap_.least();
  }
  const auto& misplaced = certificate_.misplaced;
  const bool outside = std::any_of(misplaced.begin(), misplaced.end(), touches);
  if (!outside) settleWallGap();
  certificate_.minimumWallGap = outside ? 0.0 : wallGap_.least();
}

}  // namespace packmesh
