// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Parts of what is packed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "packMesh/container/region.h"
#include "packMesh/core/pose.h"
#include "packMesh/relaxation/freedom.h"

namespace packmesh::hemocell {

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

}  // namespace packmesh::hemocell
