// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's rules for accepting cells of a .pos file, and a wall that enforces them.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/lattice.h"
#include "packMesh/container/container.h"

namespace packmesh::hemocell {

/// Exceptions from the rules of Acceptance.
struct AcceptanceExceptions {
  std::array<bool, 3> periodic{};  ///< axes along which rule 1 is void: vertices are wrapped
  bool anyDistance = false;        ///< rule 3 is void
};

/// HemoCell's three rules for one species, for a vertex p in lattice units (µm/dx):
/// 1. -0.5 < p <= n - 0.5 on all three axes, including periodic ones;
/// 2. the node trunc(p + 0.5) is fluid (for p = n - 0.5 exactly, where there is no such node: node n - 1);
/// 3. no solid node within ±int(d/dx) of that node on each axis; nonexistent nodes do not count.
/// A cell is deleted silently and entirely if any vertex violates a rule.
class Acceptance {
 public:
  /// @param minimumDistanceFromSolid d of rule 3, as passed to setInitialMinimumDistanceFromSolid [µm,
  /// integer]; 0: none
  Acceptance(std::shared_ptr<const Lattice> lattice, int minimumDistanceFromSolid);

  /// Empty if HemoCell keeps a cell with these vertices [µm], otherwise the rule that deletes it ("a vertex
  /// lies outside the lattice", "a vertex lies on a wall node", "closer than 1 µm to a solid node").
  std::optional<std::string> violation(const std::vector<Vec3>& vertices,
                                       const AcceptanceExceptions& except = {}) const;

  /// Fluid nodes here are the nodes whose vertices are kept.
  const Lattice& allowedNodes() const { return *allowed_; }

 private:
  std::shared_ptr<const Lattice> lattice_, allowed_;
  int minimumDistance_;  ///< [µm]
};

/// The wall inside which HemoCell keeps every vertex: the true wall (if any) and the faces of the voxels of
/// forbidden nodes. Its examine() tests the true wall, then HemoCell's rules; gaps are those to the true
/// wall.
/// @param wall the true wall of the lumen, nullptr for none; must outlive the result
/// @param wallClearance clearance that packing requires of distance(). Since voxel faces need no clearance,
/// it is added to their distance [µm]
std::unique_ptr<Wall> makeAcceptedWall(const Wall* wall, std::shared_ptr<const Lattice> lattice,
                                       int minimumDistanceFromSolid, double wallClearance);

/// Like makeAcceptedWall, but the lattice repeats along axes where `container` is periodic: there the faces
/// of the lattice are not walls, and only the flags of the (repeated) nodes count. Owns its data.
/// @param reach largest distance of a vertex outside the period [µm]
std::shared_ptr<const Wall> makePeriodicAcceptedWall(std::shared_ptr<const Container> container,
                                                     std::shared_ptr<const Lattice> lattice,
                                                     int minimumDistanceFromSolid, double reach,
                                                     double wallClearance);

}  // namespace packmesh::hemocell
