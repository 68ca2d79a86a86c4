// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/make_lumen.h"

#include <fmt/format.h>

#include "hemocell_adapter/hemocell/periodic_wall.h"
#include "hemocell_adapter/problem/box_lumen.h"
#include "hemocell_adapter/problem/container_lumen.h"
#include "hemocell_adapter/problem/vessel_lumen.h"

namespace packmesh::hemocell {

Lumen makeLumen(const Request& request, const Case* simulation,
                const std::optional<PreInletPlace>& preInlet) {
  if (request.container) return containerLumen(request, simulation);
  if (simulation && simulation->running) return runningLumen(request, *simulation->running);
  if (request.boxSize) return boxLumen(request);
  if (simulation->domain.geometry) return vesselLumen(request, *simulation, preInlet);
  return domainBox(request, *simulation);
}

std::shared_ptr<const Wall> speciesWall(const Lumen& lumen, int minimumDistanceFromSolid, double reach,
                                        double wallClearance) {
  if (!lumen.acceptedOnly || !lumen.lattice) return nullptr;
  return makePeriodicAcceptedWall(lumen.container, lumen.lattice, minimumDistanceFromSolid, reach,
                                  wallClearance);
}

}  // namespace packmesh::hemocell
