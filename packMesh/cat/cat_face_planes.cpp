// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_face_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/thread_timer.h"
#include "packMesh/core/timer.h"
#include "packMesh/cat/chordal_split.h"
#include "packMesh/cat/face_planes.h"
#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/cat/tetrahedralise.h"
#include "packMesh/parallel/watched_loop.h"

namespace packmesh {
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
  for (std::size_t s = 0; s < physics.species.size(); ++s)
    levels_.push_back(
        reachingMeshes(chords_.levels(static_cast<int>(s)), std::cbrt(physics.shapeOf(s).volume())));
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

int CatFacePlanes::levelOf(const PlaneRequest& request, int species, int coarsest) const {
  return std::min(coarsest, chords_.levels(species).indexOf(request.detail));
}

void CatFacePlanes::place(const PlaneRequest& request, const ReachedBodies& reached, int level,
                          TetrahedraInput& input) const {
  input.objects.clear();
  std::vector<const ReachingMesh*> meshes;
  for (const std::int64_t member : reached.members) {
    const Body& cell = request.surroundings.cells()[member];
    meshes.push_back(levels_[cell.species][levelOf(request, cell.species, level)].get());
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

}  // namespace packmesh
