// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/overlap_finder.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/triangle_pair.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {
namespace {

/// Cells that a thread examines at a time.
constexpr std::int64_t searchedPerPart = 64;

}  // namespace

OverlapFinder::OverlapFinder(const CertificateInput& input, const PeriodicNeighbors& neighbors,
                             std::vector<Vec3> positions)
    : input_(input), cells_(input), listed_(std::move(positions)), neighbors_(neighbors) {}

/// With the shift between the cells where they are now: each may have been moved by whole periods.
NearPair OverlapFinder::asPlaced(const NearPair& pair) const {
  NearPair out = pair;
  if (!input_.container) return out;
  const Vec3 period = input_.container->period();
  const auto moved = [&](std::int64_t cell, int k) {
    return std::round((cells_.placement(cell).translation[k] - listed_[cell][k]) / period[k]);
  };
  for (int k = 0; k < 3; ++k) {
    if (!(period[k] > 0.0)) continue;
    const double periods = moved(pair.first, k) - moved(pair.second, k);
    if (periods != 0.0) out.shift[k] = (std::round(pair.shift[k] / period[k]) + periods) * period[k];
  }
  return out;
}

std::vector<OverlappingPair> OverlapFinder::operator()(const std::vector<std::int64_t>& moved) const {
  std::vector<char> isMoved(cells_.count(), 0);
  for (const std::int64_t i : moved) isMoved[i] = 1;
  PerThread<std::vector<OverlappingPair>> found(input_.threads);
  const auto examine = [&](std::int64_t i, std::vector<OverlappingPair>& faults) {
    const auto wanted = [&](std::int64_t other) {
      if (other < i && isMoved[other]) return false;  // examined from the other cell
      return cells_.isOwn(i) || cells_.isOwn(other);
    };
    neighbors_.forEachNear(i, input_.requiredGap, wanted, [&](const NearPair& near) {
      const NearPair pair = asPlaced(near);
      if (cells_.leastGap(pair) > input_.requiredGap) return;
      const MeshPairResult result = cells_.relation(pair, input_.requiredGap);
      if (const auto fault = cells_.faultOf(pair, result)) faults.push_back(*fault);
    });
  };
  input_.threads.forEachPart(
      static_cast<std::int64_t>(moved.size()),
      [&](std::int64_t begin, std::int64_t end, int thread) {
        for (std::int64_t k = begin; k < end; ++k) examine(moved[k], found[thread]);
      },
      searchedPerPart);
  std::vector<OverlappingPair> out;
  found.forEach([&](const auto& faults) { out.insert(out.end(), faults.begin(), faults.end()); });
  sortByCells(out);
  return out;
}

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
    if (isWithin(second_, first_)) return MeshRelation::secondInside;
    return isWithin(first_, second_) ? MeshRelation::firstInside : MeshRelation::apart;
  }

 private:
  static bool contains(const Box& outer, const Box& inner) {
    return outer.contains(inner.lo) && outer.contains(inner.hi);
  }

  /// Pre: the surfaces do not meet
  static bool isWithin(const TriangleMesh& inner, const TriangleMesh& outer) {
    return isInside(inner.corner(0, 0), MeshHierarchy(outer), Placement());
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

PeriodicNeighbors neighborsOf(const std::vector<Box>& boxes, const Vec3& period) {
  std::vector<Sphere> spheres;
  // One percent larger than the box needs, so that rounding leaves out no pair of meeting boxes.
  for (const Box& box : boxes) spheres.push_back({box.center(), 0.505 * box.size().norm()});
  return {std::move(spheres), period};
}

std::vector<std::int64_t> firstOf(const std::vector<MeshesOfKinds::Kind>& kinds) {
  std::vector<std::int64_t> first = {0};
  for (const MeshesOfKinds::Kind& kind : kinds) first.push_back(first.back() + kind.count);
  return first;
}

std::vector<Box> boxesOf(const MeshesOfKinds& meshes, const Threads& threads) {
  std::vector<Box> boxes;
  for (std::size_t k = 0; k < meshes.kinds.size(); ++k) {
    const std::size_t first = boxes.size();
    boxes.resize(first + std::size_t(meshes.kinds[k].count));
    threads.forEach(meshes.kinds[k].count, [&](std::int64_t i, int) {
      std::vector<Vec3> vertices;
      meshes.make(k, i, vertices);
      for (const Vec3& v : vertices) boxes[first + std::size_t(i)].add(v);
    });
  }
  return boxes;
}

}  // namespace

MeshOverlaps::MeshOverlaps(MeshesOfKinds meshes, const Vec3& period, const Threads& threads)
    : meshes_(std::move(meshes)),
      first_(firstOf(meshes_.kinds)),
      threads_(threads),
      boxes_(boxesOf(meshes_, threads)),
      neighbors_(neighborsOf(boxes_, period)),
      order_(neighbors_.spatialOrder()) {
  for (std::size_t k = 0; k < meshes_.kinds.size(); ++k) {
    TriangleMesh typical;
    if (meshes_.kinds[k].count > 0) make(first_[k], typical);
    finders_.emplace_back(typical);
  }
}

std::size_t MeshOverlaps::kindOf(std::int64_t mesh) const {
  return std::size_t(std::upper_bound(first_.begin(), first_.end(), mesh) - first_.begin()) - 1;
}

void MeshOverlaps::make(std::int64_t mesh, TriangleMesh& made) const {
  const std::size_t kind = kindOf(mesh);
  made.triangles = meshes_.kinds[kind].triangles;
  meshes_.make(kind, mesh - first_[kind], made.vertices);
}

MeshFaults MeshOverlaps::examine(std::int64_t begin, std::int64_t end) const {
  std::vector<MeshFaults> found(std::size_t(end - begin));
  threads_.forEach(end - begin, [&](std::int64_t n, int) {
    const std::int64_t i = order_[begin + n];
    TriangleMesh own, other;
    make(i, own);
    MeshFaults& faults = found[std::size_t(n)];
    if (const auto pair = finders_[kindOf(i)](own.vertices))
      faults.selfIntersecting.push_back({i, pair->first, pair->second});
    neighbors_.forEachLater(i, 0.0, [&](const NearPair& pair) {
      const Box& box = boxes_[pair.second];
      const Box moved{box.lo + pair.shift, box.hi + pair.shift};
      if (!boxes_[i].grownBy(tolerance::culling).meets(moved)) return;
      make(pair.second, other);
      for (Vec3& v : other.vertices) v += pair.shift;
      const MeshRelation relation = PairOfMeshes(own, boxes_[i], other, boundingBox(other)).relation();
      if (relation == MeshRelation::apart) return;
      faults.overlapping.push_back({i, pair.second, pair.shift, relation != MeshRelation::meet, 0.0});
    });
  });
  MeshFaults all;
  for (const MeshFaults& one : found) {
    all.overlapping.insert(all.overlapping.end(), one.overlapping.begin(), one.overlapping.end());
    all.selfIntersecting.insert(all.selfIntersecting.end(), one.selfIntersecting.begin(),
                                one.selfIntersecting.end());
  }
  sortByCells(all.overlapping);
  std::sort(all.selfIntersecting.begin(), all.selfIntersecting.end(),
            [](const SelfIntersectingCell& a, const SelfIntersectingCell& b) { return a.cell < b.cell; });
  return all;
}

}  // namespace packmesh
