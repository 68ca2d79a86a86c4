// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/cat_face_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/timer.h"
#include "packMesh/growth/face_planes.h"
#include "packMesh/growth/levels_of_detail.h"
#include "packMesh/growth/tetrahedralise.h"

namespace packmesh {
namespace {

/// Limit of the cosine between the normal of a face and the gap, below which a face belongs to a sliver (see
/// planesOfFaces()).
constexpr double sliverCosine = 0.3;

/// Cells per block: the surrounding cells, which are included in the runs of several blocks, should not
/// outnumber them.
constexpr std::int64_t cellsOfBlock = 100;

/// TetGen takes nearly all of the time. Between two runs, the corners of its tetrahedra move with the cells:
/// for so few iterations, their faces remain nearly those of new tetrahedra.
constexpr std::int64_t iterationsPerRun = 4;

/// Which vertices of a mesh are also vertices of another.
std::vector<char> sharedVertices(const TriangleMesh& mesh, const TriangleMesh& other) {
  const auto key = [](const Vec3& v) { return std::array<double, 3>{v.x(), v.y(), v.z()}; };
  std::set<std::array<double, 3>> others;
  for (const Vec3& v : other.vertices) others.insert(key(v));
  std::vector<char> shared;
  for (const Vec3& v : mesh.vertices) shared.push_back(others.count(key(v)) > 0);
  return shared;
}

/// Adds the vertices of all triangles with a chosen vertex.
void addRing(const TriangleMesh& mesh, std::vector<char>& chosen) {
  const std::vector<char> before = chosen;
  for (const Triangle& t : mesh.triangles)
    if (before[t[0]] || before[t[1]] || before[t[2]]) chosen[t[0]] = chosen[t[1]] = chosen[t[2]] = 1;
}

}  // namespace

CatFacePlanes::CatFacePlanes(const Physics& physics, const Execution& execution, TetrahedraSums& sums,
                             int failingAttempts)
    : physics_(physics), execution_(execution), chords_(physics), sums_(sums) {
  for (std::size_t s = 0; s < physics.species.size(); ++s) {
    const LevelsOfDetail& levels = chords_.levels(static_cast<int>(s));
    levels_.emplace_back();
    outlines_.emplace_back();
    for (int level = 0; level < levels.count(); ++level) {
      levels_.back().push_back(std::make_unique<MeshHierarchy>(levels.mesh(level)));
      outlines_.back().push_back(sharedVertices(levels.mesh(level), levels.mesh(levels.count() - 1)));
    }
  }
  input_.period = physics.container->period();
  input_.bounds = physics.container->bounds();
  input_.kept = TetrahedraKept::joining;
  input_.explain = false;
  input_.failingAttempts = failingAttempts;
}

std::int64_t CatFacePlanes::cellsAtOnce() const {
  return cellsOfBlock;
}

std::int64_t CatFacePlanes::lifetime() const {
  return iterationsPerRun;
}

PlaneConstraints CatFacePlanes::operator()(const PlaneRequest& request) {
  if (request.wanted.empty()) return {};
  if (around_.size() <= request.batch) around_.resize(request.batch + 1);
  Around& around = around_[request.batch];
  if (request.anew)
    tetrahedralise(request, around);
  else
    follow(request, around);
  if (around.failed) return chords_(request);
  const Timer watch(sums_.faceSeconds);
  splitChordally(around.tetrahedra, WallFaces::atWall, split_);
  std::vector<double> reach;
  for (const std::int64_t cell : around.members) reach.push_back(request.surroundings.reach(cell));
  PlaneConstraints planes = chords_.atWalls(request);
  const PlaneConstraints found =
      planesOfFaces(around.tetrahedra, split_, around.objects, sliverCosine, reach);
  for (std::size_t object = 0; object < found.size(); ++object) {
    const std::int64_t cell = around.members[object];
    const auto at = std::lower_bound(request.wanted.begin(), request.wanted.end(), cell);
    if (at == request.wanted.end() || *at != cell) continue;
    std::vector<PlaneConstraint>& of = planes[at - request.wanted.begin()];
    of.insert(of.end(), found[object].begin(), found[object].end());
  }
  return planes;
}

int CatFacePlanes::levelOf(const PlaneRequest& request, int species, int coarsest) const {
  return std::min(coarsest, chords_.levels(species).indexOf(request.detail));
}

/// Chooses the points: the vertices within reach of another cell, and of the remaining surfaces few.
void CatFacePlanes::choosePoints(const PlaneRequest& request, const Around& around, int coarsest) {
  std::vector<std::vector<char>>& points = input_.points;
  points.assign(around.members.size(), {});
  const auto meshOf = [&](std::size_t object) { return &input_.objects[object].mesh->mesh(); };
  const auto objectOf = [&](std::int64_t cell) {
    return static_cast<std::size_t>(std::lower_bound(around.members.begin(), around.members.end(), cell) -
                                    around.members.begin());
  };
  for (std::size_t object = 0; object < points.size(); ++object)
    points[object].assign(meshOf(object)->vertices.size(), 0);
  for (const NearPair& pair : around.pairs) {
    const std::size_t a = objectOf(pair.first), b = objectOf(pair.second);
    chords_.markWithinReach(request, pair, {meshOf(a), meshOf(b)}, {&points[a], &points[b]});
  }
  for (std::size_t object = 0; object < points.size(); ++object) {
    addRing(*meshOf(object), points[object]);
    const int species = request.surroundings.cells()[around.members[object]].species;
    const std::vector<char>& outline = outlines_[species][levelOf(request, species, coarsest)];
    for (std::size_t v = 0; v < points[object].size(); ++v) points[object][v] |= outline[v];
  }
}

/// Collects the requested cells, and the cells and images that they can reach before the next run.
void CatFacePlanes::chooseBodies(const PlaneRequest& request, Around& around) {
  using Image = std::pair<std::int64_t, std::array<double, 3>>;
  std::vector<Image> images;
  const auto add = [&](std::int64_t cell, const Vec3& shift) {
    images.push_back({cell, {shift.x(), shift.y(), shift.z()}});
  };
  const auto isWanted = [&](std::int64_t cell) {
    return std::binary_search(request.wanted.begin(), request.wanted.end(), cell);
  };
  for (const std::int64_t cell : request.wanted) add(cell, Vec3::Zero());
  const double further = 2.0 * static_cast<double>(iterationsPerRun - 1) * request.motion;
  around.pairs = request.surroundings.pairsOf(request.wanted, further);
  for (const NearPair& pair : around.pairs) {
    if (isWanted(pair.first)) add(pair.second, pair.shift);
    if (isWanted(pair.second)) add(pair.first, -pair.shift);
  }
  std::sort(images.begin(), images.end());
  images.erase(std::unique(images.begin(), images.end()), images.end());
  around.members.clear();
  input_.bodies.clear();
  for (const auto& [cell, shift] : images) {
    if (around.members.empty() || around.members.back() != cell) around.members.push_back(cell);
    const Vec3 by(shift[0], shift[1], shift[2]);
    input_.bodies.push_back(
        {static_cast<int>(around.members.size()) - 1, by, by.isZero(0.0) && isWanted(cell)});
  }
}

void CatFacePlanes::tetrahedralise(const PlaneRequest& request, Around& around) {
  const Timer watch(sums_.tetrahedraSeconds);
  const std::vector<Body>& cells = request.surroundings.cells();
  around.tetrahedra = Tetrahedra();
  around.failed = false;
  chooseBodies(request, around);
  if (input_.bodies.size() < 2) {
    around.members.clear();
    return;
  }
  ++sums_.runs;
  int coarsest = 0;
  for (std::size_t s = 0; s < levels_.size(); ++s)
    coarsest = std::max(coarsest, chords_.levels(static_cast<int>(s)).indexOf(request.detail));
  for (int level = coarsest; level >= 0; --level) {
    input_.valid = level == 0;  // the cells themselves are known not to overlap
    input_.objects.clear();
    for (const std::int64_t member : around.members) {
      const Body& cell = cells[member];
      input_.objects.push_back({levels_[cell.species][levelOf(request, cell.species, level)].get(),
                                physics_.placement(cell.pose())});
    }
    around.objects = input_.objects;
    choosePoints(request, around, level);
    try {
      input_.stop = execution_.interrupted;
      around.tetrahedra = packmesh::tetrahedralise(input_);
      sums_.attempts += around.tetrahedra.attempts;
      return;
    } catch (const TetrahedraError& error) {
      sums_.attempts += error.attempts();
      sums_.lastFailure = error.what();
      break;
    } catch (const InputError&) {  // coarse levels overlap
      ++sums_.finer;
    }
  }
  ++sums_.failures;
  around.failed = true;
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
