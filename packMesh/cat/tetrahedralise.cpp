// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetrahedra.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

#include "packMesh/cat/tetgen_run.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/neighbor_search.h"

namespace packmesh {
namespace {

Triangle sorted(int a, int b, int c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return {a, b, c};
}

/// Points are examined up to this many circumradii of a triangle from its circumcentre.
constexpr double looked = 3.0;

/// Whether some sphere through the corners of a triangle contains no point of the grid.
///
/// Centres of such spheres are o + s n, where o is the circumcentre of the triangle, R its circumradius and n
/// its normal; a point p is inside if q < 2 s h, with h = n·(p - o) and q = |p - o|² - R². So each point
/// bounds s from one side.
bool hasEmptySphere(const Triangle& corners, const std::vector<Vec3>& points, const SphereGrid& grid) {
  const Vec3 &a = points[corners[0]], u = points[corners[1]] - a, v = points[corners[2]] - a;
  const Vec3 normal = u.cross(v);
  const double twiceArea2 = normal.squaredNorm();
  if (!(twiceArea2 > 0.0)) return false;
  const Vec3 arm =
      (u.squaredNorm() * v.cross(normal) + v.squaredNorm() * normal.cross(u)) / (2.0 * twiceArea2);
  const Vec3 center = a + arm, n = normal / std::sqrt(twiceArea2);
  const double radius2 = arm.squaredNorm(), radius = std::sqrt(radius2);
  double least = -std::numeric_limits<double>::infinity(), most = -least;
  grid.forEachNear({center, looked * radius}, 0.0, [&](int p) {
    if (p == corners[0] || p == corners[1] || p == corners[2]) return;
    const Vec3 to = points[p] - center;
    const double h = n.dot(to), q = to.squaredNorm() - radius2;
    if (h > 0.0)
      most = std::min(most, 0.5 * q / h);
    else if (h < 0.0)
      least = std::max(least, 0.5 * q / h);
    else if (q < 0.0)
      most = -std::numeric_limits<double>::infinity();
  });
  if (!(least <= most)) return false;
  const double s = std::abs(std::clamp(0.0, least, most));
  return s + std::sqrt(radius2 + s * s) <= looked * radius;
}

}  // namespace

std::vector<int> likelyMissing(const std::vector<Triangle>& triangles, const std::vector<Vec3>& points) {
  std::vector<Sphere> dots;
  dots.reserve(points.size());
  for (const Vec3& p : points) dots.push_back({p, 0.0});
  const SphereGrid grid(dots);
  std::vector<int> missing;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (!hasEmptySphere(triangles[t], points, grid)) missing.push_back(static_cast<int>(t));
  return missing;
}

std::vector<int> missingTriangles(const std::vector<Triangle>& triangles,
                                  const std::vector<Tetrahedron>& tetrahedra, std::size_t points) {
  // Indexed by their lowest point; on average, a point is the lowest one of two triangles.
  std::vector<int> first(points + 1, 0);
  for (const Triangle& t : triangles) ++first[std::min({t[0], t[1], t[2]}) + 1];
  for (std::size_t p = 0; p < points; ++p) first[p + 1] += first[p];
  struct Entry {
    int middle, highest, triangle;
  };
  std::vector<Entry> entries(triangles.size());
  std::vector<int> next(first.begin(), first.end() - 1);
  for (std::size_t n = 0; n < triangles.size(); ++n) {
    const Triangle t = sorted(triangles[n][0], triangles[n][1], triangles[n][2]);
    entries[next[t[0]]++] = {t[1], t[2], static_cast<int>(n)};
  }
  std::vector<char> found(triangles.size(), 0);
  for (const Tetrahedron& t : tetrahedra)
    for (int k = 0; k < 4; ++k) {
      const Triangle face = sorted(t[(k + 1) & 3], t[(k + 2) & 3], t[(k + 3) & 3]);
      if (static_cast<std::size_t>(face[0]) >= points) continue;  // a new point
      for (int e = first[face[0]]; e < first[face[0] + 1]; ++e)
        if (entries[e].middle == face[1] && entries[e].highest == face[2]) found[entries[e].triangle] = 1;
    }
  std::vector<int> missing;
  for (std::size_t n = 0; n < found.size(); ++n)
    if (!found[n]) missing.push_back(static_cast<int>(n));
  return missing;
}

namespace {

/// Circumspheres that extend beyond a tetrahedron by more than this multiple of its longest edge are cut off
/// by surfaces.
constexpr double blockedSphere = 2.0;
/// A margin that was too small is enlarged this many times, to slightly more than what was needed.
constexpr int marginTrials = 4;
constexpr double marginExcess = 1.05;
/// Fraction of the triangles that tetrahedra may intersect if correcting this would take another run: the
/// exact test of growth corrects it where it matters. Usually, after the first run, it is 0 to 0.006.
constexpr double brokenShare = 0.02;
/// Maximum number of runs to constrain missing triangles (usually one is sufficient).
constexpr int sparseRounds = 5;
/// Maximum number of runs until images have the same Steiner points (usually two or three are sufficient).
constexpr int refinements = 8;

/// Input and output of one run. Triangles of body b are labelled 1 + b, those of the container 1 + bodies.
struct Run {
  TetgenInput tetgen;
  TetgenOutput output;
  Tetrahedra result;
  std::optional<MeshHierarchy> container;
  bool sparse = false;  ///< no regions to remove: triangles that are present need no constraint
};

/// @param chosen the vertices to be added; nullptr: all
void addSurface(const TriangleMesh& mesh, int meshVertices, const Vec3& shift, int label,
                const std::vector<char>* chosen, Run& run) {
  std::vector<int> number(mesh.vertices.size(), -1);
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) {
    if (chosen && !(*chosen)[v]) continue;
    number[v] = static_cast<int>(run.tetgen.points.size());
    run.tetgen.points.push_back(mesh.vertices[v] + shift);
    run.result.vertices.push_back(v < meshVertices ? v : -1);
  }
  for (const Triangle& t : mesh.triangles)
    if (number[t[0]] >= 0 && number[t[1]] >= 0 && number[t[2]] >= 0)
      run.tetgen.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  run.tetgen.triangleLabels.resize(run.tetgen.triangles.size(), 1 + label);
}

/// Surfaces of the objects at their given positions, with Steiner points that are imposed.
using Surfaces = std::vector<TriangleMesh>;

Run prepare(const TetrahedraInput& input, double margin, const Surfaces* surfaces) {
  Run run;
  run.result.bodies = bodiesAround(input, margin);
  run.container = containerAround(input, margin);
  int label = 0;
  for (TetrahedraBody& body : run.result.bodies) {
    body.firstPoint = static_cast<int>(run.tetgen.points.size());
    const TriangleMesh& mesh = input.objects[body.object].mesh->mesh();
    const int vertices = static_cast<int>(mesh.vertices.size());
    if (surfaces)
      addSurface((*surfaces)[body.object], vertices, body.shift, label, nullptr, run);
    else
      addSurface(placed(mesh, placementOf(input, body)), vertices, Vec3::Zero(), label,
                 input.points.empty() ? nullptr : &input.points[body.given], run);
    run.result.labels.resize(run.tetgen.points.size(), label++);
  }
  if (run.container) {
    const TriangleMesh& mesh = run.container->mesh();
    addSurface(mesh, static_cast<int>(mesh.vertices.size()), Vec3::Zero(), label, nullptr, run);
  }
  run.result.labels.resize(run.tetgen.points.size(), wallLabel);
  if (input.kind == TetrahedraKind::delaunay) {
    run.tetgen.triangles.clear();
    run.tetgen.triangleLabels.clear();
  }
  run.tetgen.keepHull = !run.container;
  run.tetgen.regions = input.kind == TetrahedraKind::constrained && input.kept == TetrahedraKept::freeSpace;
  run.tetgen.subfaces = surfaces != nullptr;
  run.sparse = run.tetgen.keepHull && !run.tetgen.regions && !run.tetgen.triangles.empty();
  return run;
}

/// Constrains only the triangles that plain Delaunay tetrahedra will not contain: most surfaces are unions of
/// their faces anyway, and TetGen takes most of its time to enforce it. What is still missing is constrained
/// in the next run.
/// @return whether all triangles are present, except for a few in a hundred
bool constrainWhatIsMissing(const TetrahedraInput& input, Run& run, TetgenFailure& failure) {
  const TetgenInput& all = run.tetgen;
  const auto tolerated = static_cast<std::size_t>(brokenShare * static_cast<double>(all.triangles.size()));
  TetgenInput some = all;
  some.triangles.clear();
  some.triangleLabels.clear();
  std::vector<char> chosen(all.triangles.size(), 0);
  std::vector<int> missing = likelyMissing(all.triangles, all.points);
  for (int round = 0; round < sparseRounds; ++round) {
    for (const int t : missing) {
      chosen[t] = 1;
      some.triangles.push_back(all.triangles[t]);
      some.triangleLabels.push_back(all.triangleLabels[t]);
    }
    run.output = runTetgen(some, failure, input.stop);
    if (failure.code != 0) return false;
    missing = missingTriangles(all.triangles, run.output.tetrahedra, all.points.size());
    // A constrained one is present, possibly subdivided by new points.
    missing.erase(std::remove_if(missing.begin(), missing.end(), [&](int t) { return chosen[t]; }),
                  missing.end());
    if (missing.size() <= tolerated) return true;
  }
  return false;
}

/// Names the surfaces that intersect according to TetGen: ": those of 'a', 'b'"; empty if it finds none.
std::string intersectingText(const TetrahedraInput& input, Run& run) {
  run.tetgen.crossings = true;
  TetgenFailure failure;
  std::set<std::string> names;
  for (const int label : runTetgen(run.tetgen, failure, input.stop).subfaceLabels) {
    const auto body = static_cast<std::size_t>(label) - 1;
    names.insert(body < run.result.bodies.size() ? nameOf(input, run.result.bodies[body].object)
                                                 : "the container");
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? ": those of " : ", ") + name;
  return text;
}

void runUntilItWorks(const TetrahedraInput& input, Run& run) {
  const int variants = run.tetgen.triangles.empty() ? 1 : tetgenVariants;
  TetgenFailure failure;
  for (int variant = 0; variant < variants; ++variant) {
    ++run.result.attempts;
    failure.code = TetgenFailure::unknown;
    if (variant < input.failingAttempts) continue;
    if (variant == 0 && run.sparse && constrainWhatIsMissing(input, run, failure)) return;
    run.tetgen.variant = variant;
    run.output = runTetgen(run.tetgen, failure, input.stop);
    if (failure.code == 0) return;
    if (failure.code == TetgenFailure::stopped) break;
  }
  throw TetrahedraError(
      "TetGen gave up on the space between " + std::to_string(input.objects.size()) + " objects (" +
          std::to_string(run.tetgen.points.size()) + " vertices) after " +
          std::to_string(run.result.attempts) + " attempts: " + failure.text() +
          (input.explain && failure.code == TetgenFailure::intersection ? intersectingText(input, run) : ""),
      run.result.attempts);
}

/// Steiner points get the label of the surface they are on; those within the volume get that of the nearest
/// point to which they are joined.
void labelSteinerPoints(Run& run) {
  constexpr int unknown = std::numeric_limits<int>::min();
  const TetgenOutput& output = run.output;
  std::vector<int>& labels = run.result.labels;
  const int given = static_cast<int>(labels.size()), wall = static_cast<int>(run.result.bodies.size()) + 1;
  int missing = 0;
  for (const int label : output.steinerLabels) {
    labels.push_back(label == 0 ? unknown : label == wall ? wallLabel : label - 1);
    missing += label == 0;
  }
  run.result.vertices.resize(labels.size(), -1);
  while (missing > 0) {
    struct Found {
      double distance = std::numeric_limits<double>::infinity();
      int label = unknown;
    };
    std::vector<Found> nearest(output.steinerLabels.size());
    for (const Tetrahedron& t : output.tetrahedra)
      for (const int p : t)
        for (const int q : t) {
          if (labels[p] != unknown || labels[q] == unknown) continue;
          const double distance = (output.points[p] - output.points[q]).squaredNorm();
          if (distance < nearest[p - given].distance) nearest[p - given] = {distance, labels[q]};
        }
    const int before = missing;
    for (std::size_t s = 0; s < nearest.size(); ++s)
      if (nearest[s].label != unknown) {
        labels[given + s] = nearest[s].label;
        --missing;
      }
    if (missing == before)
      throw TetrahedraError("TetGen created points that are not connected to any surface");
  }
}

bool joins(const Tetrahedra& out, const Tetrahedron& t) {
  const int a = out.labels[t[0]];
  return a != out.labels[t[1]] || a != out.labels[t[2]] || a != out.labels[t[3]];
}

bool touchesPrimary(const Tetrahedra& out, const Tetrahedron& t) {
  return std::any_of(t.begin(), t.end(), [&](int p) { return out.isPrimary(out.labels[p]); });
}

/// Determines the regions outside of all objects and inside the container. A region whose tetrahedra join
/// different surfaces is one; otherwise the centre of its largest tetrahedron decides.
std::vector<char> freeRegions(const TetrahedraInput& input, const Run& run) {
  const TetgenOutput& output = run.output;
  const std::vector<Vec3>& p = output.points;
  const int count =
      output.regions.empty() ? 0 : 1 + *std::max_element(output.regions.begin(), output.regions.end());
  std::vector<char> isFree(count, 0);
  std::vector<double> volume(count, 0.0);
  std::vector<int> largest(count, -1);
  for (std::size_t i = 0; i < output.tetrahedra.size(); ++i) {
    const Tetrahedron& t = output.tetrahedra[i];
    const int region = output.regions[i];
    if (joins(run.result, t)) isFree[region] = 1;
    const double sixfold = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]).dot(p[t[3]] - p[t[0]]);
    if (sixfold > volume[region]) {
      volume[region] = sixfold;
      largest[region] = static_cast<int>(i);
    }
  }
  for (int region = 0; region < count; ++region) {
    if (isFree[region] || largest[region] < 0) continue;
    const Tetrahedron& t = output.tetrahedra[largest[region]];
    const Vec3 middle = 0.25 * (p[t[0]] + p[t[1]] + p[t[2]] + p[t[3]]);
    const int label = run.result.labels[t[0]];
    if (label == wallLabel) {
      isFree[region] = isInside(middle, *run.container, Placement());
    } else {
      const TetrahedraBody& body = run.result.bodies[label];
      isFree[region] = !isInside(middle, *input.objects[body.object].mesh, placementOf(input, body));
    }
  }
  return isFree;
}

