// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/vessel_ends.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/core/vector_text.h"
#include "packMesh/mesh/merge_vertices.h"
#include "packMesh/mesh/triangle_tree.h"

namespace packmesh {
namespace {

using Segment = std::array<Eigen::Vector2d, 2>;

double distanceToSegment(const Eigen::Vector2d& p, const Segment& s) {
  const Eigen::Vector2d along = s[1] - s[0];
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((p - s[0]).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (s[0] + t * along - p).norm();
}

/// The point of `from` furthest from `to`, and its distance.
std::pair<double, Eigen::Vector2d> furthest(const std::vector<Segment>& from,
                                            const std::vector<Segment>& to) {
  TriangleMesh segments;  // for the search: their boxes are those of triangles with two equal corners
  for (const Segment& t : to) {
    const int n = static_cast<int>(segments.vertices.size());
    for (const Eigen::Vector2d& p : t) segments.vertices.emplace_back(p.x(), p.y(), 0.0);
    segments.triangles.push_back({n, n + 1, n + 1});
  }
  const TriangleTree tree(segments);
  std::pair<double, Eigen::Vector2d> worst(0.0, Eigen::Vector2d::Zero());
  for (const Segment& s : from)
    for (const Eigen::Vector2d& p : {s[0], Eigen::Vector2d(0.5 * (s[0] + s[1])), s[1]}) {
      double nearest = std::numeric_limits<double>::infinity();
      tree.visitNearer({p.x(), p.y(), 0.0}, nearest, [&](int t) {
        nearest = std::min(nearest, distanceToSegment(p, to[t]));
        return nearest * nearest;
      });
      if (nearest > worst.first) worst = {nearest, p};
    }
  return worst;
}

/// Separates wall and caps; an end can have no caps.
OpenedVessel takenApart(const TriangleMesh& surface, int axis) {
  const Box box = boundingBox(surface);
  const double near = tolerance::flatCapFraction * box.size().norm();
  OpenedVessel out;
  out.mesh.vertices = surface.vertices;
  out.axis = axis;
  out.lo = box.lo[axis];
  out.hi = box.hi[axis];
  for (const Triangle& t : surface.triangles) {
    bool low = true, high = true;
    for (const int v : t) {
      low &= surface.vertices[v][axis] <= out.lo + near;
      high &= surface.vertices[v][axis] >= out.hi - near;
    }
    if (low)
      out.caps[0].push_back(t);
    else if (high)
      out.caps[1].push_back(t);
    else
      out.mesh.triangles.push_back(t);
  }
  return out;
}

}  // namespace

bool hasFlatEnds(const TriangleMesh& surface, int axis) {
  const OpenedVessel opened = takenApart(surface, axis);
  return !opened.caps[0].empty() && !opened.caps[1].empty();
}

OpenedVessel openVessel(const TriangleMesh& surface, int axis) {
  OpenedVessel out = takenApart(surface, axis);
  for (int end = 0; end < 2; ++end)
    if (out.caps[end].empty())
      throw MeshError("the vessel has no flat end perpendicular to " + std::string(axisName[axis]) + " at " +
                      axisName[axis] + " = " + toText(end == 0 ? out.lo : out.hi) +
                      " µm: the mesh must be closed there by triangles in one plane");
  return out;
}

double OpenedVessel::capArea(int end) const {
  double twice = 0.0;
  for (const Triangle& t : caps[end]) {
    const Vec3& a = mesh.vertices[t[0]];
    twice += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a)[axis];
  }
  return 0.5 * std::abs(twice);
}

TriangleMesh OpenedVessel::continued(double newLo, double newHi, bool closed) const {
  TriangleMesh out = mesh;
  for (int end = 0; end < 2; ++end) {
    const double target = end == 0 ? newLo : newHi;
    const bool further = end == 0 ? target < lo : target > hi;
    if (!further) {
      if (closed) out.triangles.insert(out.triangles.end(), caps[end].begin(), caps[end].end());
      continue;
    }
    // Copies of the vertices of the cap, in the target plane.
    std::vector<int> copy(mesh.vertices.size(), -1);
    std::vector<std::pair<int, int>> sides;
    for (const Triangle& t : caps[end])
      for (int k = 0; k < 3; ++k) {
        if (copy[t[k]] < 0) {
          copy[t[k]] = static_cast<int>(out.vertices.size());
          out.vertices.push_back(mesh.vertices[t[k]]);
          out.vertices.back()[axis] = target;
        }
        sides.emplace_back(t[k], t[(k + 1) % 3]);
      }
    // A strip of wall replaces the border of the cap.
    std::sort(sides.begin(), sides.end());
    for (const auto& [a, b] : sides)
      if (!std::binary_search(sides.begin(), sides.end(), std::pair(b, a)))
        out.triangles.insert(out.triangles.end(), {{a, b, copy[b]}, {a, copy[b], copy[a]}});
    if (closed)
      for (const Triangle& t : caps[end]) out.triangles.push_back({copy[t[0]], copy[t[1]], copy[t[2]]});
  }
  removeUnusedVertices(out);
  return out;
}

std::vector<Segment> outlineAt(const TriangleMesh& mesh, int axis, double x) {
  std::vector<Segment> outline;
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Eigen::Vector2d ends[2];
    int found = 0;
    for (int k = 0; k < 3; ++k) {
      // Both triangles at an edge compute the same point, from the same vertices in the same order.
      const auto [from, to] = std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]);
      const Vec3 &a = mesh.vertices[from], &b = mesh.vertices[to];
      if ((a[axis] < x) == (b[axis] < x)) continue;
      const double s = (x - a[axis]) / (b[axis] - a[axis]);
      ends[found++] = {a[u] + s * (b[u] - a[u]), a[v] + s * (b[v] - a[v])};
    }
    if (found == 2) outline.push_back({ends[0], ends[1]});
  }
  return outline;
}

