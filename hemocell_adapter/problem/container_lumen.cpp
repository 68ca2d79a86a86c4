// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/container_lumen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/problem/box_lumen.h"
#include "hemocell_adapter/problem/solid.h"
#include "packMesh/container/obstacles.h"
#include "packMesh/core/error.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh::hemocell {
namespace {

std::shared_ptr<const Container> ownBody(const Request& request, Lumen& lumen) {
  const SolidRequest& solid = *request.container->lumen;
  const bool wrap = request.periodicEnds.value_or(false);
  std::array<bool, 3> periodic{};
  int axis = -1;
  switch (solid.kind) {
    case SolidRequest::Kind::box: {
      const std::string walls = request.walls.value_or(wrap ? "" : "xyz");
      for (int k = 0; k < 3; ++k) periodic[k] = wrap && !hasWall(walls, k);
      break;
    }
    case SolidRequest::Kind::cylinder:
      axis = solid.axis;
      break;
    case SolidRequest::Kind::sphere:
      break;
    case SolidRequest::Kind::mesh:
      axis = solid.openAxis.value_or(-1);
      break;
    case SolidRequest::Kind::halfSpace:
    case SolidRequest::Kind::beyond:
      break;  // of regions alone
  }
  if (axis >= 0) periodic[axis] = wrap;
  lumen.periodic = periodic[0] || periodic[1] || periodic[2];
  if (wrap && !lumen.periodic) {
    throw InputError(
        fmt::format("{}: ends cannot be periodic: this lumen has no open ends{}", solid.where,
                    solid.kind == SolidRequest::Kind::mesh ? " (openAxis, " + named("open-axis") + ")" : ""));
  }
  std::shared_ptr<const Container> body =
      makeSolid(solid, periodic, lumen.repairs, request.capOpenings, request.dx);
  if (solid.kind == SolidRequest::Kind::mesh) {
    const Vec3 size = body->bounds().size();
    if (const std::string hint = unitHint(size.maxCoeff(), solid.scale, smallestVessel, largestVessel);
        !hint.empty())
      lumen.notices.push_back(
          fmt::format("{}: {}: with the factor {:.6g} it is {:.3g} x {:.3g} x {:.3g} µm{}", solid.where,
                      solid.file.string(), solid.scale, size.x(), size.y(), size.z(), hint));
  }
  return body;
}

/// Refuses a lumen that extends more than a node beyond the lattice: no cell can be there, but its volume
/// would count. (A small excess is the usual way to describe an open end.)
void requireInside(const Container& container, const Lattice& lattice) {
  const Box lumen = container.bounds(), kept = lattice.keptRegion();
  for (int k = 0; k < 3; ++k) {
    if (container.period()[k] > 0) continue;
    if (lumen.lo[k] >= kept.lo[k] - lattice.dx() && lumen.hi[k] <= kept.hi[k] + lattice.dx()) continue;
    throw InputError(fmt::format(
        "the lumen reaches from {0} = {1:.6g} to {2:.6g} µm, the lattice only from {3:.6g} to {4:.6g} µm "
        "({5} nodes "
        "along {0} at dx {6:.6g} µm): move it (origin, center, offset) or state the lattice by "
        "<container><nodes>",
        "xyz"[k], lumen.lo[k], lumen.hi[k], kept.lo[k], kept.hi[k], lattice.nodes()[k], lattice.dx()));
  }
}

/// The nodes of a lattice in a box [µm], first and last on each axis.
std::array<std::array<int, 2>, 3> nodesIn(const Lattice& lattice, const Box& box) {
  std::array<std::array<int, 2>, 3> range;
  for (int k = 0; k < 3; ++k) {
    const double last = lattice.nodes()[k] - 1.0;
    range[k] = {int(std::clamp(std::ceil(box.lo[k] / lattice.dx()), 0.0, last + 1.0)),
                int(std::clamp(std::floor(box.hi[k] / lattice.dx()), -1.0, last))};
  }
  return range;
}

/// Calls found(first, last, j, k, distance) for runs of nodes of `box` along x that lie on the same side of a
/// wall translated by `shift` [µm]; `distance` is that of the first, and none of the others is nearer to the
/// wall than `rounding` [µm].
template <class Found>
void forEachRun(const Lattice& lattice, const Box& box, const Wall& wall, const Vec3& shift, double rounding,
                Found found) {
  const auto range = nodesIn(lattice, box);
  const double dx = lattice.dx();
  for (int k = range[2][0]; k <= range[2][1]; ++k) {
    for (int j = range[1][0]; j <= range[1][1]; ++j) {
      for (int i = range[0][0]; i <= range[0][1];) {
        // All nodes up to the wall are on the same side as this one.
        constexpr double sure = 0.95;
        const double distance = wall.distance(dx * Vec3(i, j, k) - shift).distance;
        const double reach = sure * (std::abs(distance) - wall.slack() - rounding) / dx;
        const int last = i + static_cast<int>(std::clamp(reach, 0.0, double(range[0][1] - i)));
        found(i, last, j, k, distance);
        i = last + 1;
      }
    }
  }
}

/// Lattice of a lumen that is not defined in the XML: nodes inside the lumen or on its wall are fluid, nodes
/// in obstacles or on them are solid, as in the code of cases ("<=").
std::shared_ptr<const Lattice> latticeOf(const Request& request, const Case& simulation,
                                         const Container& container,
                                         const std::vector<std::shared_ptr<const Container>>& obstacles,
                                         std::vector<std::string>& notices) {
  const double dx = request.dx;
  Vec3 nodes;
  if (request.container->nodes) {
    nodes = request.container->nodes->array().round();
  } else if (simulation.domain.boxNodes) {
    for (int k = 0; k < 3; ++k) nodes[k] = (*simulation.domain.boxNodes)[k];
  } else {
    nodes = (container.bounds().hi / dx).array().ceil() + 1;
    for (int k = 0; k < 3; ++k) {
      if (container.period()[k] > 0) nodes[k] = std::round(container.period()[k] / dx);
    }
    nodes = nodes.cwiseMax(1.0);
    notices.push_back(
        fmt::format("the case's lattice is taken to have {} x {} x {} nodes; <container><nodes> states it",
                    nodes[0], nodes[1], nodes[2]));
  }
  const std::array<int, 3> n = checkedNodes(nodes, simulation.file.string());
  for (int k = 0; k < 3; ++k) {
    const double period = container.period()[k];
    constexpr double rounding = 1e-6;  // of numbers entered by users
    if (period > 0 && std::abs(n[k] * dx - period) > rounding * period) {
      throw InputError(fmt::format(
          "the lumen repeats along {} every {:.15g} µm, but {} nodes at dx {:.15g} µm are {:.15g} µm: in a "
          "periodic case both must agree",
          "xyz"[k], period, n[k], dx, n[k] * dx));
    }
  }
  auto lattice = std::make_shared<Lattice>(n, dx);
  requireInside(container, *lattice);
  if (const Wall* wall = container.wall())
    forEachRun(*lattice, lattice->keptRegion(), *wall, Vec3::Zero(), 0.0,
               [&](int first, int last, int j, int k, double distance) {
                 lattice->setFluid(first, last, j, k, distance >= 0);
               });
  const double rounding = 1e-6 * dx;  // nodes on an obstacle are solid
  for (const auto& obstacle : obstacles)
    for (const Vec3& shift : periodicShifts(container.period())) {
      const Box box = Box{obstacle->bounds().lo + shift, obstacle->bounds().hi + shift}.grownBy(rounding);
      forEachRun(*lattice, box, *obstacle->wall(), shift, rounding,
                 [&](int first, int last, int j, int k, double distance) {
                   if (distance >= -rounding) lattice->setFluid(first, last, j, k, false);
                 });
    }
  return lattice;
}

}  // namespace

