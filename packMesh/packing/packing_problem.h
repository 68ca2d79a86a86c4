// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is to be packed: plain data, no file formats.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/shape/shape.h"
#include "packMesh/tolerances.h"

namespace packmesh {

/// One kind of cell and how many of it.
struct Species {
  std::string name;
  std::shared_ptr<const Shape> shape;
  std::int64_t count = 0;
  /// The wall as this species meets it; nullptr: the container's own.
  std::shared_ptr<const Wall> wall;
};

/// When to give up.
struct Limits {
  double maxSeconds = 0.0;       ///< wall time [s]; 0: no limit
  std::int64_t maxSweeps = 0;    ///< relaxation sweeps; 0: the method's own limit
};

/// What pack() tells while it works.
struct Progress {
  std::string stage;
  std::int64_t sweep = 0;
  double scale = 1.0;            ///< common scale of the cells [fraction]
  double worstOverlap = 0.0;     ///< deepest penetration into a clearance [µm]
  std::int64_t unresolved = 0;   ///< pairs that still meet
};

struct PackingProblem {
  std::vector<Species> species;
  std::shared_ptr<const Container> container;
  double clearance = tolerance::defaultClearance;      ///< gap between membranes [µm]
  double wallClearance = tolerance::defaultClearance;  ///< gap between membrane and wall [µm]
  std::uint64_t seed = 1;
  bool rotate = true;  ///< false: every orientation stays the identity
  Limits limits;

  /// How a pose will be written, so that the certificate is about the written numbers; empty: Pose::placement.
  std::function<Placement(const Pose&)> written;
  /// Polled between sweeps; true stops the run cleanly.
  std::function<bool()> interrupted;
  std::function<void(const Progress&)> progress;
};

}  // namespace packmesh