void keepTetrahedra(const TetrahedraInput& input, Run& run) {
  const std::vector<Tetrahedron>& all = run.output.tetrahedra;
  std::vector<Tetrahedron>& kept = run.result.tetrahedra;
  if (run.tetgen.regions) {
    const std::vector<char> isFree = freeRegions(input, run);
    for (std::size_t i = 0; i < all.size(); ++i)
      if (isFree[run.output.regions[i]]) kept.push_back(all[i]);
  } else {
    std::copy_if(all.begin(), all.end(), std::back_inserter(kept),
                 [&](const Tetrahedron& t) { return joins(run.result, t) && touchesPrimary(run.result, t); });
  }
}

Run tetrahedraWithin(const TetrahedraInput& input, double margin, const Surfaces* surfaces = nullptr) {
  Run run = prepare(input, margin, surfaces);
  runUntilItWorks(input, run);
  labelSteinerPoints(run);
  keepTetrahedra(input, run);
  run.result.points = std::move(run.output.points);
  return run;
}

/// Distance beyond the bounds within which points could change the tetrahedra at primary bodies [µm].
double neededMargin(const TetrahedraInput& input, const Tetrahedra& out) {
  double needed = 0.0;
  for (const Tetrahedron& t : out.tetrahedra) {
    if (!joins(out, t) || !touchesPrimary(out, t)) continue;
    const Vec3 &o = out.points[t[0]], a = out.points[t[1]] - o, b = out.points[t[2]] - o,
               c = out.points[t[3]] - o;
    double edge = 0.0;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) edge = std::max(edge, (out.points[t[i]] - out.points[t[j]]).norm());
    const Vec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
    Vec3 center = (a.squaredNorm() * bc + b.squaredNorm() * ca + c.squaredNorm() * ab) / (2.0 * a.dot(bc));
    double radius = center.norm();
    if (!(radius <= blockedSphere * edge)) {
      center = 0.25 * (a + b + c);
      radius = blockedSphere * edge;
    }
    center += o;
    for (int k = 0; k < 3; ++k)
      if (input.period[k] > 0.0)
        needed = std::max(
            {needed, center[k] + radius - input.bounds.hi[k], input.bounds.lo[k] - center[k] + radius});
  }
  return needed;
}

