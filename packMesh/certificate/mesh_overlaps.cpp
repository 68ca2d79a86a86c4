// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/mesh_overlaps.h"

#include <utility>

#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/triangle_intersection.h"

namespace packmesh {

namespace {

struct BoxedTriangle {
  int triangle;
  Box box;
};

/// Triangles of a mesh whose boxes meet `part`.
void selectTriangles(const TriangleMesh& mesh, const Box& part, std::vector<BoxedTriangle>& selected) {
  selected.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 &a = mesh.corner(t, 0), &b = mesh.corner(t, 1), &c = mesh.corner(t, 2);
    const Box box{a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
    if (box.meets(part)) selected.push_back({static_cast<int>(t), box});
  }
}

/// Two meshes with their boxes. Their surfaces meet only where the boxes have a common part.
class PairOfMeshes {
 public:
  PairOfMeshes(const TriangleMesh& first, const Box& firstBox, const TriangleMesh& second,
               const Box& secondBox)
      : first_(first), second_(second), firstBox_(firstBox), secondBox_(secondBox) {}

  MeshRelation relation() const {
    if (!firstBox_.meets(secondBox_)) return MeshRelation::apart;
    if (surfacesMeet()) return MeshRelation::meet;
    if (!contains(firstBox_, secondBox_) && !contains(secondBox_, firstBox_)) return MeshRelation::apart;
    return relate(MeshHierarchy(first_), Placement(), MeshHierarchy(second_), Placement()).relation;
  }

 private:
  static bool contains(const Box& outer, const Box& inner) {
    return outer.contains(inner.lo) && outer.contains(inner.hi);
  }

  bool surfacesMeet() const {
    std::vector<BoxedTriangle> ofFirst, ofSecond;
    const Box common{firstBox_.lo.cwiseMax(secondBox_.lo), firstBox_.hi.cwiseMin(secondBox_.hi)};
    selectTriangles(first_, common, ofFirst);
    if (ofFirst.empty()) return false;
    selectTriangles(second_, common, ofSecond);
    for (const BoxedTriangle& a : ofFirst)
      for (const BoxedTriangle& b : ofSecond)
        if (a.box.meets(b.box) && trianglesMeet(first_.corner(a.triangle, 0), first_.corner(a.triangle, 1),
                                                first_.corner(a.triangle, 2), second_.corner(b.triangle, 0),
                                                second_.corner(b.triangle, 1), second_.corner(b.triangle, 2)))
          return true;
    return false;
  }

  const TriangleMesh &first_, &second_;
  const Box &firstBox_, &secondBox_;
};

}  // namespace

std::vector<OverlappingPair> findMeshOverlaps(const std::vector<TriangleMesh>& meshes,
                                              const Threads& threads) {
  const auto count = static_cast<std::int64_t>(meshes.size());
  std::vector<Box> boxes(count);
  std::vector<Sphere> spheres(count);
  threads.forEach(count, [&](std::int64_t i, int) {
    boxes[i] = boundingBox(meshes[i]);
    // One percent larger than the box needs, so that rounding leaves out no pair of meeting boxes.
    spheres[i] = {boxes[i].center(), 0.505 * boxes[i].size().norm()};
  });
  const PeriodicNeighbors neighbors(std::move(spheres), Vec3::Zero());
  std::vector<std::vector<OverlappingPair>> found(count);
  threads.forEach(count, [&](std::int64_t i, int) {
    neighbors.forEachLater(i, 0.0, [&](const NearPair& pair) {
      const MeshRelation relation =
          PairOfMeshes(meshes[pair.first], boxes[pair.first], meshes[pair.second], boxes[pair.second])
              .relation();
      if (relation == MeshRelation::apart) return;
      found[i].push_back({pair.first, pair.second, Vec3::Zero(), relation != MeshRelation::meet, 0.0});
    });
  });
  std::vector<OverlappingPair> all;
  for (const std::vector<OverlappingPair>& own : found) all.insert(all.end(), own.begin(), own.end());
  sortByCells(all);
  return all;
}

}  // namespace packmesh
