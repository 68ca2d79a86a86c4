// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_face_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/core/error.h"
#include "packMesh/core/timer.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {
namespace {

/// The faces of a tetrahedron with four labels are successive pairs, each in a common plane.
bool repeatsPlane(const std::vector<ChordalFace>& faces, std::size_t f) {
  return f > 0 && faces[f - 1].tetrahedron == faces[f].tetrahedron && faces[f - 1].first == faces[f].first &&
         faces[f - 1].second == faces[f].second;
}

/// Largest cosine of the angle between a face's normal and an edge that it cuts.
double largestCosine(const Tetrahedra& t, const ChordalFace& face) {
  double largest = 0.0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (face.first >> i & 1 && face.second >> j & 1) {
        const Vec3 edge = t.corner(face.tetrahedron, j) - t.corner(face.tetrahedron, i);
        largest = std::max(largest, face.normal.dot(edge) / edge.norm());
      }
  return largest;
}

}  // namespace

PlaneConstraints planesOfFaces(const Tetrahedra& t, const ChordalFaces& split,
                               const std::vector<PlacedMesh>& objects, double minimumCosine,
                               const std::vector<double>& reach) {
  std::vector<Mat3> inverse;
  for (const PlacedMesh& object : objects) inverse.push_back(object.placement.linear.inverse());
  double farthest = std::numeric_limits<double>::infinity();
  if (!reach.empty()) farthest = *std::max_element(reach.begin(), reach.end());
  PlaneConstraints planes(objects.size());
  for (std::size_t f = 0; f < split.faces.size(); ++f) {
    const ChordalFace& face = split.faces[f];
    if (face.away > farthest) continue;
    if (repeatsPlane(split.faces, f) || (minimumCosine > 0.0 && largestCosine(t, face) < minimumCosine))
      continue;
    for (int k = 0; k < 4; ++k) {
      const int p = t.tetrahedra[face.tetrahedron][k], label = t.labels[p];
      const bool first = face.first >> k & 1;
      if (!(first || face.second >> k & 1) || !t.isPrimary(label)) continue;
      const TetrahedraBody& body = t.bodies[label];
      if (!reach.empty() && std::abs(face.normal.dot(face.point - t.points[p])) > reach[body.object])
        continue;
      const PlacedMesh& object = objects[body.object];
      const Vec3 given = t.points[p] - body.shift;
      const Vec3 vertex = t.vertices[p] >= 0
                              ? object.mesh->mesh().vertices[t.vertices[p]]
                              : Vec3(inverse[body.object] * (given - object.placement.translation));
      planes[body.object].push_back(
          {vertex, face.point - body.shift, first ? face.normal : Vec3(-face.normal)});
    }
  }
  return planes;
}

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

namespace {

/// Limit of the cosine between the normal of a face and the gap, below which a face belongs to a sliver (see
/// planesOfFaces()). More faces constrain cells more than others do: with 0.3, 300 cells at 0.30 need 70
/// iterations, with 0.5 43.
constexpr double sliverCosine = 0.5;

/// Cells per request: few enough for all threads to have some, and enough for the surfaces around them, which
/// are included in several requests, to be few.
constexpr std::int64_t cellsOfRequest = 160;

/// TetGen takes most of the time. Between two runs, the corners of its tetrahedra move with the cells: for so
/// few iterations, their faces remain nearly those of new tetrahedra.
constexpr std::int64_t iterationsPerRun = 4;

/// Fewer points have no tetrahedra.
constexpr std::ptrdiff_t fewestPoints = 4;

}  // namespace

CatFacePlanes::CatFacePlanes(const Physics& physics, const Execution& execution, TetrahedraSums& sums,
                             int failingAttempts)
    : physics_(physics), execution_(execution), chords_(physics), sums_(sums) {
  levels_.resize(physics.shapes.size());
  for (const int s : physics.shapesInUse())
    levels_[s] = reachingMeshes(chords_.levels(s), std::cbrt(physics.shapes[s]->volume()));
  input_.period = physics.container->period();
  input_.bounds = physics.container->bounds();
  input_.kept = TetrahedraKept::joining;
  input_.explain = false;
  input_.failingAttempts = failingAttempts;
}

std::int64_t CatFacePlanes::cellsAtOnce() const {
  return cellsOfRequest;
}

std::int64_t CatFacePlanes::lifetime() const {
  return iterationsPerRun;
}

void CatFacePlanes::begin(const std::vector<PlaneRequest>& requests) {
  const Timer watch(sums_.tetrahedraSeconds);
  around_.resize(requests.size());
  WatchedLoop loop(execution_.threads, execution_.interrupted);
  loop.forEach(static_cast<std::int64_t>(requests.size()), [&](std::int64_t k, int thread) {
    tetrahedralise(
        requests[k], [&loop, thread] { return loop.stops(thread); }, around_[k]);
  });
  for (const Around& around : around_) {
    sums_.runs += around.sums.runs;
    sums_.attempts += around.sums.attempts;
    sums_.finer += around.sums.finer;
    sums_.failures += around.sums.failures;
    if (around.sums.failures > 0) sums_.lastFailure = around.sums.lastFailure;
  }
}

