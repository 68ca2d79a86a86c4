// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/make_lumen.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/hemocell/acceptance.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "hemocell_adapter/problem/solid.h"
#include "packMesh/container/obstacles.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/placement/placement.h"

namespace packmesh::hemocell {
namespace {

/// Points of the surface from which the thickness of the wall is measured: a wall with a hundredth of the
/// area has eighty of them.
constexpr std::int64_t sampledPoints = 8000;

/// A wall is one where it is thin as far as this around a point: the edge between two branches is not
/// [lattice spacings].
constexpr double around = 3.0;

/// Whether all nodes around a point are fluid.
bool isAmongFluid(const Lattice& lattice, const Vec3& p) {
  const std::array<int, 3> nodes = lattice.nodes();
  std::array<int, 3> low;
  for (int k = 0; k < 3; ++k) {
    low[k] = int(std::floor(p[k] / lattice.dx()));
    if (low[k] < 0 || low[k] + 1 >= nodes[k]) return false;
  }
  for (int n = 0; n < 8; ++n)
    if (!lattice.fluid(low[0] + (n & 1), low[1] + (n >> 1 & 1), low[2] + (n >> 2))) return false;
  return true;
}

/// A thin wall, or one point of it.
struct ThinPlace {
  Vec3 middle;
  double thickness;  ///< [µm]
};

/// The wall behind a point of the surface, if it is thinner than the lattice spacing and has no solid node.
std::optional<ThinPlace> wallBehind(const Wall& wall, const Lattice& lattice, const Vec3& p) {
  const double dx = lattice.dx();
  const Vec3 into = -wall.distance(p).gradient.normalized();
  if (!into.allFinite()) return {};
  const double beyond = wall.distance(p + dx * into).distance;
  if (!(beyond > 0.0)) return {};
  const ThinPlace place{p + 0.5 * (dx - beyond) * into, dx - beyond};
  if (!(place.thickness > 0.0) || !isAmongFluid(lattice, place.middle)) return {};
  if (!(wall.distance(place.middle).distance < 0.0)) return {};  // a grazing ray at a convex wall
  const Vec3 sideways = into.unitOrthogonal(), other = into.cross(sideways);
  for (const Vec3& step : {sideways, Vec3(-sideways), other, Vec3(-other)}) {
    const Vec3 beside = place.middle + around * dx * step;
    if (std::abs(wall.distance(beside).distance) > 0.5 * dx || !isAmongFluid(lattice, beside)) return {};
  }
  return place;
}

}  // namespace

std::optional<std::string> unseenWallWarning(const Lumen& lumen) {
  const Wall* const wall = lumen.container->wall();
  if (!lumen.lattice || !wall || wall->closedForm()) return {};
  if (lumen.container->volume() == lumen.lattice->fluidVolume()) return {};  // it consists of the nodes
  const TriangleMesh surface = lumen.container->surface();
  std::vector<double> areas;  // sums
  double sum = 0.0;
  for (int t = 0; t < int(surface.triangles.size()); ++t) {
    const Vec3 a = surface.corner(t, 0);
    areas.push_back(sum += (surface.corner(t, 1) - a).cross(surface.corner(t, 2) - a).norm());
  }
  std::optional<ThinPlace> thinnest;
  for (std::int64_t i = 0; i < sampledPoints && sum > 0.0; ++i) {
    const Vec3 u = evenPoint({0.0, 0.0, 0.0, 0.0}, std::uint64_t(i));
    const auto t =
        std::min<std::ptrdiff_t>(std::upper_bound(areas.begin(), areas.end(), u.x() * sum) - areas.begin(),
                                 std::ptrdiff_t(areas.size()) - 1);
    const double root = std::sqrt(u.y());
    const Vec3 p = (1.0 - root) * surface.corner(int(t), 0) +
                   root * (1.0 - u.z()) * surface.corner(int(t), 1) +
                   root * u.z() * surface.corner(int(t), 2);
    const auto place = wallBehind(*wall, *lumen.lattice, p);
    if (place && (!thinnest || place->thickness < thinnest->thickness)) thinnest = place;
  }
  if (!thinnest) return {};
  const Vec3& at = thinnest->middle;
  return fmt::format(
      "a wall is {:.2g} µm thick at ({:.4g}, {:.4g}, {:.4g}), and no node of the lattice is in it (dx {:.6g} "
      "µm): HemoCell does not see it, so that cells on both sides meet through it. Make it thicker, or dx "
      "smaller",
      thinnest->thickness, at.x(), at.y(), at.z(), lumen.lattice->dx());
}

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
    const auto& others = simulation.domain.boxNodes;
    if (others && Vec3((*others)[0], (*others)[1], (*others)[2]) != nodes)
      notices.push_back(
          fmt::format("<container><nodes> gives the lattice {} x {} x {} nodes; <domain> has {} x {} x {}",
                      nodes[0], nodes[1], nodes[2], (*others)[0], (*others)[1], (*others)[2]));
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

namespace {

/// A vessel whose surface has no recognisable open ends, or intersects itself: the nodes that HemoCell makes
/// fluid.
/// @param crossing where it intersects itself
/// @param lumen with its notices
Lumen voxelLumen(VesselOnLattice vessel, const std::string& crossing, bool periodic, Lumen lumen) {
  lumen.lattice = std::make_shared<Lattice>(std::move(vessel.lattice));
  lumen.container = makeVoxelLumen(lumen.lattice, {periodic, false, false});
  if (crossing.empty()) {
    lumen.note = fmt::format(
        "the STL has no flat ends perpendicular to x: the lumen consists of HemoCell's fluid nodes, and "
        "the hematocrit refers to their volume; the STL encloses {:.6g} µm³",
        signedVolume(vessel.surface));
  } else {
    lumen.note = "the lumen consists of HemoCell's fluid nodes, and the hematocrit refers to their volume";
    lumen.notices.push_back(crossingText(crossing, vessel.surface, *lumen.container, lumen.lattice->dx()));
  }
  lumen.periodic = periodic;
  lumen.acceptedOnly = true;
  return lumen;
}

/// @throws InputError if the STL does not exist
void requireGeometry(const Domain& domain) {
  if (!isThere(*domain.geometry)) {
    throw InputError(fmt::format(
        "{}: '{}' does not exist. Some HemoCell cases build their lumen in C++ and refer to a missing STL; "
        "describe such a lumen in config.xml, in µm of the .pos files, for example\n"
        "  <packing><container> <cylinder axis=\"x\" radius=\"12.5\" length=\"51.5\" center=\"25.5 13 13\"/> "
        "</container></packing>\n"
        "or <mesh file=\"lumen.stl\" scale=\"1\" openAxis=\"x\"/>, or <box/> with <obstacles>; --reference "
        "lists all elements",
        domain.geometryWhere, domain.geometry->string()));
  }
}

/// What `<refDirN>` makes of a geometry, whatever its unit. @param extent along `<refDir>`, in the unit of
/// the file
std::string scaleText(const Domain& domain, double extent) {
  const double unit = domain.dx * domain.refDirN / extent;
  if (isUnit(unit, 0.5 / domain.refDirN)) return {};  // a number of nodes is rounded
  const double inMicrometres = std::max(1.0, std::round(extent / domain.dx));
  return fmt::format(
      "{:.4g} µm per unit of {}: <refDirN> {} makes its {} extent {:.6g} µm, which is {:.6g} in the file "
      "(if that is in µm, <refDirN> {:.0f} keeps it)",
      unit, domain.geometry->filename().string(), domain.refDirN, "xyz"[domain.refDir],
      domain.dx * domain.refDirN, extent, inMicrometres);
}

void requireSimple(const VesselMesh& stl, const std::string& where) {
  if (!stl.crossing.empty())
    throw InputError(fmt::format("{}: {}; a pre-inlet needs one that does not", where, stl.crossing));
}

}  // namespace

Lumen vesselLumen(const Request& request, const Case& simulation,
                  const std::optional<PreInletPlace>& preInlet) {
  const Domain& domain = simulation.domain;
  requireGeometry(domain);
  Lumen lumen;
  const std::string where = fmt::format("{}: {}", domain.geometryWhere, domain.geometry->string());
  VesselMesh stl = located(domain.geometryWhere, [&] {
    return readVessel(*domain.geometry, request.capOpenings, tolerance::flatCapFraction, lumen.repairs);
  });
  const bool repaired = !lumen.repairs.empty() && isFilledByParity(stl.asRead);
  const double extent = boundingBox(stl.closed).size()[std::clamp(domain.refDir, 0, 2)];
  VesselOnLattice vessel = located(where, [&] {
    return placeVessel(std::move(stl.closed), domain.dx, domain.refDir, domain.refDirN,
                       repaired ? &stl.asRead : nullptr);
  });
  const double unit = domain.dx * domain.refDirN / extent;
  lumen.scale = scaleText(domain, extent);
  if (std::string text = cappedText(*domain.geometry, stl.openings, unit); !text.empty())
    lumen.repairs.push_back(std::move(text));
  if (!lumen.repairs.empty()) {
    lumen.repairs.push_back(
        fmt::format("{}: HemoCell reads the file as it is; repair it there too", domain.geometry->string()));
  }
  VesselEnds ends;
  std::string note =
      fmt::format("the volume is that of the STL, {:.6g} µm long, without the continuation of its ends",
                  boundingBox(vessel.surface).size().x());
  if (preInlet) {
    requireSimple(stl, where);
    ends.axis = preInlet->axis;
    PreInlet inlet =
        located(where, [&] { return makePreInlet(vessel, *preInlet, *simulation.preInletLength); });
    note = fmt::format(
        "the pre-inlet: plane {} of nodes along {} ({}), repeated with the fluid nodes of plane "
        "{}; frame of its own",
        inlet.slice, "xyz"[ends.axis], preInlet -> origin, inlet.flags);
    if (inlet.reachesBorder)
      lumen.notices.push_back(fmt::format(
          "the pre-inlet, plane {} of nodes along {}, reaches the border of the lattice: it is "
          "probably not a cross-section of the vessel; are direction and slice those of the case?",
          inlet.slice, "xyz"[ends.axis]));
    vessel.surface = std::move(inlet.surface);
    vessel.lattice = std::move(inlet.lattice);
  }
  if (!preInlet && (!stl.crossing.empty() || !hasFlatEnds(vessel.surface, ends.axis)))
    return voxelLumen(std::move(vessel), stl.crossing.empty() ? "" : where + ": " + stl.crossing,
                      request.periodicEnds.value_or(false), std::move(lumen));
  ends.lo = vessel.lattice.keptRegion().lo[ends.axis];
  ends.hi = vessel.lattice.keptRegion().hi[ends.axis];
  ends.periodic = request.periodicEnds.value_or(false);
  if (ends.periodic && !preInlet)
    note = fmt::format("the volume is that of a period, {:.6g} µm; the STL is {:.6g} µm long",
                       ends.hi - ends.lo, boundingBox(vessel.surface).size().x());
  lumen.lattice = std::make_shared<Lattice>(std::move(vessel.lattice));
  lumen.note = note;
  lumen.container = located(where, [&] { return makeVessel(std::move(vessel.surface), ends, vesselDetail); });
  lumen.periodic = ends.periodic;
  lumen.acceptedOnly = true;
  return lumen;
}

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
