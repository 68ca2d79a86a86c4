// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/written_cells.h"

#include <algorithm>

#include "packMesh/parallel/periodic_images.h"

namespace packmesh {

namespace {

/// Cells that moved are sent to every rank as long as they are few.
constexpr double fewMoved = 0.02;
constexpr std::int64_t alwaysFew = 1000;

}  // namespace

void WrittenCells::take(Relaxation& relaxation) {
  *this = WrittenCells(*problem_);
  const std::vector<BodyState> states = relaxation.statesAround();
  ids_.reserve(states.size());
  own_.reserve(states.size());
  for (const BodyState& state : states) {
    ids_.push_back(state.id);
    own_.push_back(relaxation.owns(state));
  }
  cells_.resize(states.size());
  problem_->execution.threads.forEachPart(
      static_cast<std::int64_t>(states.size()), [&](std::int64_t begin, std::int64_t end, int) {
        for (std::int64_t i = begin; i < end; ++i)
          cells_[i] = {states[i].species, states[i].shape, problem_->physics.placement(states[i].pose())};
      });
  relaxation.forgetTouched();
}

std::optional<std::vector<std::int64_t>> WrittenCells::update(Relaxation& relaxation) {
  const Communicator& ranks = problem_->execution.communicator;
  const std::vector<BodyState> moved = relaxation.touchedStates();
  const double few =
      std::max(static_cast<double>(alwaysFew), fewMoved * static_cast<double>(relaxation.cellCount()));
  if (static_cast<double>(ranks.sum(static_cast<std::int64_t>(moved.size()))) > few && !ranks.alone())
    return {};
  relaxation.forgetTouched();
  const Vec3 period = problem_->physics.container->period();
  std::vector<std::int64_t> changed;
  bool far = false;
  for (const BodyState& state : ranks.gatherAll(moved)) {
    const auto at = std::lower_bound(ids_.begin(), ids_.end(), state.id);
    if (at == ids_.end() || *at != state.id) continue;
    const std::int64_t i = at - ids_.begin();
    Placement& known = cells_[i].placement;
    const Placement now = problem_->physics.placement(state.pose());
    if (known.linear == now.linear && known.translation == now.translation) continue;
    const Vec3& from = takenAt_.emplace(i, known.translation).first->second;
    far = far || nearestImage(now.translation - from, period).norm() > Relaxation::certifiedMotion;
    known = now;
    changed.push_back(i);
  }
  if (!ranks.alone() && ranks.any(far)) return {};
  std::sort(changed.begin(), changed.end());
  return changed;
}

CertificateInput WrittenCells::certificateInput() const {
  CertificateInput input = certificateInputOf(problem_->physics, cells_, problem_->execution.threads);
  input.own = &own_;
  return input;
}

}  // namespace packmesh