Lumen containerLumen(const Request& request, const Case* simulation) {
  Lumen lumen;
  if (request.container->lumen) {
    lumen.container = ownBody(request, lumen);
  } else if (request.boxSize) {
    lumen = boxLumen(request);
  } else if (simulation && simulation->domain.boxNodes) {
    lumen = domainBox(request, *simulation);
  } else {
    throw InputError(fmt::format(
        "{}: <container> has no body, and <domain> no box: add <box>, <cylinder>, <sphere> or <mesh>",
        simulation->file.string()));
  }
  const std::shared_ptr<const Container> outer = lumen.container;
  std::vector<std::shared_ptr<const Container>> solids;
  if (!request.container->obstacles.empty()) {
    std::vector<Obstacle> obstacles;
    for (const SolidRequest& solid : request.container->obstacles) {
      solids.push_back(makeSolid(solid, {false, false, false}, lumen.repairs));
      obstacles.push_back({solids.back()->surface(), solid.where});
    }
    lumen.container = subtractObstacles(outer, std::move(obstacles));
    lumen.solidWalls = true;
  }
  if (simulation && simulation->running) {
    lumen.lattice = simulation->running->lattice;
    lumen.acceptedOnly = true;
    lumen.note =
        "the lumen of <container> and the fluid nodes of the running HemoCell; the hematocrit refers to the "
        "lumen";
  } else if (simulation) {
    lumen.lattice = latticeOf(request, *simulation, *outer, solids, lumen.notices);
    lumen.acceptedOnly = true;
  }
  return lumen;
}

}  // namespace packmesh::hemocell
