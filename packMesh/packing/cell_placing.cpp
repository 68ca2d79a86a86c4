// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/cell_placing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "packMesh/core/box.h"
#include "packMesh/core/random.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/placement/placement.h"
#include "packMesh/shape/shape.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh {
namespace {

/// Appends the initial cells [from, to) of a species, whose first cell has this id.
void place(const Physics& physics, const Execution& execution, AccessibleSpaces& spaces, int s,
           std::int64_t from, std::int64_t to, std::int64_t firstId, std::vector<Body>& bodies) {
  const Species& species = physics.species[s];
  const auto add = [&](std::int64_t cell, int shape, const Pose& pose) {
    bodies.push_back(makeBody(firstId + cell, s, shape, pose));
  };
  const auto deformed = std::int64_t(species.deformed.size());
  for (std::int64_t n = from; n < std::min(to, deformed); ++n) {
    const auto& [shape, start] = species.deformed[n];
    add(n, shape, start ? *start : placeRandomly(physics, execution, s, shape, firstId + n, 1).front());
  }
  from = std::clamp(from, deformed, std::max(to, deformed));
  const std::int64_t atRandom =
      std::clamp(deformed + std::int64_t(species.start.size()), from, std::max(from, to));
  for (std::int64_t n = from; n < atRandom; ++n) add(n, species.shape, species.start[n - deformed]);
  if (atRandom >= to) return;
  if (species.inColumns) {
    const Columns columns(physics.shapeOf(species), species.count, physics.container->bounds(),
                          physics.clearance + tolerance::relaxationMargin, physics.seed);
    for (std::int64_t n = atRandom; n < to; ++n) add(n, species.shape, columns.pose(n));
    return;
  }
  std::int64_t n = atRandom;
  const AccessibleSpace* const space = spaces.of(s);
  for (const Pose& pose :
       placeRandomly(physics, execution, s, species.shape, firstId + atRandom, to - atRandom, space))
    add(n++, species.shape, pose);
}

}  // namespace

std::optional<std::vector<Body>> placedCells(const Physics& physics, Execution execution,
                                             const IdShares& shares, RunControl& control) {
  execution.interrupted = [&] { return control.outOfTimeHere(); };
  const auto [first, end] = shares.own();
  std::vector<Body> bodies;
  bodies.reserve(end - first);
  std::int64_t begin = 0;  // first id of the species
  for (std::size_t i = 0; i < physics.species.size(); ++i) {
    const int s = static_cast<int>(i);
    const std::int64_t speciesBegin = begin;
    begin += physics.species[i].count;
    const std::int64_t from = std::max(first, speciesBegin), to = std::min(end, begin);
    if (from >= to) continue;
    place(physics, execution, control.spaces(), s, from - speciesBegin, to - speciesBegin, speciesBegin,
          bodies);
  }
  if (control.outOfTime()) return {};
  return bodies;
}

namespace {

/// Poses that are tried for each cell, and for all of few.
constexpr int posesOfCell = 256, posesOfFew = 2048;

/// Points of either surface by which the gap between two cells is estimated.
constexpr int pointsOfGap = 48;

/// Gaps are estimated up to this [half thicknesses of the cell], and may be as negative as this: cells that
/// are as deep in each other can still be separated on the side they came from.
constexpr double widestRoom = 2.0, deepestStart = 0.9;

constexpr double none = -std::numeric_limits<double>::infinity();

/// A pose that is tried for a cell.
struct Place {
  int species = 0, shape = 0;
  Pose pose;
  double room = none;               ///< estimated gap to the nearest cell [µm]
  std::vector<std::size_t> around;  ///< this rank's cells near it
};

/// Estimates the gap between two cells of full size.
class Gaps {
 public:
  explicit Gaps(const Physics& physics) : physics_(physics), shapes_(physics.shapes.size()) {}

  /// Prepares a shape: not by several threads at once.
  void prepare(int number) {
    if (shapes_[number]) return;
    const Shape& shape = *physics_.shapes[number];
    shapes_[number].emplace(
        Known{spreadPoints(shape.mesh(), pointsOfGap), SurfaceDistance(shape), shape.radius()});
  }
  /// At most `most`; negative where they overlap [µm].
  double between(const PlacedCell& a, const PlacedCell& b, double most) const {
    const Known &knownA = *shapes_[a.shape], &knownB = *shapes_[b.shape];
    const Vec3 fromB =
        nearestImage(a.placement.translation - b.placement.translation, physics_.container->period());
    if (fromB.norm() > knownA.radius + knownB.radius + most) return most;
    const Mat3 toB = b.placement.linear.transpose() * a.placement.linear;
    const Vec3 at = b.placement.linear.transpose() * fromB;
    double gap = most;
    for (const Vec3& p : knownA.points) gap = std::min(gap, knownB.surface.sample(toB * p + at).distance);
    for (const Vec3& p : knownB.points)
      gap = std::min(gap, knownA.surface.sample(toB.transpose() * (p - at)).distance);
    return gap;
  }