void CatFacePlanes::operator()(const PlaneRequest& request, std::vector<CellPlanes>& planes) {
  Around& around = around_[request.batch];
  if (!request.anew) follow(request, around);
  if (around.sums.failures > 0) return chords_(request, planes);
  double seconds = 0.0;
  chords_.addAtWalls(request, planes);
  {
    const ThreadTimer watch(seconds);
    ChordalFaces split;
    splitChordally(around.tetrahedra, WallFaces::atWall, split);
    std::vector<double> reach;
    for (const std::int64_t cell : around.members) reach.push_back(request.surroundings.reach(cell));
    const PlaneConstraints found =
        planesOfFaces(around.tetrahedra, split, around.objects, sliverCosine, reach);
    for (std::size_t object = 0; object < found.size(); ++object) {
      const std::int64_t cell = around.members[object];
      const auto at = std::lower_bound(request.wanted.begin(), request.wanted.end(), cell);
      if (at == request.wanted.end() || *at != cell) continue;
      const Pose pose = request.surroundings.cells()[cell].pose();
      for (const PlaneConstraint& plane : found[object]) planes[at - request.wanted.begin()].add(pose, plane);
    }
  }
  const std::lock_guard lock(sumsMutex_);
  sums_.faceSeconds += seconds;
}

int CatFacePlanes::levelOf(const PlaneRequest& request, int shape, int coarsest) const {
  return std::min(coarsest, chords_.levels(shape).indexOf(request.detail));
}

void CatFacePlanes::place(const PlaneRequest& request, const ReachedBodies& reached, int level,
                          TetrahedraInput& input) const {
  input.objects.clear();
  std::vector<const ReachingMesh*> meshes;
  for (const std::int64_t member : reached.members) {
    const Body& cell = request.surroundings.cells()[member];
    meshes.push_back(levels_[cell.shape][levelOf(request, cell.shape, level)].get());
    input.objects.push_back({&meshes.back()->hierarchy, physics_.placement(cell.pose())});
  }
  input.points = pointsWithinReach(request, reached, meshes, chords_);
}

/// @param stop see TetrahedraInput
void CatFacePlanes::tetrahedralise(const PlaneRequest& request, const std::function<bool()>& stop,
                                   Around& around) const {
  around = Around();
  const ReachedBodies reached = bodiesWithinReach(request);
  int coarsest = 0;
  for (std::size_t s = 0; s < levels_.size(); ++s)
    if (!levels_[s].empty())
      coarsest = std::max(coarsest, chords_.levels(static_cast<int>(s)).indexOf(request.detail));
  TetrahedraInput input = input_;
  input.bodies = reached.bodies;
  input.stop = stop;
  for (int level = coarsest; level >= 0; --level) {
    input.valid = level == 0;  // the cells themselves are known not to overlap
    place(request, reached, level, input);
    std::ptrdiff_t points = 0;
    for (const std::vector<char>& of : input.points) points += std::count(of.begin(), of.end(), 1);
    if (points < fewestPoints) return;
    around.members = reached.members;
    around.objects = input.objects;
    around.sums.runs = 1;
    try {
      around.tetrahedra = packmesh::tetrahedralise(input);
      around.sums.attempts += around.tetrahedra.attempts;
      return;
    } catch (const TetrahedraError& error) {
      around.sums.attempts += error.attempts();
      around.sums.lastFailure = error.what();
      break;
    } catch (const InputError&) {  // coarse levels overlap
      ++around.sums.finer;
    }
  }
  around.sums.failures = 1;
}

/// Moves the points of the tetrahedra with their cells.
void CatFacePlanes::follow(const PlaneRequest& request, Around& around) const {
  Tetrahedra& t = around.tetrahedra;
  std::vector<Placement> before;
  std::vector<Vec3> wrap;  // periods by which each object has been wrapped since
  for (std::size_t object = 0; object < around.members.size(); ++object) {
    Placement& placement = around.objects[object].placement;
    before.push_back(placement);
    placement = physics_.placement(request.surroundings.cells()[around.members[object]].pose());
    Vec3 periods = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      if (input_.period[k] > 0.0)
        periods[k] = input_.period[k] *
                     std::round((placement.translation[k] - before.back().translation[k]) / input_.period[k]);
    wrap.push_back(periods);
  }
  std::vector<Mat3> inverse;
  for (const Placement& placement : before) inverse.push_back(placement.linear.inverse());
  for (std::size_t p = 0; p < t.points.size(); ++p) {
    if (t.labels[p] == wallLabel) continue;
    const TetrahedraBody& body = t.bodies[t.labels[p]];
    const PlacedMesh& object = around.objects[body.object];
    const Vec3 vertex =
        t.vertices[p] >= 0
            ? object.mesh->mesh().vertices[t.vertices[p]]
            : Vec3(inverse[body.object] * (t.points[p] - body.shift - before[body.object].translation));
    t.points[p] = object.placement(vertex) + body.shift - wrap[body.object];
  }
  for (TetrahedraBody& body : t.bodies) body.shift -= wrap[body.object];
}

std::unique_ptr<PlaneFunction> makePlaneFunction(PlaneSource planeSource, const Physics& physics,
                                                 const Execution& execution, TetrahedraSums& sums) {
  if (planeSource == PlaneSource::chords) return std::make_unique<ChordPlanes>(physics);
  return std::make_unique<CatFacePlanes>(physics, execution, sums);
}

}  // namespace packmesh
