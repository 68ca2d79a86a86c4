// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A wall remembered on a grid.
#pragma once

#include <memory>
#include <vector>

#include "packMesh/container/container.h"

namespace packmesh {

/// Interpolates another wall's distance() between nodes at whole multiples of its samplingSpacing(). Nodes
/// are evaluated when they are first needed and kept in bricks, so that time and memory go with the wall's
/// area near cells, not with the lumen's volume. What it tells does not depend on the order of questions.
///
/// For one thread at a time. objection() is the other wall's own.
class SampledWall final : public Wall {
 public:
  /// @param wall must outlive this; pre: samplingSpacing() > 0
  /// @param region where questions are expected [µm]; elsewhere the wall itself is asked
  SampledWall(const Wall& wall, const Box& region);

  WallDistance distance(const Vec3& p) const override;
  double slack() const override { return wall_.slack(); }
  std::optional<std::string> objection(const TriangleMesh& placedCell) const override {
    return wall_.objection(placedCell);
  }

 private:
  static constexpr int brickCells = 8, brickNodes = brickCells + 1;
  struct Brick {
    float value[brickNodes * brickNodes * brickNodes];  ///< [µm]; NaN: not yet known
  };

  void evaluate(Brick& brick, const int (&brickIndex)[3], const int (&cell)[3]) const;

  const Wall& wall_;
  double spacing_;
  int lo_[3];  ///< node of the first brick
  int bricks_[3];
  mutable std::vector<std::unique_ptr<Brick>> brick_;
};

}  // namespace packmesh
