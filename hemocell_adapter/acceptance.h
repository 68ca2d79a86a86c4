// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which cells HemoCell keeps when it loads a .pos file, and the wall that keeps cells there.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hemocell_adapter/lattice.h"
#include "packMesh/container/container.h"

namespace packmesh::hemocell {

/// HemoCell's three rules for one species.
class Acceptance {
 public:
  /// @param minimumDistanceFromSolid as passed to setInitialMinimumDistanceFromSolid [µm, whole number], 0: none
  Acceptance(std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid);

  /// Nothing when HemoCell keeps a cell with these vertices, otherwise the rule that deletes it
  /// ("a vertex lies outside the lattice", "a vertex lies on a wall node", "nearer than 1 µm to a solid node").
  std::optional<std::string> objection(const std::vector<Vec3>& vertices) const;

  /// Whether a vertex at p may be: all three rules.
  bool allows(const Vec3& p) const;

 private:
  std::shared_ptr<const Lattice> lattice_;
  Lattice allowed_;  ///< "fluid" here: a node whose cells are kept
};

/// The wall inside which HemoCell keeps every vertex: the true wall (if any) and the faces of the voxels whose
/// node deletes a cell.
/// @param wall the true wall of the lumen, nullptr for none; must outlive the result
/// @param wallClearance what packing will demand from distance(): voxel faces only demand to be respected, so
///   their distance is reported larger by it [µm]
std::unique_ptr<Wall> makeAcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice,
                                       int minimumDistanceFromSolid, double wallClearance);

}  // namespace packmesh::hemocell
