// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Which cells HemoCell keeps when it loads a .pos file, and the wall that keeps cells there.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/lattice.h"
#include "packMesh/container/container.h"

namespace packmesh::hemocell {

/// HemoCell's three rules for one species, for a vertex p in lattice units (µm/dx):
///  1. -0.5 < p <= n - 0.5 on all three axes, periodic ones included;
///  2. the node trunc(p + 0.5) is fluid (for p = n - 0.5 exactly, where there is no such node: node n - 1);
///  3. no solid node within ±int(d/dx) of that node on each axis; nodes that do not exist do not count.
/// A cell with one vertex that fails is deleted as a whole and without a word.
class Acceptance {
 public:
  /// @param minimumDistanceFromSolid d of rule 3, as passed to setInitialMinimumDistanceFromSolid [µm, whole
  ///   number], 0: none
  Acceptance(std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid);

  /// Nothing when HemoCell keeps a cell with these vertices, otherwise the rule that deletes it
  /// ("a vertex lies outside the lattice", "a vertex lies on a wall node", "nearer than 1 µm to a solid
  /// node").
  std::optional<std::string> violation(const std::vector<Vec3>& vertices) const;

  /// Whether a vertex at p [µm] may be: all three rules.
  bool allows(const Vec3& p) const;

  /// "Fluid" here: the nodes whose vertices are kept.
  const Lattice& allowedNodes() const { return allowed_; }

 private:
  std::shared_ptr<const Lattice> lattice_;
  Lattice allowed_;
  int minimumDistance_;  ///< [µm]
};

/// The wall inside which HemoCell keeps every vertex: the true wall (if any) and the faces of the voxels
/// whose node deletes a cell. Its examine() is that of the true wall, then HemoCell's; gaps are to the true
/// wall.
/// @param wall the true wall of the lumen, nullptr for none; must outlive the result
/// @param wallClearance what packing will demand from distance(): voxel faces only demand to be respected, so
///   their distance is reported larger by it [µm]
std::unique_ptr<Wall> makeAcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice,
                                       int minimumDistanceFromSolid, double wallClearance);

}  // namespace packmesh::hemocell
