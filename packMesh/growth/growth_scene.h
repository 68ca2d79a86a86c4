// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The input of growth: plain data shared by its parts.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/relaxation/body.h"
#include "packMesh/relaxation/freedom.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// Shapes, lumen and constraints. References everything, copies nothing.
struct GrowthScene {
  std::vector<const Shape*> shapes;  ///< per species
  std::vector<const Wall*> walls;    ///< per species; nullptr: none
  std::vector<Freedom> freedoms;     ///< per species; empty: no constraints
  const Container* container = nullptr;
  double clearance = 0.0;      ///< least gap between membranes [µm]
  double wallClearance = 0.0;  ///< least gap between membrane and wall [µm]
  bool rotate = true;
  std::uint64_t seed = 1;
  Communicator communicator;  ///< the ranks that grow the cells together
  Threads threads = {};       ///< of this rank
  /// Polled by single ranks inside long operations (runs of TetGen); true abandons them. Empty: never.
  std::function<bool()> stop = {};
  /// How a pose of scale 1 will be written; empty: Pose::placement.
  std::function<Placement(const Pose&)> written;

  Placement placement(const Pose& pose) const {
    return written && pose.scale == 1.0 ? written(pose) : pose.placement();
  }
  /// nullptr: no constraints.
  const Freedom* freedomOf(int species) const { return freedoms.empty() ? nullptr : &freedoms[species]; }
  bool isFixed(const Body& cell) const {
    return cell.frozen || (!freedoms.empty() && freedoms[cell.species].fixed);
  }
  /// Least gap between a cell of this species and the wall [µm].
  double wallClearanceOf(int species) const {
    return wallClearance + (freedoms.empty() ? 0.0 : freedoms[species].extraWallClearance);
  }

  /// Input for certifying cells of this scene; the caller adds cells and owners.
  CertificateInput certificateInput() const {
    CertificateInput input;
    input.shapes = shapes;
    input.walls = walls;
    for (const Freedom& freedom : freedoms) input.extraWallGap.push_back(freedom.extraWallClearance);
    input.container = container;
    input.requiredGap = clearance;
    input.requiredWallGap = wallClearance;
    input.threads = threads;
    return input;
  }
};

}  // namespace packmesh
