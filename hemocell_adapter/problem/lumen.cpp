// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/lumen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/hemocell/periodic_wall.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/container/obstacles.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"
#include "packMesh/container/vessel_ends.h"
#include "packMesh/core/input_file.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool hasWall(const std::string& walls, int axis) {
  return walls.find("xyz"[axis]) != std::string::npos;
}

/// Spacing at which the distances of vessels are sampled [µm]: fine enough for a wall clearance of some
/// hundredths of a micrometre on smooth walls.
constexpr double vesselDetail = 0.5;

/// @param asRead if given, receives the mesh without repairs
TriangleMesh readClosed(const fs::path& file, const std::string& where, std::vector<std::string>& notices,
                        TriangleMesh* asRead = nullptr) {
  try {
    TriangleMesh mesh = readMesh(file);
    if (asRead) *asRead = mesh;
    for (const std::string& repair : repairClosed(mesh, file.string())) notices.push_back(repair);
    return mesh;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", where, error.what()));
  }
}

/// Where HemoCell keeps vertices of a box with this many nodes, (lo, hi]; along an axis with walls the first
/// and the last plane of nodes are solid.
Box keptBoxOf(const std::array<int, 3>& nodes, double dx, const std::string& walls) {
  Box box = keptRegion(nodes, dx);
  for (int k = 0; k < 3; ++k) {
    if (!hasWall(walls, k)) continue;
    box.lo[k] += dx;
    box.hi[k] -= dx;
  }
  return box;
}

std::array<int, 3> checkedNodes(const Vec3& nodes, const std::string& where) {
  if (nodes.prod() > mostNodes) {
    throw InputError(fmt::format("{}: a lattice of {} x {} x {} nodes is too large (at most 2^31)", where,
                                 nodes[0], nodes[1], nodes[2]));
  }
  return {int(nodes[0]), int(nodes[1]), int(nodes[2])};
}

/// A box of the command line: along periodic axes [0, s], along others the part that HemoCell keeps.
Lumen boxLumen(const Job& job) {
  Lumen lumen;
  const std::string walls = job.walls.value_or("");
  // Rounding of s / dx: a size that is a multiple of dx up to the last bits has that many nodes.
  constexpr double relativeRounding = 1e-9;
  std::array<int, 3> nodes{};
  for (int k = 0; k < 3; ++k) {
    const double steps = std::floor((*job.boxSize)[k] / job.dx * (1 + relativeRounding));
    nodes[k] = int(std::clamp(steps, 1.0, 1e9)) + (hasWall(walls, k) ? 1 : 0);
  }
  for (int k = 0; k < 3; ++k)
    if (!job.periodicEnds.value_or(false) && (*job.boxSize)[k] * (1 + relativeRounding) < job.dx)
      throw InputError(
          fmt::format("the box is {:.6g} µm along {}, less than the lattice spacing (dx {:.6g} µm)",
                      (*job.boxSize)[k], "xyz"[k], job.dx));
  lumen.keptBox = keptBoxOf(nodes, job.dx, walls);
  Box box = *lumen.keptBox;
  std::array<bool, 3> periodic{};
  for (int k = 0; k < 3; ++k) {
    periodic[k] = !hasWall(walls, k) && job.periodicEnds.value_or(false);
    if (!periodic[k]) continue;
    lumen.periodic = true;
    box.lo[k] = 0.0;
    box.hi[k] = (*job.boxSize)[k];
  }
  lumen.container = makeBox(box, periodic);
  lumen.acceptedOnly = !lumen.periodic;
  lumen.solidWalls = !walls.empty();
  if (lumen.acceptedOnly) {
    lumen.note = fmt::format(
        "({:.6g}, {:.6g}] x ({:.6g}, {:.6g}] x ({:.6g}, {:.6g}] µm, what HemoCell keeps of {} x {} x {} "
        "nodes at dx {:.6g} µm",
        box.lo[0], box.hi[0], box.lo[1], box.hi[1], box.lo[2], box.hi[2], nodes[0], nodes[1], nodes[2],
        job.dx);
    const Vec3 cut = (*job.boxSize - job.dx * Vec3(nodes[0], nodes[1], nodes[2])).cwiseAbs();
    if (walls.empty() && (cut.array() > relativeRounding * job.boxSize->array()).any())
      lumen.note +=
          fmt::format("; {:.6g} x {:.6g} x {:.6g} µm requested, truncated to whole lattice spacings",
                      (*job.boxSize)[0], (*job.boxSize)[1], (*job.boxSize)[2]);
  }
  return lumen;
}

