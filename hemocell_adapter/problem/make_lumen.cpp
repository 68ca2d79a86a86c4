// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/make_lumen.h"

#include <fmt/format.h>

#include "hemocell_adapter/hemocell/periodic_wall.h"
#include "hemocell_adapter/problem/box_lumen.h"
#include "hemocell_adapter/problem/container_lumen.h"
#include "hemocell_adapter/problem/vessel_lumen.h"

namespace packmesh::hemocell {

Lumen makeLumen(const Job& job) {
  if (job.running && !job.container) return runningLumen(job);
  if (job.container) return containerLumen(job);
  if (job.boxSize) return boxLumen(job);
  if (job.config->domain.geometry) return vesselLumen(job);
  return domainBox(job);
}

std::shared_ptr<const Wall> speciesWall(const Lumen& lumen, int minimumDistanceFromSolid, double reach,
                                        double wallClearance) {
  if (!lumen.acceptedOnly || !lumen.lattice) return nullptr;
  return makePeriodicAcceptedWall(lumen.container, lumen.lattice, minimumDistanceFromSolid, reach,
                                  wallClearance);
}

}  // namespace packmesh::hemocell
