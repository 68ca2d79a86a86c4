// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/pre_inlet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <set>

#include "hemocell_adapter/base/messages.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/openings.h"

namespace packmesh::hemocell {
namespace {

/// HemoCell enlarges the box of the fluid nodes of the slice by this many nodes.
constexpr int border = 1;

using Node = std::array<int, 3>;

/// Rectangle of nodes in a plane, both corners included.
struct Section {
  Node lo{}, hi{};
  std::int64_t fluid = 0;  ///< number of fluid nodes

  void add(const Node& node) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = fluid == 0 ? node[k] : std::min(lo[k], node[k]);
      hi[k] = fluid == 0 ? node[k] : std::max(hi[k], node[k]);
    }
    ++fluid;
  }
};

/// The nodes of a plane selected by the ranges.
Section window(const Lattice& lattice, int axis, int plane, const std::vector<NodeRange>& ranges) {
  Section all;
  for (int k = 0; k < 3; ++k) all.hi[k] = lattice.nodes()[k] - 1;
  all.lo[axis] = all.hi[axis] = plane;
  for (const NodeRange& range : ranges) {
    const int n = lattice.nodes()[range.axis];
    const std::int64_t lo = planeIn(range.lo, n), hi = planeIn(range.hi, n);
    if (lo < 0 || hi >= n || lo > hi)
      throw InputError(fmt::format(
          "the pre-inlet range {0} is invalid: expected an ascending range of nodes 0 to {2} along {1}",
          toString(range), "xyz"[range.axis], n - 1));
    all.lo[range.axis] = int(lo);
    all.hi[range.axis] = int(hi);
  }
  return all;
}

template <class Visit>
void forNodes(const Section& section, Visit&& visit) {
  for (int k = section.lo[2]; k <= section.hi[2]; ++k)
    for (int j = section.lo[1]; j <= section.hi[1]; ++j)
      for (int i = section.lo[0]; i <= section.hi[0]; ++i) visit(Node{i, j, k});
}

Section fluidIn(const Lattice& lattice, const Section& window) {
  Section fluid;
  forNodes(window, [&](const Node& n) {
    if (lattice.fluid(n[0], n[1], n[2])) fluid.add(n);
  });
  return fluid;
}

/// Connected components of the fluid in a plane (connected also across corners), the largest first.
std::vector<Section> outlinesIn(const Lattice& lattice, const Section& window) {
  std::set<Node> left;
  forNodes(window, [&](const Node& n) {
    if (lattice.fluid(n[0], n[1], n[2])) left.insert(n);
  });
  std::vector<Section> outlines;
  while (!left.empty()) {
    std::vector<Node> next = {*left.begin()};
    left.erase(left.begin());
    Section outline;
    while (!next.empty()) {
      const Node n = next.back();
      next.pop_back();
      outline.add(n);
      Section around;
      for (int k = 0; k < 3; ++k) {
        around.lo[k] = n[k] - 1;
        around.hi[k] = n[k] + 1;
      }
      forNodes(around, [&](const Node& neighbour) {
        if (left.erase(neighbour) > 0) next.push_back(neighbour);
      });
    }
    outlines.push_back(outline);
  }
  std::stable_sort(outlines.begin(), outlines.end(),
                   [](const Section& a, const Section& b) { return a.fluid > b.fluid; });
  return outlines;
}

/// A range that contains the first of the outlines and none of the others, if there is one.
std::optional<NodeRange> rangeOfFirst(const std::vector<Section>& outlines, int axis,
                                      const Lattice& lattice) {
  const Section& first = outlines.front();
  for (const int k : {(axis + 1) % 3, (axis + 2) % 3}) {
    const bool alone = std::all_of(outlines.begin() + 1, outlines.end(), [&](const Section& other) {
      return other.hi[k] < first.lo[k] || other.lo[k] > first.hi[k];
    });
    if (!alone) continue;
    return NodeRange{k, std::max(first.lo[k] - 1, 0), std::min(first.hi[k] + 1, lattice.nodes()[k] - 1)};
  }
  return {};
}

/// Lists outlines: "y 1 to 31, z 1 to 31 (700 fluid nodes); ...".
std::string listOf(const std::vector<Section>& outlines, int axis) {
  const int u = std::min((axis + 1) % 3, (axis + 2) % 3), v = std::max((axis + 1) % 3, (axis + 2) % 3);
  std::string list;
  constexpr std::size_t shown = 8;
  for (std::size_t i = 0; i < std::min(outlines.size(), shown); ++i)
    list +=
        fmt::format("{}{} {} to {}, {} {} to {} ({} fluid nodes)", i ? "; " : "", "xyz"[u], outlines[i].lo[u],
                    outlines[i].hi[u], "xyz"[v], outlines[i].lo[v], outlines[i].hi[v], outlines[i].fluid);
  if (outlines.size() > shown) list += fmt::format("; and {} more", outlines.size() - shown);
  return list;
}

