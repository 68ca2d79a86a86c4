// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/box_lumen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"

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

}  // namespace packmesh::hemocell
