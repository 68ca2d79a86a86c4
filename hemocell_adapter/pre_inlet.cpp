// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/pre_inlet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "packMesh/container/vessel_ends.h"
#include "packMesh/error.h"
#include "packMesh/geometry/polygon.h"

namespace packmesh::hemocell {
namespace {

/// HemoCell enlarges the box of the fluid nodes of the slice by this many nodes.
constexpr int border = 1;

using Node = std::array<int, 3>;

/// Fluid nodes of a plane: the box that holds them.
struct Section {
  Node lo, hi;
  bool empty = true;
};

Section sectionAt(const Lattice& lattice, int axis, int plane) {
  Section section;
  Node node{};
  node[axis] = plane;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (node[v] = 0; node[v] < lattice.nodes()[v]; ++node[v])
    for (node[u] = 0; node[u] < lattice.nodes()[u]; ++node[u]) {
      if (!lattice.fluid(node[0], node[1], node[2])) continue;
      for (int k = 0; k < 3; ++k) {
        section.lo[k] = section.empty ? node[k] : std::min(section.lo[k], node[k]);
        section.hi[k] = section.empty ? node[k] : std::max(section.hi[k], node[k]);
      }
      section.empty = false;
    }
  return section;
}

int sliceOf(const Lattice& lattice, const PreInletPlace& place) {
  const int n = lattice.nodes()[place.axis];
  if (place.slice) {
    if (*place.slice < 0 || *place.slice >= n)
      throw InputError(fmt::format("the slice of the pre-inlet, {}, is no plane of nodes: they are 0 to {}",
                                   *place.slice, n - 1));
    return *place.slice;
  }
  for (int i = 0; i < n; ++i) {
    const int plane = place.atHighEnd ? n - 1 - i : i;
    if (!sectionAt(lattice, place.axis, plane).empty) return plane;
  }
  throw InputError("the vessel has no fluid node");
}

/// Where the surface is cut: in the plane of nodes, but within the surface, which may end before it.
double cutAt(const TriangleMesh& surface, int axis, double at) {
  const Box box = boundingBox(surface);
  const double inset = 1e-6 * box.size()[axis];
  return std::clamp(at, box.lo[axis] + inset, box.hi[axis] - inset);
}

}  // namespace

PreInletPlace PreInletPlace::named(const std::string& direction) {
  PreInletPlace place;
  place.axis = std::tolower(static_cast<unsigned char>(direction[0])) - 'x';
  place.atHighEnd = std::tolower(static_cast<unsigned char>(direction[1])) == 'p';
  return place;
}

PreInlet makePreInlet(const VesselOnLattice& vessel, const PreInletPlace& place, int lengthN) {
  const Lattice& all = vessel.lattice;
  const int axis = place.axis, slice = sliceOf(all, place);
  const Section section = sectionAt(all, axis, slice);
  if (section.empty)
    throw InputError(fmt::format("the slice of the pre-inlet, plane {} of nodes along {}, has no fluid node",
                                 slice, "xyz"[axis]));
  Node lo{}, nodes{};
  for (int k = 0; k < 3; ++k) {
    lo[k] = std::max(section.lo[k] - border, 0);
    nodes[k] = std::min(section.hi[k] + border, all.nodes()[k] - 1) - lo[k] + 1;
  }
  nodes[axis] = lengthN + 1 + 2 * border;
  PreInlet inlet{{}, Lattice(nodes, all.dx()), slice};
  for (const int k : {(axis + 1) % 3, (axis + 2) % 3})
    inlet.reachesBorder = inlet.reachesBorder || section.lo[k] == 0 || section.hi[k] == all.nodes()[k] - 1;
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j)
      for (int i = 0; i < nodes[0]; ++i) {
        Node from = {lo[0] + i, lo[1] + j, lo[2] + k};
        from[axis] = slice;
        inlet.lattice.setFluid(i, j, k, all.fluid(from[0], from[1], from[2]));
      }
  const Box kept = inlet.lattice.keptRegion();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const Eigen::Vector2d corner(lo[u] * all.dx(), lo[v] * all.dx());
  for (Polygon& loop :
       loopsOf(outlineAt(vessel.surface, axis, cutAt(vessel.surface, axis, slice * all.dx())))) {
    for (Eigen::Vector2d& p : loop) p -= corner;
    const TriangleMesh prism = prismOver(loop, axis, kept.lo[axis], kept.hi[axis]);
    const int first = static_cast<int>(inlet.surface.vertices.size());
    inlet.surface.vertices.insert(inlet.surface.vertices.end(), prism.vertices.begin(), prism.vertices.end());
    for (const Triangle& t : prism.triangles)
      inlet.surface.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return inlet;
}

}  // namespace packmesh::hemocell
