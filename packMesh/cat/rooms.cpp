// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/rooms.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "packMesh/cat/levels_of_detail.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/core/random.h"
#include "packMesh/parallel/blocks.h"

namespace packmesh {
namespace {

Vec3 circumcentre(const Tetrahedra& t, int index) {
  const Vec3& o = t.corner(index, 0);
  const Vec3 a = t.corner(index, 1) - o, b = t.corner(index, 2) - o, c = t.corner(index, 3) - o;
  const Vec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
  return o + (a.squaredNorm() * bc + b.squaredNorm() * ca + c.squaredNorm() * ab) / (2.0 * a.dot(bc));
}

}  // namespace

/// The cells around a region.
struct Holes::Surroundings {
  std::vector<Body> cells;     ///< also as periodic images, except along axes of which the region has all
  Vec3 period = Vec3::Zero();  ///< along these axes [µm]
  double range = std::numeric_limits<double>::infinity();  ///< surfaces nearer than this are known [µm]
};

Holes::Holes(const Physics& physics, const Execution& execution) : physics_(physics), execution_(execution) {
  for (const int s : physics.shapesInUse()) {
    const Shape& shape = *physics.shapes[s];
    shapes_.try_emplace(s, SurfaceDistance(shape), MeshHierarchy(LevelsOfDetail(shape.mesh()).level(0.0)));
  }
}

Holes::Surroundings Holes::surroundingsOf(const Box& region, const std::vector<Body>& state) const {
  Surroundings around;
  const Vec3 whole = physics_.container->bounds().size();
  if (region.size() == whole) {
    around.cells = state;
    around.period = physics_.container->period();
    return around;
  }
  around.range = physics_.largest(&Shape::radius);
  Vec3 imaged = physics_.container->period();
  for (int k = 0; k < 3; ++k)
    if (region.size()[k] == whole[k]) around.period[k] = std::exchange(imaged[k], 0.0);
  for (const Body& cell : state) {
    const double reach = cell.scale * physics_.shapeOf(cell).radius() + around.range;
    forEachImage(cell.position, reach, region, imaged, [&](const ImageShift& shift) {
      Body image = cell;
      image.position += displacement(shift, imaged);
      if (region.squaredDistance(image.position) < reach * reach) around.cells.push_back(image);
    });
  }
  return around;
}

/// Radius of a sphere around `p` that contains no surface, up to the errors of the distance fields [µm].
double Holes::freeAround(const Vec3& p, const Surroundings& around) const {
  double free = around.range;
  for (const Species& species : physics_.species)
    if (const Wall* wall = physics_.wallOf(species))
      free = std::min(free, wall->distance(p).distance - wall->slack());
  for (const Body& cell : around.cells) {
    if (free <= 0.0) break;
    const SurfaceDistance& field = shapes_.at(cell.shape).first;
    const Vec3 offset = nearestImage(p - cell.position, around.period);
    const Vec3 q = cell.orientation.conjugate() * offset / cell.scale;
    if (cell.scale * field.lowerBound(q) > free) continue;
    const DistanceSample sample = field.sample(q);
    const double distance = sample.distance > 0.0 ? (field.foot(q, sample) - q).norm() : sample.distance;
    free = std::min(free, cell.scale * std::min(distance, std::abs(sample.distance)));
    if (sample.distance <= 0.0) return 0.0;
  }
  return free;
}

/// Of unconstrained Delaunay tetrahedra between coarse meshes: their circumspheres are as empty as those of
/// constrained ones, and their positions are checked later.
std::vector<Vec3> Holes::circumcentres(const Surroundings& around) const {
  TetrahedraInput input;
  for (const Body& cell : around.cells)
    input.objects.push_back({&shapes_.at(cell.shape).second, cell.pose().placement()});
  input.period = around.period;
  input.bounds = physics_.container->bounds();
  if (std::isfinite(around.range)) input.margin = around.range;
  input.kind = TetrahedraKind::delaunay;
  input.valid = true;  // only vertices are used
  input.explain = false;
  input.stop = execution_.interrupted;
  std::vector<Vec3> centres;
  try {
    const Tetrahedra tetrahedra = tetrahedralise(input);
    for (int t = 0; t < static_cast<int>(tetrahedra.tetrahedra.size()); ++t)
      centres.push_back(circumcentre(tetrahedra, t));
  } catch (const TetrahedraError&) {
  }
  return centres;
}

std::vector<Sphere> Holes::in(const Box& region, const std::vector<Body>& state, double least) const {
  std::vector<Sphere> found;
  const Surroundings around = surroundingsOf(region, state);
  if (around.cells.size() < 2) return found;
  for (const Vec3& center : circumcentres(around)) {
    if (!center.allFinite() || !region.contains(center)) continue;
    const double radius = freeAround(center, around);
    if (radius >= least) found.push_back({center, radius});
  }
  std::sort(found.begin(), found.end(), [](const Sphere& a, const Sphere& b) {
    if (a.radius != b.radius) return a.radius > b.radius;
    return std::lexicographical_compare(a.center.data(), a.center.data() + 3, b.center.data(),
                                        b.center.data() + 3);
  });
  const Vec3 period = physics_.container->period();
  std::vector<Sphere> holes;
  for (const Sphere& sphere : found) {
    const bool apart = std::all_of(holes.begin(), holes.end(), [&](const Sphere& hole) {
      return nearestImage(sphere.center - hole.center, period).norm() >= sphere.radius + hole.radius;
    });
    if (apart) holes.push_back(sphere);
  }
  return holes;
}

namespace {

/// Expected displacement of cells in one local growth, in steps of the largest length.
constexpr double expectedSteps = 8.0;

/// More than by how much writing a cell moves a point of it [µm].
constexpr double writtenDifference = 0.01;

Execution onThisRank(Execution execution) {
  execution.communicator = Communicator();
  return execution;
}

bool contains(const std::vector<std::int64_t>& ascending, std::int64_t i) {
  return std::binary_search(ascending.begin(), ascending.end(), i);
}

}  // namespace

LocalGrowth::LocalGrowth(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
                         const PlaneFunctionFactory& factory)
    : physics_(physics), execution_(onThisRank(execution)), settings_(settings), planeFunction_(factory()) {
  settings_.barriers = {settings.barriers.back()};
  settings_.relaxationSweeps = 0;
  settings_.initialScale = 0.0;
  settings_.giveUpAfter = 2;
}

bool LocalGrowth::near(const Body& a, const Body& b, double margin) const {
  const double reach = physics_.shapeOf(a).radius() + physics_.shapeOf(b).radius() + std::max(0.0, margin);
  return nearestImage(b.position - a.position, physics_.container->period()).squaredNorm() < reach * reach;
}

/// The cells and those near them, ascending.
std::vector<std::int64_t> LocalGrowth::withNeighbours(const std::vector<std::int64_t>& cells,
                                                      const std::vector<Body>& state, double margin) const {
  std::vector<std::int64_t> members;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(state.size()); ++i)
    if (contains(cells, i) || std::any_of(cells.begin(), cells.end(), [&](std::int64_t cell) {
          return near(state[cell], state[i], margin);
        }))
      members.push_back(i);
  return members;
}