 private:
  struct Known {
    std::vector<Vec3> points;
    SurfaceDistance surface;
    double radius;  ///< [µm]
  };
  const Physics& physics_;
  std::vector<std::optional<Known>> shapes_;  ///< by number
};

/// Finds the places near a point.
class PlaceGrid {
 public:
  /// @param reach up to which they are near [µm]
  PlaceGrid(const Vec3& period, double reach) : period_(period), edge_(Vec3::Constant(reach)) {
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0.0) {
        count_[k] = std::max<std::int64_t>(1, std::int64_t(period_[k] / reach));
        edge_[k] = period_[k] / double(count_[k]);
      }
  }
  void add(std::size_t place, const Vec3& at) {
    const GridIndex middle = gridIndex(at, edge_);
    std::vector<std::int64_t> keys;
    for (int n = 0; n < 27; ++n)
      keys.push_back(keyOfImage({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1}));
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()),
               keys.end());  // in small boxes, neighbours are the same cell
    for (const std::int64_t key : keys) places_[key].push_back(place);
  }
  const std::vector<std::size_t>& near(const Vec3& at) const {
    static const std::vector<std::size_t> empty;
    const auto found = places_.find(keyOfImage(gridIndex(at, edge_)));
    return found == places_.end() ? empty : found->second;
  }

 private:
  /// Beyond a periodic face, the cell of the image in the bounds.
  std::int64_t keyOfImage(GridIndex cell) const {
    for (int k = 0; k < 3; ++k)
      if (count_[k] > 0) cell[k] = (cell[k] % count_[k] + count_[k]) % count_[k];
    return keyOf(cell);
  }

  Vec3 period_, edge_;
  std::array<std::int64_t, 3> count_ = {0, 0, 0};  ///< of cells along a periodic axis
  std::unordered_map<std::int64_t, std::vector<std::size_t>> places_;
};

/// Species and shape of a cell.
std::pair<int, int> kindOf(const Physics& physics, std::int64_t id) {
  int s = 0;
  for (; id >= physics.species[s].count; ++s) id -= physics.species[s].count;
  const Species& species = physics.species[s];
  return {s, id < std::int64_t(species.deformed.size()) ? species.deformed[id].shape : species.shape};
}

/// The i-th pose that is tried for a cell; empty: outside of where it may be.
std::optional<Pose> triedPose(const Physics& physics, const AccessibleSpace* space, int species,
                              const Shape& shape, std::int64_t id, std::int64_t round, int i) {
  constexpr std::uint32_t ofBeginnings = std::uint32_t(1) << 31;  // beyond those of single poses
  const auto begin =
      uniform4(physics.seed, RandomStream::room, std::uint64_t(id), ofBeginnings + std::uint32_t(round));
  const auto u = uniform4(physics.seed, RandomStream::room, std::uint64_t(id),
                          (std::uint32_t(round) << 11) + std::uint32_t(i));
  const auto v = uniform4(physics.seed, RandomStream::room, ~std::uint64_t(id),
                          (std::uint32_t(round) << 11) + std::uint32_t(i));
  const Freedom& freedom = physics.species[species].freedom;
  const Quaternion wish =
      physics.rotate ? randomOrientation(freedom.cone, v[0], v[1], v[2]) : Quaternion::Identity();
  const Wall* const wall = physics.wallOf(species);
  Pose pose;
  if (space) {
    pose = space->pose(evenShare(begin[0], std::uint64_t(i)), u, wish);
  } else {
    const Box room = freedom.region ? freedom.region->bounds() : physics.container->bounds();
    pose = {1.0, wish, room.lo + room.size().cwiseProduct(evenPoint(begin, std::uint64_t(i)))};
    if (freedom.region && !freedom.region->contains(pose.position)) return {};
    if (wall && wall->distance(pose.position).distance < physics.wallClearanceOf(species)) return {};
  }
  if (wall && wall->examine({shape.hierarchy(), pose.placement()}, 0.0).violation) return {};
  if (!isClearOfItself(physics, shape, pose.orientation)) return {};
  return pose;
}