/// A case whose lattice is a box of nodes; walls are whole node planes, so the true wall is half a node
/// inside.
Lumen domainBox(const Job& job) {
  const Domain& domain = job.config->domain;
  if (!job.walls) {
    throw InputError(fmt::format(
        "{}: <domain> has no <geometry>, so the lumen is a box of {} x {} x {} nodes. Which of its faces are "
        "walls is defined only in the case's C++ code: specify it by --walls yz (or xyz, none) or "
        "<packing><walls>, or describe the lumen in "
        "<packing><container>",
        job.config->file.string(), (*domain.boxNodes)[0], (*domain.boxNodes)[1], (*domain.boxNodes)[2]));
  }
  Lumen lumen;
  const Vec3 counts((*domain.boxNodes)[0], (*domain.boxNodes)[1], (*domain.boxNodes)[2]);
  const std::array<int, 3> nodes = checkedNodes(counts, job.config->file.string());
  auto lattice = std::make_shared<Lattice>(nodes, domain.dx);
  const Box box = keptBoxOf(nodes, domain.dx, *job.walls);
  std::array<bool, 3> periodic{};
  const bool wrap = job.periodicEnds.value_or(false);
  for (int k = 0; k < 3; ++k) {
    if (!hasWall(*job.walls, k)) {
      periodic[k] = wrap;
      continue;
    }
    if (nodes[k] < 3) {
      throw InputError(fmt::format("{}: {} nodes along {} leave no lumen between two walls",
                                   job.config->file.string(), nodes[k], "xyz"[k]));
    }
    for (int a = 0; a < nodes[(k + 1) % 3]; ++a) {
      for (int b = 0; b < nodes[(k + 2) % 3]; ++b) {
        for (const int plane : {0, nodes[k] - 1}) {
          std::array<int, 3> at{};
          at[k] = plane;
          at[(k + 1) % 3] = a;
          at[(k + 2) % 3] = b;
          lattice->setFluid(at[0], at[1], at[2], false);
        }
      }
    }
  }
  lumen.container = makeBox(box, periodic);
  lumen.lattice = std::move(lattice);
  lumen.periodic = periodic[0] || periodic[1] || periodic[2];
  lumen.acceptedOnly = true;
  lumen.solidWalls = !job.walls->empty();
  lumen.note = fmt::format("walls: {}", job.walls->empty() ? "none" : *job.walls);
  return lumen;
}

/// A vessel whose surface has no recognisable open ends: the nodes that HemoCell makes fluid.
Lumen voxelLumen(VesselOnLattice vessel, bool periodic, std::vector<std::string> notices) {
  Lumen lumen;
  lumen.lattice = std::make_shared<Lattice>(std::move(vessel.lattice));
  lumen.container = makeVoxelLumen(lumen.lattice, {periodic, false, false});
  lumen.note = fmt::format(
      "the STL has no flat ends perpendicular to x: the lumen consists of HemoCell's fluid nodes, and "
      "the hematocrit refers to their volume; the STL encloses {:.6g} µm³",
      signedVolume(vessel.surface));
  lumen.notices = std::move(notices);
  lumen.periodic = periodic;
  lumen.acceptedOnly = true;
  return lumen;
}

