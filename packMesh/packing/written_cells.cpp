// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/written_cells.h"

#include <utility>

namespace packmesh {

std::optional<std::vector<std::int64_t>> WrittenCells::take(const Relaxation& relaxation) {
  const WrittenCells old = std::exchange(*this, WrittenCells(*problem_));
  bool same = !old.ids_.empty();
  std::vector<std::int64_t> changed;
  for (const Body& body : relaxation.cellsAround()) {
    const std::size_t i = ids_.size();
    ids_.push_back(body.id);
    own_.push_back(relaxation.owns(body));
    cells_.push_back({body.species, placement(*problem_, body.pose())});
    same = same && i < old.ids_.size() && old.ids_[i] == body.id && old.own_[i] == own_[i];
    if (!same) continue;
    const Placement &before = old.cells_[i].placement, &now = cells_[i].placement;
    if (before.linear != now.linear || before.translation != now.translation)
      changed.push_back(static_cast<std::int64_t>(i));
  }
  if (!same || old.ids_.size() != ids_.size()) return {};
  return changed;
}

CertificateInput WrittenCells::certificateInput() const {
  CertificateInput input;
  for (const Species& species : problem_->species) {
    input.shapes.push_back(species.shape.get());
    input.walls.push_back(problem_->wallOf(species));
  }
  input.container = problem_->container.get();
  input.cells = &cells_;
  input.own = &own_;
  input.requiredGap = problem_->clearance;
  input.requiredWallGap = problem_->wallClearance;
  return input;
}

}  // namespace packmesh
