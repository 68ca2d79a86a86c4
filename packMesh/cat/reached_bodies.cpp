// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/reached_bodies.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>

namespace packmesh {
namespace {

/// Edges longer than this [fraction of the cube root of the volume] make a triangle large: more than cells
/// reach in a step, and than triangles of finely divided surfaces have.
constexpr double longEdge = 0.25;

/// Vertices of a level of detail are points up to this gap [mean edge of the level]: where the gap is wider,
/// the coarser level shows where its middle is.
constexpr double gapPerEdge = 1.0;

std::vector<char> cornersOfLargeTriangles(const TriangleMesh& mesh, double size) {
  std::vector<char> corners(mesh.vertices.size(), 0);
  for (const Triangle& t : mesh.triangles) {
    double edge = 0.0;
    for (int k = 0; k < 3; ++k)
      edge = std::max(edge, (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm());
    if (edge > longEdge * size) corners[t[0]] = corners[t[1]] = corners[t[2]] = 1;
  }
  return corners;
}

double meanEdge(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) sum += (mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm();
  return sum / (3.0 * static_cast<double>(mesh.triangles.size()));
}

bool isRequested(const PlaneRequest& request, std::int64_t cell) {
  return std::binary_search(request.wanted.begin(), request.wanted.end(), cell);
}

int memberOf(const ReachedBodies& reached, std::int64_t cell) {
  return static_cast<int>(std::lower_bound(reached.members.begin(), reached.members.end(), cell) -
                          reached.members.begin());
}

bool isBefore(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

std::size_t bodyOf(const ReachedBodies& reached, int member, const Vec3& shift) {
  const auto before = [&](const TetrahedraBody& body, const Vec3& by) {
    return body.object != member ? body.object < member : isBefore(body.shift, by);
  };
  return std::lower_bound(reached.bodies.begin(), reached.bodies.end(), shift, before) -
         reached.bodies.begin();
}

/// Adds the vertices of all triangles with a chosen vertex of the mesh's own level of detail.
void addRing(const ReachingMesh& of, std::vector<char>& chosen) {
  const double own = *std::min_element(of.within.begin(), of.within.end());
  const std::vector<char> before = chosen;
  const auto isStart = [&](int v) { return before[v] && of.within[v] == own; };
  for (const Triangle& t : of.hierarchy.mesh().triangles)
    if (isStart(t[0]) || isStart(t[1]) || isStart(t[2])) chosen[t[0]] = chosen[t[1]] = chosen[t[2]] = 1;
}

}  // namespace

ReachedBodies bodiesWithinReach(const PlaneRequest& request) {
  ReachedBodies reached;
  reached.pairs = request.surroundings.pairsOf(request.wanted);
  std::vector<std::pair<std::int64_t, Vec3>> images;
  for (const std::int64_t cell : request.wanted) images.emplace_back(cell, Vec3::Zero());
  for (const NearPair& pair : reached.pairs) {
    if (isRequested(request, pair.first)) images.emplace_back(pair.second, pair.shift);
    if (isRequested(request, pair.second)) images.emplace_back(pair.first, -pair.shift);
  }
  std::sort(images.begin(), images.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : isBefore(a.second, b.second);
  });
  images.erase(std::unique(images.begin(), images.end()), images.end());
  for (const auto& [cell, shift] : images) {
    if (reached.members.empty() || reached.members.back() != cell) reached.members.push_back(cell);
    reached.bodies.push_back({static_cast<int>(reached.members.size()) - 1, shift,
                              shift.isZero(0.0) && isRequested(request, cell)});
  }
  return reached;
}

std::vector<std::unique_ptr<const ReachingMesh>> reachingMeshes(const LevelsOfDetail& levels, double size) {
  std::vector<std::unique_ptr<const ReachingMesh>> meshes(levels.count());
  std::map<std::array<double, 3>, double> within;  // of the vertices of coarser levels
  for (int level = levels.count() - 1; level >= 0; --level) {
    const TriangleMesh& mesh = levels.mesh(level);
    const double most =
        level + 1 < levels.count() ? gapPerEdge * meanEdge(mesh) : std::numeric_limits<double>::infinity();
    ReachingMesh of{MeshHierarchy(mesh), cornersOfLargeTriangles(mesh, size), {}};
    for (const Vec3& v : mesh.vertices)
      of.within.push_back(within.emplace(std::array{v.x(), v.y(), v.z()}, most).first->second);
    meshes[level] = std::make_unique<const ReachingMesh>(std::move(of));
  }
  return meshes;
}

std::vector<std::vector<char>> pointsWithinReach(const PlaneRequest& request, const ReachedBodies& reached,
                                                 const std::vector<const ReachingMesh*>& meshes,
                                                 const ChordPlanes& chords) {
  std::vector<std::vector<char>> points;
  for (const TetrahedraBody& body : reached.bodies) points.push_back(meshes[body.object]->always);
  std::array<std::vector<char>, 2> marks;
  for (const NearPair& pair : reached.pairs) {
    const int member[] = {memberOf(reached, pair.first), memberOf(reached, pair.second)};
    for (int k = 0; k < 2; ++k) marks[k].assign(meshes[member[k]]->always.size(), 0);
    const auto vertices = [&](int k) {
      const ReachingMesh& of = *meshes[member[k]];
      return ChordPlanes::Vertices{&of.hierarchy.mesh().vertices, &of.within};
    };
    chords.markWithinReach(request, pair, {vertices(0), vertices(1)}, {&marks[0], &marks[1]});
    const auto add = [&](int k, const Vec3& shift) {
      std::vector<char>& of = points[bodyOf(reached, member[k], shift)];
      for (std::size_t v = 0; v < of.size(); ++v) of[v] |= marks[k][v];
    };
    if (isRequested(request, pair.first)) {
      add(0, Vec3::Zero());
      add(1, pair.shift);
    }
    if (isRequested(request, pair.second)) {
      add(0, -pair.shift);
      add(1, Vec3::Zero());
    }
  }
  for (std::size_t b = 0; b < points.size(); ++b) addRing(*meshes[reached.bodies[b].object], points[b]);
  return points;
}

}  // namespace packmesh