/// A case with an STL: the vessel as HemoCell places it, open along x.
Lumen vesselLumen(const Job& job) {
  const Domain& domain = job.config->domain;
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
  Lumen lumen;
  const auto located = [&](auto&& work) {
    try {
      return work();
    } catch (const InputError& error) {
      throw InputError(
          fmt::format("{}: {}: {}", domain.geometryWhere, domain.geometry->string(), error.what()));
    }
  };
  TriangleMesh asRead;
  TriangleMesh stl = readClosed(*domain.geometry, domain.geometryWhere, lumen.notices, &asRead);
  const bool repaired = !lumen.notices.empty() && isFilledByParity(asRead);
  VesselOnLattice vessel = located([&] {
    return placeVessel(std::move(stl), domain.dx, domain.refDir, domain.refDirN,
                       repaired ? &asRead : nullptr);
  });
  if (!lumen.notices.empty()) {
    lumen.notices.push_back(
        fmt::format("{}: HemoCell reads the file as it is; repair it there too", domain.geometry->string()));
  }
  VesselEnds ends;
  std::string note =
      fmt::format("the volume is that of the STL, {:.6g} µm long, without the continuation of its ends",
                  boundingBox(vessel.surface).size().x());
  if (job.preInlet) {
    ends.axis = job.preInlet->axis;
    PreInlet inlet =
        located([&] { return makePreInlet(vessel, *job.preInlet, *job.config->preInletLength); });
    note = fmt::format(
        "the pre-inlet: plane {} of nodes along {} ({}), repeated with the fluid nodes of plane "
        "{}; frame of its own",
        inlet.slice, "xyz"[ends.axis], job.preInlet->origin, inlet.flags);
    if (job.preInletInCode && !job.preInlet->isSame(*job.preInletInCode, vessel.lattice.nodes()))
      lumen.notices.push_back(
          fmt::format("the pre-inlet is stated to be {}, but {} says {}: the stated one is taken",
                      toString(*job.preInlet), job.preInletInCode->origin, toString(*job.preInletInCode)));
    if (inlet.severalOutlines)
      lumen.notices.push_back(fmt::format(
          "{}. All of them are used, since {} does not narrow the slice. To use only the first, narrow it "
          "there "
          "(slice.y1 = 42); if code that packMesh does not read does so, specify it by --pre-inlet-range {}",
          inlet.severalOutlines->text, job.preInlet->origin, toString(inlet.severalOutlines->first)));
    if (inlet.reachesBorder)
      lumen.notices.push_back(fmt::format(
          "the pre-inlet, plane {} of nodes along {}, reaches the border of the lattice: it is "
          "probably not a cross-section of the vessel; are direction and slice those of the case?",
          inlet.slice, "xyz"[ends.axis]));
    vessel.surface = std::move(inlet.surface);
    vessel.lattice = std::move(inlet.lattice);
  }
  if (!job.preInlet && !hasFlatEnds(vessel.surface, ends.axis))
    return voxelLumen(std::move(vessel), job.periodicEnds.value_or(false), std::move(lumen.notices));
  ends.lo = vessel.lattice.keptRegion().lo[ends.axis];
  ends.hi = vessel.lattice.keptRegion().hi[ends.axis];
  ends.periodic = job.periodicEnds.value_or(false);
  lumen.lattice = std::make_shared<Lattice>(std::move(vessel.lattice));
  lumen.note = note;
  lumen.container = located([&] { return makeVessel(std::move(vessel.surface), ends, vesselDetail); });
  lumen.periodic = ends.periodic;
  lumen.acceptedOnly = true;
  return lumen;
}