/// A place, or a cell where it is.
template <class Cell>
PlacedCell placedAt(const Cell& cell, const Pose& pose) {
  return {cell.species, cell.shape, pose.placement()};
}

/// The poses that are tried, `each` for every cell.
std::vector<Place> placesOf(const Physics& physics, const Threads& threads, AccessibleSpaces& spaces,
                            std::int64_t round, const std::vector<std::int64_t>& ids, std::size_t each) {
  for (const std::int64_t id : ids) spaces.of(kindOf(physics, id).first);  // not made by a thread
  std::vector<Place> places(ids.size() * each);
  threads.forEach(std::int64_t(places.size()), [&](std::int64_t i, int) {
    Place& place = places[i];
    const std::int64_t id = ids[std::size_t(i) / each];
    std::tie(place.species, place.shape) = kindOf(physics, id);
    const auto pose = triedPose(physics, spaces.of(place.species), place.species, physics.shapeOf(place), id,
                                round, int(std::size_t(i) % each));
    if (!pose) return;
    place.pose = *pose;
    place.room = widestRoom * physics.shapeOf(place).halfThickness();
  });
  return places;
}

/// Finds the gap to the nearest cell of any rank that is not stuck.
void measureRooms(const Physics& physics, const Execution& execution, const std::set<std::int64_t>& stuck,
                  const std::vector<BodyState>& own, Gaps& gaps, std::vector<Place>& places) {
  double widest = 0.0;
  for (const Place& place : places) {
    gaps.prepare(place.shape);
    widest = std::max(widest, place.room);
  }
  PlaceGrid grid(physics.container->period(), 2.0 * physics.largest(&Shape::radius) + widest);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (places[i].room != none) grid.add(i, places[i].pose.position);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (stuck.count(own[i].id)) continue;
    for (const std::size_t place : grid.near(own[i].position)) {
      gaps.prepare(own[i].shape);
      places[place].around.push_back(i);
    }
  }
  std::vector<double> deepest(places.size());
  execution.threads.forEach(std::int64_t(places.size()), [&](std::int64_t i, int) {
    Place& place = places[i];
    for (const std::size_t other : place.around)
      place.room = std::min(place.room, gaps.between(placedAt(place, place.pose),
                                                     placedAt(own[other], own[other].pose()), place.room));
    deepest[i] = -place.room;
  });
  std::vector<std::int64_t> nothing;
  execution.communicator.sumAndMax(nothing, deepest);
  for (std::size_t i = 0; i < places.size(); ++i) places[i].room = -deepest[i];
}

}  // namespace

std::set<std::int64_t> relocate(const Physics& physics, const Execution& execution, AccessibleSpaces& spaces,
                                std::int64_t round, const std::set<std::int64_t>& stuck,
                                std::vector<BodyState>& own) {
  if (stuck.empty()) return {};
  const std::vector<std::int64_t> ids(stuck.begin(), stuck.end());
  const std::size_t each = std::max<std::size_t>(posesOfCell, posesOfFew / ids.size());
  std::vector<Place> places = placesOf(physics, execution.threads, spaces, round, ids, each);
  Gaps gaps(physics);
  measureRooms(physics, execution, stuck, own, gaps, places);
  std::map<std::int64_t, Pose> moved;
  for (std::size_t c = 0; c < ids.size(); ++c) {
    const auto begin = places.begin() + std::ptrdiff_t(c * each);
    const Place& best = *std::max_element(begin, begin + std::ptrdiff_t(each),
                                          [](const Place& a, const Place& b) { return a.room < b.room; });
    if (best.room < -deepestStart * physics.shapeOf(best).halfThickness()) continue;
    moved[ids[c]] = best.pose;
    for (std::size_t i = (c + 1) * each; i < places.size(); ++i)
      if (places[i].room != none)
        places[i].room = std::min(places[i].room, gaps.between(placedAt(places[i], places[i].pose),
                                                               placedAt(best, best.pose), places[i].room));
  }
  for (BodyState& cell : own)
    if (const auto found = moved.find(cell.id); found != moved.end())
      cell = stateOf(cell.id, cell.species, cell.shape, found->second);
  std::set<std::int64_t> relocated;
  for (const auto& [id, pose] : moved) relocated.insert(id);
  return relocated;
}

}  // namespace packmesh