bool LocalGrowth::valid(const std::vector<std::int64_t>& cells, const std::vector<Body>& state) const {
  std::vector<Body> part;
  std::vector<std::int64_t> which;
  for (const std::int64_t i : withNeighbours(cells, state, physics_.clearance + writtenDifference)) {
    if (contains(cells, i)) which.push_back(static_cast<std::int64_t>(part.size()));
    part.push_back(state[i]);
  }
  return StepHalving(physics_, execution_).examine(part, which).clean();
}

bool LocalGrowth::grow(const std::vector<std::int64_t>& growing, const std::function<bool()>& stop,
                       std::vector<Body>& state, GrowthStatistics& statistics, const Permitted& permitted) {
  double step = 0.0;
  for (const std::int64_t i : growing)
    step = std::max(step, settings_.translationBound * std::cbrt(physics_.shapeOf(state[i]).volume()));
  const std::vector<std::int64_t> members =
      withNeighbours(growing, state, expectedSteps * step + physics_.clearance);

  std::vector<Body> part;
  for (const std::int64_t i : members) {
    part.push_back(
        makeBody(static_cast<std::int64_t>(part.size()), state[i].species, state[i].shape, state[i].pose()));
    part.back().frozen = !contains(growing, i);
  }
  GrowthCallbacks callbacks;
  callbacks.stop = stop;
  packmesh::grow(physics_, execution_, settings_, *planeFunction_, callbacks, part, statistics);

  std::vector<Pose> before;
  bool full = true, kept = true;
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (part[k].frozen) continue;
    before.push_back(state[members[k]].pose());
    state[members[k]].setPose(part[k].pose());
    full = full && part[k].scale == 1.0;
    kept = kept && (!permitted || permitted(part[k].position));
  }
  // Some cell may have moved beyond the range in which neighbours were searched.
  if (kept && valid(growing, state)) return full;
  for (std::size_t k = 0; k < growing.size(); ++k) state[growing[k]].setPose(before[k]);
  return false;
}

namespace {

/// Initial scale of a trial; if it does not fit, it is halved, at most `halvings` times.
constexpr double firstScale = 0.4;
constexpr int halvings = 4;

/// A trial ends when growth stalls; more iterations than this are not needed.
constexpr int iterations = 40;

GrowthSettings settingsOfTrials(GrowthSettings settings) {
  settings.maxIterations = std::min(settings.maxIterations, iterations);
  return settings;
}

}  // namespace

Rooms::Rooms(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
             const PlaneFunctionFactory& factory, int orientations)
    : physics_(physics),
      growth_(physics, execution, settingsOfTrials(settings), factory),
      orientations_(orientations) {}

std::optional<Pose> Rooms::largest(std::vector<Body>& state, std::int64_t cell, const BodyKind& kind,
                                   Trials& trials) {
  std::optional<Pose> best;
  Body& body = state[cell];
  const Body before = body;
  body.species = kind.species;
  body.shape = kind.shape;
  for (int k = 0; k < orientations_; ++k) {
    Pose pose = before.pose();
    if (physics_.rotate) {
      const auto u = uniform4(physics_.seed, RandomStream::orientation, static_cast<std::uint64_t>(body.id),
                              static_cast<std::uint32_t>(++trials.counters.trials));
      pose.orientation = uniformRotation(u[0], u[1], u[2]);
      const std::optional<AxisCone>& cone = physics_.species[kind.species].freedom.cone;
      if (cone) pose.orientation = cone->nearest(pose.orientation);
    }
    pose.scale = firstScale;
    bool fits = false;
    for (int halving = 0; halving < halvings && !fits; ++halving, pose.scale *= fits ? 1.0 : 0.5) {
      body.setPose(pose);
      fits = growth_.valid({cell}, state);
    }
    if (!fits) continue;
    const bool full = enlarge(state, cell, trials);
    if (!best || body.scale > best->scale) best = body.pose();
    if (full || !physics_.rotate) break;
  }
  body = before;
  return best;
}

bool Rooms::enlarge(std::vector<Body>& state, std::int64_t cell, Trials& trials) {
  GrowthStatistics statistics;
  statistics.iterations = trials.counters.iterations;
  const bool full = growth_.grow({cell}, trials.stop, state, statistics, trials.permitted);
  trials.counters.iterations = statistics.iterations;
  return full;
}

}  // namespace packmesh