std::shared_ptr<const Container> ownBody(const Job& job, Lumen& lumen) {
  const SolidRequest& solid = *job.container->lumen;
  const bool wrap = job.periodicEnds.value_or(false);
  std::array<bool, 3> periodic{};
  int axis = -1;
  switch (solid.kind) {
    case SolidRequest::Kind::box: {
      const std::string walls = job.walls.value_or(wrap ? "" : "xyz");
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
  }
  if (axis >= 0) periodic[axis] = wrap;
  lumen.periodic = periodic[0] || periodic[1] || periodic[2];
  if (wrap && !lumen.periodic) {
    throw InputError(fmt::format("{}: ends cannot be periodic: this lumen has no open ends{}", solid.where,
                                 solid.kind == SolidRequest::Kind::mesh ? " (openAxis, --open-axis)" : ""));
  }
  std::shared_ptr<const Container> body = makeSolid(solid, periodic, lumen.notices);
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
std::shared_ptr<const Lattice> latticeOf(const Job& job, const Container& container,
                                         const std::vector<std::shared_ptr<const Container>>& obstacles,
                                         std::vector<std::string>& notices) {
  const double dx = job.dx;
  Vec3 nodes;
  if (job.container->nodes) {
    nodes = job.container->nodes->array().round();
  } else if (job.config->domain.boxNodes) {
    for (int k = 0; k < 3; ++k) nodes[k] = (*job.config->domain.boxNodes)[k];
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
  const std::array<int, 3> n = checkedNodes(nodes, job.config->file.string());
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

Lumen ownLumen(const Job& job) {
  Lumen lumen;
  if (job.container->lumen) {
    lumen.container = ownBody(job, lumen);
  } else if (job.boxSize) {
    lumen = boxLumen(job);
  } else if (job.config && job.config->domain.boxNodes) {
    lumen = domainBox(job);
  } else {
    throw InputError(fmt::format(
        "{}: <container> has no body, and <domain> no box: add <box>, <cylinder>, <sphere> or <mesh>",
        job.config->file.string()));
  }
  const std::shared_ptr<const Container> outer = lumen.container;
  std::vector<std::shared_ptr<const Container>> solids;
  if (!job.container->obstacles.empty()) {
    std::vector<Obstacle> obstacles;
    for (const SolidRequest& solid : job.container->obstacles) {
      solids.push_back(makeSolid(solid, {false, false, false}, lumen.notices));
      obstacles.push_back({solids.back()->surface(), solid.where});
    }
    lumen.container = subtractObstacles(outer, std::move(obstacles));
    lumen.solidWalls = true;
  }
  if (job.running) {
    lumen.lattice = job.running->lattice;
    lumen.acceptedOnly = true;
    lumen.note =
        "the lumen of <container> and the fluid nodes of the running HemoCell; the hematocrit refers to the "
        "lumen";
  } else if (job.config) {
    lumen.lattice = latticeOf(job, *outer, solids, lumen.notices);
    lumen.acceptedOnly = true;
  }
  return lumen;
}

}  // namespace

namespace {

/// The nodes that are fluid, if they are those of a box: its corners, both included.
std::optional<std::array<std::array<int, 3>, 2>> fluidBox(const Lattice& lattice) {
  const auto range = lattice.fluidRange();
  if (!range) return {};
  std::int64_t nodes = 1;
  for (int a = 0; a < 3; ++a) nodes *= (*range)[1][a] - (*range)[0][a] + 1;
  return nodes == lattice.fluidNodes() ? range : std::nullopt;
}

/// The fluid nodes of a running HemoCell. Boxes of them are the boxes that domainBox() makes.
Lumen runningLumen(const Job& job) {
  const RunningCase& running = *job.running;
  Lumen lumen;
  lumen.lattice = running.lattice;
  lumen.acceptedOnly = true;
  lumen.note = fmt::format("the fluid nodes of {}, whose volume the hematocrit refers to",
                           running.isPreInlet ? "HemoCell's pre-inlet" : "the running HemoCell");
  std::array<bool, 3> periodic = running.periodic;
  for (bool& axis : periodic) axis = axis && *job.periodicEnds;
  if (const auto box = fluidBox(*running.lattice)) {
    const double dx = running.lattice->dx();
    Box bounds = running.lattice->keptRegion();
    lumen.solidWalls = false;
    for (int k = 0; k < 3; ++k) {
      const bool walls = (*box)[0][k] > 0 || (*box)[1][k] < running.lattice->nodes()[k] - 1;
      periodic[k] = periodic[k] && !walls;
      lumen.solidWalls = lumen.solidWalls || walls;
      if (!walls) continue;
      bounds.lo[k] = dx * ((*box)[0][k] - 0.5);
      bounds.hi[k] = dx * ((*box)[1][k] + 0.5);
    }
    lumen.container = makeBox(bounds, periodic);
  } else {
    lumen.container = makeVoxelLumen(running.lattice, periodic);
  }
  lumen.periodic = periodic[0] || periodic[1] || periodic[2];
  return lumen;
}

}  // namespace

Lumen makeLumen(const Job& job) {
  if (job.running && !job.container) return runningLumen(job);
  if (job.container) return ownLumen(job);
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

std::shared_ptr<const Container> makeSolid(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                           std::vector<std::string>& notices) {
  try {
    switch (solid.kind) {
      case SolidRequest::Kind::box:
        return makeBox({solid.origin, solid.origin + solid.size}, periodic);
      case SolidRequest::Kind::cylinder: {
        Vec3 corner = Vec3::Constant(solid.radius);
        corner[solid.axis] = 0.5 * solid.length;
        return makeCylinder(solid.center.value_or(corner), solid.axis, solid.radius, solid.length,
                            periodic[solid.axis]);
      }
      case SolidRequest::Kind::sphere:
        return makeSphere(solid.center.value_or(Vec3::Constant(solid.radius)), solid.radius);
      case SolidRequest::Kind::mesh:
        break;
    }
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", solid.where, error.what()));
  }
  TriangleMesh mesh = readClosed(solid.file, solid.where, notices);
  for (Vec3& v : mesh.vertices) v = solid.scale * v + solid.origin;
  const Box bounds = boundingBox(mesh);
  if (const double reach = std::max(bounds.hi.maxCoeff(), -bounds.lo.minCoeff());
      reach > specs::largestLength) {
    throw InputError(
        fmt::format("{}: {}: with the factor {:.6g} it reaches {:.3g} µm from the origin, at most {:.0f} µm "
                    "are possible; is the unit right?{}",
                    solid.where, solid.file.string(), solid.scale, reach, specs::largestLength,
                    unitHint(bounds.size().maxCoeff(), solid.scale, smallestVessel, largestVessel)));
  }
  std::optional<VesselEnds> ends;
  if (solid.openAxis) {
    ends.emplace();
    ends->axis = *solid.openAxis;
    ends->lo = bounds.lo[ends->axis];
    ends->hi = bounds.hi[ends->axis];
    ends->periodic = periodic[ends->axis];
  }
  try {
    return makeVessel(std::move(mesh), ends, vesselDetail);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", solid.where, error.what()));
  }
}

}  // namespace packmesh::hemocell
