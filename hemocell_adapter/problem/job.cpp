// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/job.h"

#include <algorithm>

namespace packmesh::hemocell {

double wallClearanceOf(const Job& job, const JobSpecies& species) {
  return std::max(job.wallClearance, species.ownWallClearance);
}

}  // namespace packmesh::hemocell
