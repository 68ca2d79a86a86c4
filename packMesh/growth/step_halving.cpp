// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/step_halving.h"

#include <algorithm>
#include <numeric>

#include "packMesh/certificate/certify.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

/// Shorter parts of a step than this are not tried.
constexpr double shortestPart = 1.0 / 8.0;

bool moves(const Pose& pose, const GrowthStep& step) {
  return step.scale != pose.scale || !step.rotation.isZero(0.0) || !step.translation.isZero(0.0);
}

}  // namespace

CertificateInput StepHalving::input() const {
  CertificateInput input;
  input.shapes = scene_.shapes;
  input.walls = scene_.walls;
  input.container = scene_.container;
  input.cells = &cells_;
  input.requiredGap = scene_.clearance;
  return input;
}

std::optional<std::string> StepHalving::misplacement(std::int64_t i) const {
  const PlacedCell& cell = cells_[i];
  const Wall* wall = scene_.walls[cell.species];
  if (!wall) return {};
  const Shape& shape = *scene_.shapes[cell.species];
  const Sphere sphere = boundingSphere(shape.hierarchy(), cell.placement);
  if (wall->isAway(sphere, scene_.wallClearance)) return {};
  WallVerdict verdict = wall->examine({shape.hierarchy(), cell.placement}, scene_.wallClearance);
  if (!verdict.violation && verdict.gap < scene_.wallClearance)
    return "is nearer to the wall than the clearance";
  return std::move(verdict.violation);
}

Certificate StepHalving::examine(const GrowthState& state) {
  std::vector<std::int64_t> all(state.size());
  std::iota(all.begin(), all.end(), std::int64_t{0});
  return examine(state, all);
}

Certificate StepHalving::examine(const GrowthState& state, const std::vector<std::int64_t>& cells) {
  cells_.clear();
  for (const GrowingCell& cell : state) cells_.push_back({cell.species, scene_.placement(cell.pose)});
  return faultsOf(cells, scene_.sharesOf(state));
}

/// What is wrong with cells_ that have changed: every rank looks at its own, all know all.
Certificate StepHalving::faultsOf(const std::vector<std::int64_t>& changed, const CellShares& shares) const {
  const std::vector<std::int64_t> own = shares.ownOf(changed);
  Certificate faults;
  faults.overlapping = findOverlaps(input(), own);
  for (const std::int64_t i : own)
    if (auto reason = misplacement(i)) faults.misplaced.push_back({i, std::move(*reason)});
  faults.cells = static_cast<std::int64_t>(cells_.size());
  if (shares.alone()) return faults;
  std::vector<std::int64_t> numbers(cells_.size());
  std::iota(numbers.begin(), numbers.end(), std::int64_t{0});
  Certificate all = ofAllRanks(faults, numbers, shares.communicator());
  // Pairs of cells of two ranks were seen by both.
  const auto same = [](const OverlappingPair& a, const OverlappingPair& b) {
    return a.first == b.first && a.second == b.second && a.shift == b.shift;
  };
  all.overlapping.erase(std::unique(all.overlapping.begin(), all.overlapping.end(), same),
                        all.overlapping.end());
  all.cells = faults.cells;
  return all;
}

std::vector<double> StepHalving::take(const std::vector<GrowthStep>& steps, GrowthState& state,
                                      StepHalvingSums& sums, const CellShares& shares) {
  const GrowthState before = state;
  const Box bounds = scene_.container->bounds();
  const Vec3 period = scene_.container->period();
  cells_.resize(state.size());
  std::vector<double> part(state.size(), 1.0);
  std::vector<bool> still(state.size(), false);
  const auto place = [&](std::int64_t i) {
    state[i] = before[i];
    if (part[i] > 0.0 && !still[i]) {
      state[i].pose = stepped(before[i].pose, steps[i], part[i]);
      state[i].pose.position = wrapped(state[i].pose.position, bounds, period);
    }
    cells_[i] = {state[i].species, scene_.placement(state[i].pose)};
  };
  std::vector<std::int64_t> changed;
  for (std::size_t i = 0; i < state.size(); ++i) {
    still[i] = !moves(state[i].pose, steps[i]);
    if (!still[i]) changed.push_back(static_cast<std::int64_t>(i));
    place(static_cast<std::int64_t>(i));
  }
  sums.steps += static_cast<std::int64_t>(changed.size());
  for (bool first = true; !changed.empty(); first = false) {
    std::vector<bool> offends(state.size(), false);
    const Certificate faults = faultsOf(changed, shares);
    for (const MisplacedCell& cell : faults.misplaced) offends[cell.cell] = true;
    for (const OverlappingPair& pair : faults.overlapping) offends[pair.first] = offends[pair.second] = true;
    if (first) {
      sums.misplaced += static_cast<std::int64_t>(faults.misplaced.size());
      sums.violatingPairs += static_cast<std::int64_t>(faults.overlapping.size());
    }
    changed.clear();
    for (std::size_t i = 0; i < state.size(); ++i) {
      if (!offends[i] || still[i] || part[i] == 0.0) continue;
      part[i] = part[i] > shortestPart ? 0.5 * part[i] : 0.0;
      sums.stayed += part[i] == 0.0;
      place(static_cast<std::int64_t>(i));
      changed.push_back(static_cast<std::int64_t>(i));
    }
  }
  return part;
}

}  // namespace packmesh
