// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/solid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"

namespace packmesh::hemocell {
namespace {

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

/// The nodes that are fluid, if they are those of a box: its corners, both included.
std::optional<std::array<std::array<int, 3>, 2>> fluidBox(const Lattice& lattice) {
  const auto range = lattice.fluidRange();
  if (!range) return {};
  std::int64_t nodes = 1;
  for (int a = 0; a < 3; ++a) nodes *= (*range)[1][a] - (*range)[0][a] + 1;
  return nodes == lattice.fluidNodes() ? range : std::nullopt;
}

}  // namespace

bool hasWall(const std::string& walls, int axis) {
  return walls.find("xyz"[axis]) != std::string::npos;
}

std::array<int, 3> checkedNodes(const Vec3& nodes, const std::string& where) {
  if (nodes.prod() > mostNodes) {
    throw InputError(fmt::format("{}: a lattice of {} x {} x {} nodes is too large (at most 2^31)", where,
                                 nodes[0], nodes[1], nodes[2]));
  }
  return {int(nodes[0]), int(nodes[1]), int(nodes[2])};
}

Lumen boxLumen(const Request& request) {
  Lumen lumen;
  const std::string walls = request.walls.value_or("");
  // Rounding of s / dx: a size that is a multiple of dx up to the last bits has that many nodes.
  constexpr double relativeRounding = 1e-9;
  std::array<int, 3> nodes{};
  for (int k = 0; k < 3; ++k) {
    const double steps = std::floor((*request.boxSize)[k] / request.dx * (1 + relativeRounding));
    if (steps > 1e9)
      throw InputError(fmt::format("the box is {:.6g} µm along {}, {:.3g} lattice spacings (dx {:.6g} µm)",
                                   (*request.boxSize)[k], "xyz"[k], steps, request.dx));
    nodes[k] = int(std::max(steps, 1.0)) + (hasWall(walls, k) ? 1 : 0);
  }
  for (int k = 0; k < 3; ++k)
    if (!request.periodicEnds.value_or(false) && (*request.boxSize)[k] * (1 + relativeRounding) < request.dx)
      throw InputError(
          fmt::format("the box is {:.6g} µm along {}, less than the lattice spacing (dx {:.6g} µm)",
                      (*request.boxSize)[k], "xyz"[k], request.dx));
  lumen.keptBox = keptBoxOf(nodes, request.dx, walls);
  Box box = *lumen.keptBox;
  std::array<bool, 3> periodic{};
  for (int k = 0; k < 3; ++k) {
    periodic[k] = !hasWall(walls, k) && request.periodicEnds.value_or(false);
    if (!periodic[k]) continue;
    lumen.periodic = true;
    box.lo[k] = 0.0;
    box.hi[k] = (*request.boxSize)[k];
  }
  lumen.container = makeBox(box, periodic);
  lumen.acceptedOnly = !lumen.periodic;
  lumen.solidWalls = !walls.empty();
  if (lumen.acceptedOnly) {
    lumen.note = fmt::format(
        "({:.6g}, {:.6g}] x ({:.6g}, {:.6g}] x ({:.6g}, {:.6g}] µm, what HemoCell keeps of {} x {} x {} "
        "nodes at dx {:.6g} µm",
        box.lo[0], box.hi[0], box.lo[1], box.hi[1], box.lo[2], box.hi[2], nodes[0], nodes[1], nodes[2],
        request.dx);
    const Vec3 cut = (*request.boxSize - request.dx * Vec3(nodes[0], nodes[1], nodes[2])).cwiseAbs();
    if (walls.empty() && (cut.array() > relativeRounding * request.boxSize->array()).any())
      lumen.note +=
          fmt::format("; {:.6g} x {:.6g} x {:.6g} µm requested, truncated to whole lattice spacings",
                      (*request.boxSize)[0], (*request.boxSize)[1], (*request.boxSize)[2]);
  }
  return lumen;
}

Lumen domainBox(const Request& request, const Case& simulation) {
  const Domain& domain = simulation.domain;
  if (!request.walls) {
    throw InputError(fmt::format(
        "{}: <domain> has no <geometry>, so the lumen is a box of {} x {} x {} nodes. Which of its faces are "
        "walls is defined only in the case's C++ code: specify it by " +
            named("walls", "yz") +
            " (or xyz, none) or "
            "<packing><walls>, or describe the lumen in "
            "<packing><container>",
        simulation.file.string(), (*domain.boxNodes)[0], (*domain.boxNodes)[1], (*domain.boxNodes)[2]));
  }
  Lumen lumen;
  const Vec3 counts((*domain.boxNodes)[0], (*domain.boxNodes)[1], (*domain.boxNodes)[2]);
  const std::array<int, 3> nodes = checkedNodes(counts, simulation.file.string());
  auto lattice = std::make_shared<Lattice>(nodes, domain.dx);
  const Box box = keptBoxOf(nodes, domain.dx, *request.walls);
  std::array<bool, 3> periodic{};
  const bool wrap = request.periodicEnds.value_or(false);
  for (int k = 0; k < 3; ++k) {
    if (!hasWall(*request.walls, k)) {
      periodic[k] = wrap;
      continue;
    }
    if (nodes[k] < 3) {
      throw InputError(fmt::format("{}: {} nodes along {} leave no lumen between two walls",
                                   simulation.file.string(), nodes[k], "xyz"[k]));
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
  lumen.solidWalls = !request.walls->empty();
  lumen.note = fmt::format("walls: {}", request.walls->empty() ? "none" : *request.walls);
  return lumen;
}

Lumen runningLumen(const Request& request, const RunningSystem& running) {
  Lumen lumen;
  lumen.lattice = running.lattice;
  lumen.acceptedOnly = true;
  lumen.note = fmt::format("the fluid nodes of {}, whose volume the hematocrit refers to",
                           running.isPreInlet ? "HemoCell's pre-inlet" : "the running HemoCell");
  std::array<bool, 3> periodic = running.periodic;
  for (bool& axis : periodic) axis = axis && *request.periodicEnds;
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

VesselMesh readVessel(const Source& file, bool capOpenings, double flatness,
                      std::vector<std::string>& repairs) {
  VesselMesh mesh;
  mesh.asRead = mesh.closed = meshFrom(file, &repairs);
  for (std::string& repair : repairClosed(mesh.closed, file.string(), capOpenings ? &mesh.openings : nullptr,
                                          flatness, &mesh.crossing))
    repairs.push_back(std::move(repair));
  return mesh;
}

std::string cappedText(const std::filesystem::path& file, const std::vector<CappedOpening>& openings,
                       double unit) {
  if (openings.empty()) return {};
  std::vector<std::string> areas;
  for (const CappedOpening& opening : openings) {
    areas.push_back(fmt::format("{:.6g} µm²", opening.area * unit * unit));
    if (opening.deviation > 0.0)
      areas.back() += fmt::format(", its edges within {:.2g} µm of a plane", opening.deviation * unit);
  }
  return fmt::format(
      "{}: capped {} flat opening{} ({}); " + named("flat-openings", "refuse") + " makes them errors",
      file.string(), openings.size(), openings.size() == 1 ? "" : "s", fmt::join(areas, "; "));
}

namespace {

/// The nodes in a surface that intersects itself, in the coordinate system of .pos files, as HemoCell fills
/// it: a node is in it if a ray from there crosses it an odd number of times.
std::shared_ptr<const Container> nodesIn(const TriangleMesh& surface, double dx) {
  const Box bounds = boundingBox(surface);
  if (!(bounds.lo.minCoeff() >= 0.0))
    throw InputError(fmt::format(
        "its lumen is that of HemoCell's nodes, which begin at 0, and the surface begins at ({:.6g}, {:.6g}, "
        "{:.6g}) µm; move it by the attribute offset of <mesh>, or join its parts (Boolean union) in a mesh "
        "editor",
        bounds.lo.x(), bounds.lo.y(), bounds.lo.z()));
  TriangleMesh inNodes = surface;
  for (Vec3& v : inNodes.vertices) v /= dx;
  const Vec3 count = (bounds.hi / dx).array().ceil() + 1.0;
  auto lattice = std::make_shared<Lattice>(checkedNodes(count, "a surface that intersects itself"), dx);
  const auto [nx, ny, nz] = lattice->nodes();
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j) lattice->setFluid(0, nx - 1, j, k, false);
  fillInside(*lattice, inNodes);
  return makeVoxelLumen(lattice, {false, false, false});
}

std::shared_ptr<const Container> bodyOf(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                        std::vector<std::string>& repairs, bool capOpenings, double nodes) {
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
    case SolidRequest::Kind::halfSpace:
    case SolidRequest::Kind::beyond:
      break;
  }
  VesselMesh vessel = readVessel(solid.file, capOpenings, tolerance::flatHoleFraction, repairs);
  if (std::string text = cappedText(solid.file.file, vessel.openings, solid.scale); !text.empty())
    repairs.push_back(std::move(text));
  TriangleMesh mesh = std::move(vessel.closed);
  for (Vec3& v : mesh.vertices) v = solid.scale * v + solid.origin;
  const Box bounds = boundingBox(mesh);
  if (const double reach = std::max(bounds.hi.maxCoeff(), -bounds.lo.minCoeff());
      reach > specs::largestLength) {
    throw InputError(
        fmt::format("{}: with the factor {:.6g} it reaches {:.3g} µm from the origin, at most {:.0f} µm "
                    "are possible; is the unit right?{}",
                    solid.file.string(), solid.scale, reach, specs::largestLength,
                    unitHint(bounds.size().maxCoeff(), solid.scale, smallestVessel, largestVessel)));
  }
  if (!vessel.crossing.empty()) {
    const std::string what = solid.file.string() + ": " + vessel.crossing;
    if (nodes == 0.0 || solid.openAxis)
      throw MeshError(what + "; join the parts (Boolean union) or remesh them in a mesh editor" +
                      (nodes > 0.0 ? "; without open ends, HemoCell's nodes in it can be packed" : ""));
    std::shared_ptr<const Container> body = located(what, [&] { return nodesIn(mesh, nodes); });
    repairs.push_back(solid.file.string() + ": " + crossingText(vessel.crossing, mesh, *body, nodes));
    return body;
  }
  std::optional<VesselEnds> ends;
  if (solid.openAxis) {
    ends.emplace();
    ends->axis = *solid.openAxis;
    ends->lo = bounds.lo[ends->axis];
    ends->hi = bounds.hi[ends->axis];
    ends->periodic = periodic[ends->axis];
  }
  return makeVessel(std::move(mesh), ends, vesselDetail);
}

}  // namespace

std::string crossingText(const std::string& crossing, const TriangleMesh& surface, const Container& nodes,
                         double dx) {
  TriangleMesh inNodes = surface;
  for (Vec3& v : inNodes.vertices) v /= dx;
  return fmt::format(
      "{}; the lumen consists of HemoCell's fluid nodes at dx {:.6g} µm, {:.6g} µm³, without what an even "
      "number of parts have in common; the surfaces enclose about {:.6g} µm³, what they have in common "
      "counted "
      "for each. Join the parts (Boolean union) in a mesh editor to fill all of them",
      crossing, dx, nodes.volume(), enclosedVolume(inNodes) * dx * dx * dx);
}

std::shared_ptr<const Container> makeSolid(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                           std::vector<std::string>& repairs, bool capOpenings,
                                           double nodes) {
  if (solid.file.given) return bodyOf(solid, periodic, repairs, capOpenings, nodes);  // which messages name
  return located(solid.where, [&] { return bodyOf(solid, periodic, repairs, capOpenings, nodes); });
}

}  // namespace packmesh::hemocell
