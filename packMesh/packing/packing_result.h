// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What pack() gives back.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/core/pose.h"
#include "packMesh/escape/escape.h"
#include "packMesh/growth/cat_face_planes.h"
#include "packMesh/growth/growth.h"

namespace packmesh {

enum class Outcome {
  certified,    ///< all cells asked for, certificate clean
  outOfReach,   ///< a limit was met before all cells were free of overlap: fewer cells, certified
  interrupted,  ///< the caller asked to stop
};

struct Statistics {
  std::int64_t blocks = 0;   ///< the domain was cut into; more ranks than that are idle
  std::int64_t sweeps = 0;   ///< of the relaxation
  std::int64_t repairs = 0;  ///< rounds in which pairs failing the exact test got more clearance
  std::optional<GrowthStatistics> growth;    ///< of Method::cat
  std::optional<TetrahedraSums> tetrahedra;  ///< of PlaneSource::catFaces
  std::vector<EscapePhase> escape;           ///< where local maxima were escaped
  /// CPU time of this rank [s]
  double placementSeconds = 0.0, relaxationSeconds = 0.0, growthSeconds = 0.0, certificateSeconds = 0.0;
};

struct PackingResult {
  Outcome outcome = Outcome::certified;
  /// In the order of the species, then of the cells' numbers: of this rank, those of the ranks before come
  /// before. All cells asked for when certified (and those from a reserve); the densest certified packing
  /// found when out of reach (see `searched`), or none without Limits::fewerCells; none when interrupted.
  std::vector<PlacedCell> cells;
  std::vector<Pose> poses;     ///< the same cells as poses
  std::int64_t cellCount = 0;  ///< of all ranks
  /// When out of reach: the search for the densest packing came to its end. Otherwise time ended it, or
  /// (growth) there was none, and the cells are just some that could be certified.
  bool searched = false;
  Certificate certificate;  ///< of exactly the `cells` of all ranks; pairs and cells by number
  Statistics statistics;
};

}  // namespace packmesh