/// Determined with plain Delaunay tetrahedra, which are cheap.
double sufficientMargin(TetrahedraInput input) {
  input.kind = TetrahedraKind::delaunay;
  input.failingAttempts = 0;
  const double spacing = std::cbrt(input.bounds.volume() / static_cast<double>(input.objects.size()));
  double margin = largestRadius(input) + spacing;
  for (int trial = 0; trial < marginTrials; ++trial) {
    const double needed = neededMargin(input, tetrahedraWithin(input, margin).result);
    if (needed <= margin) break;
    margin = marginExcess * needed;
  }
  return margin;
}

/// Steiner points at primary bodies become part of the surfaces they lie on.
/// @return whether there were any
bool refine(const Run& run, Surfaces& surfaces) {
  const Tetrahedra& out = run.result;
  const int given = static_cast<int>(run.tetgen.points.size());
  std::vector<int> bodyWithNewPoints(surfaces.size(), -1);
  for (const Tetrahedron& t : out.tetrahedra) {
    if (!touchesPrimary(out, t)) continue;
    for (const int p : t)
      if (p >= given && out.labels[p] != wallLabel)
        bodyWithNewPoints[out.bodies[out.labels[p]].object] = out.labels[p];
  }
  // Of several images with different points one is chosen; its points are added to the others.
  std::vector<int> number(out.points.size(), -1);
  bool refined = false;
  for (std::size_t f = 0; f < run.output.subfaces.size(); ++f) {
    const int label = run.output.subfaceLabels[f] - 1;
    if (label >= static_cast<int>(out.bodies.size())) continue;
    const TetrahedraBody& body = out.bodies[label];
    if (bodyWithNewPoints[body.object] != label) continue;
    TriangleMesh& surface = surfaces[body.object];
    if (number[body.firstPoint] < 0) {  // its first subface
      for (std::size_t v = 0; v < surface.vertices.size(); ++v)
        number[body.firstPoint + v] = static_cast<int>(v);
      surface.triangles.clear();
      refined = true;
    }
    Triangle triangle = run.output.subfaces[f];
    for (int& p : triangle) {
      if (number[p] < 0) {
        number[p] = static_cast<int>(surface.vertices.size());
        surface.vertices.push_back(out.points[p] - body.shift);
      }
      p = number[p];
    }
    surface.triangles.push_back(triangle);
  }
  return refined;
}

Tetrahedra periodicFreeSpace(const TetrahedraInput& input, double margin) {
  Surfaces surfaces;
  for (const PlacedMesh& object : input.objects)
    surfaces.push_back(placed(object.mesh->mesh(), object.placement));
  int attempts = 0;
  for (int trial = 0;; ++trial) {
    Run run = tetrahedraWithin(input, margin, &surfaces);
    attempts = run.result.attempts += attempts;
    if (trial == refinements || !refine(run, surfaces)) return std::move(run.result);
  }
}

}  // namespace

Tetrahedra tetrahedralise(const TetrahedraInput& input) {
  if (!input.valid) requireValid(input);
  if (input.objects.empty()) throw InputError("tetrahedralisation needs at least one object");
  const bool periodic = (input.period.array() > 0.0).any();
  const bool measured = periodic && input.bodies.empty() && !(input.margin > 0.0);
  const double margin = measured ? sufficientMargin(input) : input.margin;
  if (periodic && input.kind == TetrahedraKind::constrained && input.kept == TetrahedraKept::freeSpace)
    return periodicFreeSpace(input, margin);
  return tetrahedraWithin(input, margin).result;
}

}  // namespace packmesh