void requireSameOutlines(const TriangleMesh& closed, int axis, double lo, double hi) {
  // Slightly inside, where the mesh certainly extends to.
  const double inset = tolerance::flatCapFraction * boundingBox(closed).size().norm();
  const std::vector<Segment> low = outlineAt(closed, axis, lo + inset),
                             high = outlineAt(closed, axis, hi - inset);
  const std::string where =
      std::string(" (") + axisName[axis] + " = " + toText(lo) + " and " + toText(hi) + " µm)";
  if (low.empty() || high.empty())
    throw MeshError("a periodic vessel must extend to both of its ends" + where + ", but its mesh does not");
  Eigen::AlignedBox2d box;
  for (const std::vector<Segment>* outline : {&low, &high})
    for (const Segment& s : *outline) box.extend(s[0]).extend(s[1]);
  const double allowed = tolerance::sameOutlineFraction * box.sizes().norm();
  for (int side = 0; side < 2; ++side) {
    const auto [distance, at] = side == 0 ? furthest(low, high) : furthest(high, low);
    if (distance > allowed)
      throw MeshError("the two ends of a periodic vessel must have the same outline" + where + ", but at (" +
                      axisName[(axis + 1) % 3] + ", " + axisName[(axis + 2) % 3] + ") = (" + toText(at.x()) +
                      ", " + toText(at.y()) + ") they differ by " + toText(distance, 3) + " µm, more than " +
                      toText(allowed, 3) + " µm");
  }
}

TriangleMesh withImages(const TriangleMesh& wall, int axis, double lo, double hi, double reach) {
  TriangleMesh out = wall;
  const double period = hi - lo;
  const int images = static_cast<int>(std::ceil(reach / period));
  for (int image = -images; image <= images; ++image) {
    if (image == 0) continue;
    std::vector<int> copy(wall.vertices.size(), -1);
    for (const Triangle& t : wall.triangles) {
      double first = std::numeric_limits<double>::infinity(), last = -first;
      for (const int v : t) {
        first = std::min(first, wall.vertices[v][axis] + image * period);
        last = std::max(last, wall.vertices[v][axis] + image * period);
      }
      if (first > hi + reach || last < lo - reach) continue;
      Triangle shifted;
      for (int k = 0; k < 3; ++k) {
        if (copy[t[k]] < 0) {
          copy[t[k]] = static_cast<int>(out.vertices.size());
          out.vertices.push_back(wall.vertices[t[k]]);
          out.vertices.back()[axis] += image * period;
        }
        shifted[k] = copy[t[k]];
      }
      out.triangles.push_back(shifted);
    }
  }
  return out;
}

}  // namespace packmesh