/// @throws InputError if the fluid in a plane has several outlines
void requireOneOutline(const Lattice& lattice, int axis, const Section& plane) {
  const std::vector<Section> outlines = outlinesIn(lattice, plane);
  if (outlines.size() < 2) return;
  const int u = (axis + 1) % 3;
  const std::string first = toString(
      rangeOfFirst(outlines, axis, lattice).value_or(NodeRange{u, outlines[0].lo[u], outlines[0].hi[u]}));
  throw InputError(fmt::format(
      "the pre-inlet slice, plane {} of nodes along {}, has {} outlines: {}. Select the one used in the "
      "case's C++ code (slice.y1 = 42) with " +
          named("pre-inlet-range") +
          " {} or <preInletRange> {} </preInletRange>, "
          "which selects the first; a range that contains several selects them all",
      plane.lo[axis], "xyz"[axis], outlines.size(), listOf(outlines, axis), first, first));
}

int sliceOf(const Lattice& lattice, const PreInletPlace& place) {
  const int n = lattice.nodes()[place.axis];
  if (place.slice) {
    const std::int64_t slice = planeIn(*place.slice, n);
    if (slice < 0 || slice >= n)
      throw InputError(
          fmt::format("the pre-inlet slice {} is outside the lattice: planes of nodes are 0 to {}",
                      toString(*place.slice), n - 1));
    return int(slice);
  }
  for (int i = 0; i < n; ++i) {
    const int plane = place.atHighEnd ? n - 1 - i : i;
    if (fluidIn(lattice, window(lattice, place.axis, plane, {})).fluid > 0) return plane;
  }
  throw InputError("the vessel has no fluid node");
}

/// Position at which the surface is cut for a plane of nodes [µm]: that of the plane from which its flags are
/// taken, since the two planes at either x end copy planes further inside (see placeVessel); within the
/// surface.
double cutAt(const TriangleMesh& surface, int axis, int plane, const Lattice& lattice) {
  const int n = lattice.nodes()[0];
  if (axis == 0) plane = plane < 2 ? plane + 1 : std::min(plane, n - 3);
  const Box box = boundingBox(surface);
  // Away from the caps, where a plane has no outline.
  const double inset = 1e-6 * box.size()[axis];
  return std::clamp(plane * lattice.dx(), box.lo[axis] + inset, box.hi[axis] - inset);
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
  const Section plane = window(all, axis, slice, place.ranges), section = fluidIn(all, plane);
  if (section.fluid == 0)
    throw InputError(fmt::format("the pre-inlet slice, plane {} of nodes along {}, has no fluid node{}",
                                 slice, "xyz"[axis], place.ranges.empty() ? "" : " in that range"));
  if (place.ranges.empty()) requireOneOutline(all, axis, plane);
  Node lo{}, nodes{};
  for (int k = 0; k < 3; ++k) {
    lo[k] = std::max(section.lo[k] - border, 0);
    nodes[k] = std::min(section.hi[k] + border, all.nodes()[k] - 1) - lo[k] + 1;
  }
  nodes[axis] = lengthN + 1 + 2 * border;
  const int flags = std::clamp(slice + (place.atHighEnd ? -1 : 1), 0, all.nodes()[axis] - 1);
  PreInlet inlet{{}, Lattice(nodes, all.dx()), slice, flags};
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (const int k : {u, v})
    inlet.reachesBorder = inlet.reachesBorder || section.lo[k] == 0 || section.hi[k] == all.nodes()[k] - 1;
  std::vector<Vec2> fluid;  // nodes of one plane, in the coordinate system of the inlet
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j)
      for (int i = 0; i < nodes[0]; ++i) {
        const Node to = {i, j, k};
        Node from = {lo[0] + i, lo[1] + j, lo[2] + k};
        from[axis] = flags;
        const bool isFluid = all.fluid(from[0], from[1], from[2]);
        inlet.lattice.setFluid(i, j, k, isFluid);
        if (isFluid && to[axis] == 0) fluid.emplace_back(to[u] * all.dx(), to[v] * all.dx());
      }
  const Box kept = inlet.lattice.keptRegion();
  const Vec2 corner(lo[u] * all.dx(), lo[v] * all.dx());
  for (Polygon& loop : loopsOf(outlineAt(vessel.surface, axis, cutAt(vessel.surface, axis, flags, all)))) {
    for (Vec2& p : loop) p -= corner;
    if (std::none_of(fluid.begin(), fluid.end(), [&](const auto& p) { return contains(loop, p); })) continue;
    const TriangleMesh prism = prismOver(loop, axis, kept.lo[axis], kept.hi[axis]);
    const int first = static_cast<int>(inlet.surface.vertices.size());
    inlet.surface.vertices.insert(inlet.surface.vertices.end(), prism.vertices.begin(), prism.vertices.end());
    for (const Triangle& t : prism.triangles)
      inlet.surface.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  if (inlet.surface.triangles.empty())
    throw InputError(
        fmt::format("plane {} of nodes along {}, from which HemoCell takes the fluid nodes of the "
                    "pre-inlet, has no fluid nodes in the box of plane {}",
                    flags, "xyz"[axis], slice));
  return inlet;
}

}  // namespace packmesh::hemocell
