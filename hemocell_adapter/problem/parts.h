// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A species of the user's, cut into parts that packing treats differently: fixed cells, and those of
/// each region.
#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/problem/job.h"
#include "hemocell_adapter/problem/lumen.h"
#include "packMesh/packing/packing_problem.h"

namespace packmesh::hemocell {

struct Scene;

/// Cells of one species with the same freedom.
struct ScenePart {
  int species = 0;
  std::string name;  ///< "RBC", "RBC, fixed", "RBC, region 1"
  std::int64_t count = 0;
  std::vector<Pose> start;  ///< of the first cells
  Freedom freedom;
  int region = -1;  ///< in Scene::regions; -1: none
};

/// A part of the lumen, with a hematocrit of its own.
struct SceneRegion {
  std::string name;  ///< "region 1 (config.xml:12: <sphere>)", "the rest"
  std::shared_ptr<const Region> region;
  double share = 0.0;       ///< of the lumen's volume
  double hematocrit = 0.0;  ///< asked for
};

/// The regions of the job and, as the last one, the rest; empty when the job has none.
/// @throws InputError when one lies outside the lumen
std::vector<SceneRegion> makeRegions(const Job& job, const Lumen& lumen);

/// Index of the region that a point is in.
int regionAt(const std::vector<SceneRegion>& regions, const Vec3& point);

/// All species in order, each in parts: fixed cells first, red cells by region. Of more cells to start with
/// than are asked for, some are drawn without bias.
/// @throws InputError when more cells are fixed than asked for
std::vector<ScenePart> makeParts(const Job& job, const Scene& scene);

/// What the user should know about the red cells of the regions. Pre: the scene has its parts.
/// @throws InputError when a region asks for red cells and is too small for one
std::vector<std::string> examineRegions(const Job& job, const Scene& scene);

/// Lines of .pos files that were read: cells that have not moved are written as they were.
class ReadLines {
 public:
  void add(const PosLine& line);
  /// The line that stands for a pose.
  PosLine lineOf(const Pose& pose) const;

 private:
  std::unordered_map<std::string, PosLine> lines_;  ///< by the bits of the pose
};

}  // namespace packmesh::hemocell
