// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/accessible_space.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <utility>

#include "packMesh/core/box.h"
#include "packMesh/mesh/union_find.h"
#include "packMesh/shape/shape.h"

namespace packmesh {
namespace {

/// Longest edge of the smallest parts [half thicknesses of the cell]; for small cells in large lumens,
/// longer, up to this edge [µm], so that as many of them would not be more than so many.
constexpr double finest = 1.0, finestOfSmall = 1.2, mostOfSmall = 500000.0;

/// Parts beside others in which a cell fits, at the rim of the space, are small enough at this multiple of
/// that edge.
constexpr double finestAtRim = 2.5;

/// Where parts had to be divided further but are too many, those longer than this multiple of the smallest
/// tell no more where a cell fits.
constexpr double coarsest = 2.5;

/// The same for points, and for those that are covered [µm].
constexpr double finestOfPoints = 0.4, finestOfCover = 1.0;

/// Cells of the grid by which components are found, at most.
constexpr double mostGridCells = 1.5e6;

/// Parts that a thread examines at once.
constexpr std::int64_t partsAtOnce = 64;

/// Orientations that are tried: for a body of revolution in a tube, one of them is within 13 degrees of the
/// best.
constexpr int orientationsTried = 32;

/// Points of the surface that are tested: those farthest apart.
constexpr int pointsTested = 48;

/// A cell fits nowhere with a centre that is less deep than this [half thicknesses of the cell].
constexpr double leastDepth = 0.8;

/// Orientations of parts other than one of those tried, whose numbers precede that along the wall: what fits
/// at the centre of a part at the rim is tried in the end.
constexpr std::int16_t alongWall = orientationsTried, anyOrientation = -1, nowhere = -2, undecided = -3,
                       atRim = -4, isDivided = -5;

/// The axis along which a shape is thinnest.
Vec3 thinAxis(const Shape& shape) {
  int thinnest = 0;
  shape.bound().semiAxes.minCoeff(&thinnest);
  return Vec3::Unit(thinnest);
}

/// Axes evenly spread over a half-sphere, each with another rotation about it.
std::vector<Quaternion> spreadOrientations(const std::optional<AxisCone>& cone) {
  constexpr double golden = 2.39996322972865332;  // angle [rad]
  std::vector<Quaternion> orientations;
  for (int i = 0; i < orientationsTried; ++i) {
    const double y = (i + 0.5) / orientationsTried, r = std::sqrt(1.0 - y * y);
    const Vec3 axis(r * std::cos(golden * i), y, r * std::sin(golden * i));
    const Quaternion turn(Quaternion::around(Vec3::UnitY(), golden * i));
    const Quaternion orientation = (Quaternion::FromTwoVectors(Vec3::UnitY(), axis) * turn).normalized();
    orientations.push_back(cone ? cone->nearest(orientation) : orientation);
  }
  return orientations;
}

/// The size of the parts of a part, whose edges become as equal as halving can make them.
Vec3f halved(Vec3f half) {
  const float longest = half.maxCoeff();
  for (int k = 0; k < 3; ++k)
    if (half[k] > 0.7f * longest) half[k] *= 0.5f;
  return half;
}

/// The parts of a part; the last ones may be nowhere.
std::array<AccessibleSpace::Part, 8> divided(const AccessibleSpace::Part& part) {
  AccessibleSpace::Part child = part;
  child.half = halved(part.half);
  std::array<int, 3> steps;
  for (int k = 0; k < 3; ++k) steps[k] = child.half[k] < part.half[k] ? 2 : 1;
  std::array<AccessibleSpace::Part, 8> children;
  children.fill({part.centre, part.half, nowhere});
  auto next = children.begin();
  for (int z = 0; z < steps[2]; ++z)
    for (int y = 0; y < steps[1]; ++y)
      for (int x = 0; x < steps[0]; ++x) {
        const Vec3 at(x, y, z);
        child.centre = part.centre;
        for (int k = 0; k < 3; ++k)
          if (steps[k] == 2) child.centre[k] += (2.0 * at[k] - 1.0) * double(child.half[k]);
        *next++ = child;
      }
  return children;
}

}  // namespace

/// Whether a cell fits at a place, by points of its surface.
class CellFit {
 public:
  CellFit(const Physics& physics, int s)
      : radius(physics.shapeOf(physics.species[s]).radius()),
        thin(physics.shapeOf(physics.species[s]).bound().semiAxes.minCoeff()),
        longestEdge(std::max(finest * thin,
                             std::min(finestOfSmall, std::cbrt(physics.container->volume() / mostOfSmall)))),
        edgeAtRim(finestAtRim * longestEdge),
        freedom_(physics.species[s].freedom),
        clearance_(physics.wallClearanceOf(s)),
        bounds_(physics.container->bounds()),
        period_(physics.container->period()),
        exact_(*physics.wallOf(s)),
        wall_(&exact_.coarselySampled(physics.surroundings())),
        points_(spreadPoints(physics.shapeOf(physics.species[s]).mesh(), pointsTested)),
        thinAxis_(thinAxis(physics.shapeOf(physics.species[s]))),
        orientations_(physics.rotate ? spreadOrientations(freedom_.cone)
                                     : std::vector<Quaternion>{Quaternion::Identity()}) {
    if (freedom_.freeLayer) layer_ = &freedom_.freeLayer->wall->coarselySampled(physics.surroundings());
    for (const Quaternion& orientation : orientations_) turned_.push_back(turnedBy(orientation));
  }

  /// Of points.
  CellFit(const Container& container, AccessibleSpace::Points points)
      : radius(0.0),
        thin(0.0),
        longestEdge(points == AccessibleSpace::Points::exact ? finestOfPoints : finestOfCover),
        edgeAtRim(0.0),
        clearance_(0.0),
        bounds_(container.bounds()),
        period_(container.period()),
        exact_(*container.wall()),
        wall_(points == AccessibleSpace::Points::exact
                  ? nullptr
                  : &exact_.coarselySampled(container.surroundings(0.0))),
        points_(1, Vec3::Zero()),
        thinAxis_(Vec3::UnitY()),
        orientations_(1, Quaternion::Identity()),
        turned_(1, points_) {}

  const double radius, thin;            ///< of the cell [µm]
  const double longestEdge, edgeAtRim;  ///< of the smallest parts [µm]

  /// The orientation of this number at a place.
  Quaternion orientation(std::int16_t number, const Vec3& centre) const {
    if (number != alongWall) return orientations_[number];
    if (orientations_.size() == 1) return orientations_.front();
    const Quaternion along = Quaternion::FromTwoVectors(thinAxis_, sample(centre).gradient);
    return freedom_.cone ? freedom_.cone->nearest(along) : along;
  }

  bool isPeriodic(int axis) const { return period_[axis] > 0.0; }
  /// The image of a point in the bounds.
  Vec3 within(Vec3 p) const {
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0.0) p[k] -= period_[k] * std::floor((p[k] - bounds_.lo[k]) / period_[k]);
    return p;
  }
  /// Depth of a point in the space that membranes may be in [µm], with its gradient.
  DistanceSample sample(const Vec3& p) const {
    const Vec3 at = within(p);
    DistanceSample depth = wall_ ? wall_->sample(at) : exact_.distance(at);
    depth.distance -= clearance_;
    if (!layer_) return depth;
    DistanceSample inner = layer_->sample(at);
    inner.distance -= freedom_.freeLayer->thickness;
    return inner.distance < depth.distance ? inner : depth;
  }
  double depth(const Vec3& p) const {
    if (!wall_) return sample(p).distance;
    const Vec3 at = within(p);
    const double depth = wall_->distance(at) - clearance_;
    return layer_ ? std::min(depth, layer_->distance(at) - freedom_.freeLayer->thickness) : depth;
  }
  /// The same at the centre of a part with this reach, without samples if it is large: those far from walls
  /// are dear [µm].
  double depthOf(const Vec3& p, double reach) const {
    if (wall_ && reach < farReach * wall_->spacing()) return depth(p);
    const Vec3 at = within(p);
    const double depth = exact_.distance(at).distance - clearance_;
    return layer_ ? std::min(depth,
                             freedom_.freeLayer->wall->distance(at).distance - freedom_.freeLayer->thickness)
                  : depth;
  }
  /// Depth of a point in the region of centres [µm].
  double depthInRegion(const Vec3& p) const {
    return freedom_.region ? freedom_.region->distance(p).distance : std::numeric_limits<double>::infinity();
  }

  /// @param least depth of its points [µm]
  bool fits(const Vec3& centre, const Quaternion& orientation, double least = 0.0) const {
    const Mat3 turn = orientation.toRotationMatrix();
    return std::all_of(points_.begin(), points_.end(),
                       [&](const Vec3& point) { return depth(centre + turn * point) >= least; });
  }

  /// For each of the orientations the point that was in the wall last: probably so are those of cells nearby.
  using InWall = std::array<std::uint8_t, orientationsTried>;

  bool fitsAlongWall(const Vec3& centre, double least = 0.0) const {
    return fits(centre, orientation(alongWall, centre), least);
  }
  /// An orientation in which it fits, and with its centre in the region; `nowhere`: none.
  /// @param rim tries that along the wall alone
  std::int16_t orientationAt(const Vec3& centre, bool rim, InWall& inWall) const {
    if (depthInRegion(centre) < 0.0 || depth(centre) < leastDepth * thin) return nowhere;
    if (fitsAlongWall(centre)) return alongWall;
    for (std::size_t i = 0; i < orientations_.size() && !rim; ++i)
      if (fitsTurned(centre, i, inWall[i])) return std::int16_t(i);
    return nowhere;
  }
  std::int16_t orientationAt(const Vec3& centre) const {
    InWall inWall{};
    return orientationAt(centre, false, inWall);
  }

  /// The parts of a part, with what their centres tell.
  std::array<AccessibleSpace::Part, 8> examinedParts(const AccessibleSpace::Part& part) const {
    std::array<AccessibleSpace::Part, 8> children = divided(part);
    bool fitsInOne = false;
    for (AccessibleSpace::Part& child : children) {
      if (child.orientation == undecided) child.orientation = examined(child);
      fitsInOne = fitsInOne || child.orientation >= anyOrientation;
    }
    for (AccessibleSpace::Part& child : children)
      if (fitsInOne && child.orientation == undecided && 2.0 * double(child.half.maxCoeff()) <= edgeAtRim)
        child.orientation = atRim;
    return children;
  }

 private:
  static constexpr double farReach = 2.0;  ///< [spacings of the samples]

  std::vector<Vec3> turnedBy(const Quaternion& orientation) const {
    const Mat3 turn = orientation.toRotationMatrix();
    std::vector<Vec3> turned;
    for (const Vec3& point : points_) turned.push_back(turn * point);
    return turned;
  }

  /// fits() in one of the orientations.
  bool fitsTurned(const Vec3& centre, std::size_t orientation, std::uint8_t& inWall) const {
    const std::vector<Vec3>& points = turned_[orientation];
    if (depth(centre + points[inWall]) < 0.0) return false;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (depth(centre + points[i]) < 0.0) {
        inWall = std::uint8_t(i);
        return false;
      }
    return true;
  }

  /// Whether a cell fits nowhere or anywhere in a part, as far as the part's centre tells.
  std::int16_t examined(const AccessibleSpace::Part& part) const {
    const double reach = double(part.half.norm()), inRegion = depthInRegion(part.centre);
    if (inRegion + reach < 0.0) return nowhere;
    const double depth = depthOf(part.centre, reach);
    if (depth + reach < thin) return nowhere;
    if (inRegion < reach) return undecided;
    if (depth - reach >= radius) return anyOrientation;
    const bool tries = depth - reach >= leastDepth * thin && reach <= radius;
    return tries && fitsAlongWall(part.centre, reach) ? alongWall : undecided;
  }

  Freedom freedom_;
  double clearance_;  ///< [µm]
  Box bounds_;
  Vec3 period_;
  const Wall& exact_;
  const SampledDistance* wall_;  ///< nullptr: not sampled
  const SampledDistance* layer_ = nullptr;
  std::vector<Vec3> points_;
  Vec3 thinAxis_;
  std::vector<Quaternion> orientations_;
  std::vector<std::vector<Vec3>> turned_;  ///< the points, in each of them
};

namespace {

/// The parts of those parts that are open, in which a cell may fit.
/// @param counts their number for each of those
std::vector<AccessibleSpace::Part> partsOf(const CellFit& fit,
                                           const std::vector<AccessibleSpace::Part>& parts,
                                           const std::vector<std::size_t>& open, const Threads& threads,
                                           std::vector<std::uint8_t>& counts) {
  std::vector<std::vector<AccessibleSpace::Part>> found((open.size() + partsAtOnce - 1) / partsAtOnce);
  threads.forEachPart(
      std::int64_t(open.size()),
      [&](std::int64_t begin, std::int64_t end, int) {
        std::vector<AccessibleSpace::Part>& own = found[begin / partsAtOnce];
        own.reserve(8 * (end - begin));
        for (std::int64_t i = begin; i < end; ++i)
          for (const AccessibleSpace::Part& part : fit.examinedParts(parts[open[i]])) {
            if (part.orientation == nowhere) continue;
            own.push_back(part);
            ++counts[i];
          }
      },
      partsAtOnce);
  std::size_t size = 0;
  for (const auto& own : found) size += own.size();
  std::vector<AccessibleSpace::Part> all;
  all.reserve(size);
  for (const auto& own : found) all.insert(all.end(), own.begin(), own.end());
  return all;
}

/// The parts that were not divided, those of each divided one after the other.
std::vector<AccessibleSpace::Part> inOrder(const std::vector<std::vector<AccessibleSpace::Part>>& ofLevel,
                                           const std::vector<std::vector<std::uint8_t>>& counts,
                                           std::size_t total) {
  std::vector<AccessibleSpace::Part> parts;
  parts.reserve(total);
  struct Place {
    std::size_t part = 0, divided = 0;  ///< the next ones
    int left = 0;                       ///< of the parts of a divided one
  };
  std::vector<Place> places(ofLevel.size());
  places[0].left = 1;
  for (std::size_t level = 0;;) {
    Place& here = places[level];
    if (here.left == 0) {
      if (level-- == 0) return parts;
      continue;
    }
    --here.left;
    const AccessibleSpace::Part& part = ofLevel[level][here.part++];
    if (part.orientation != isDivided) {
      parts.push_back(part);
      continue;
    }
    places[level + 1].left = counts[level][here.divided++];
    ++level;
  }
}

}  // namespace

AccessibleSpace::AccessibleSpace(const Physics& physics, int species, const Threads& threads,
                                 std::size_t mostParts)
    : fit_(std::make_unique<CellFit>(physics, species)) {
  Box room = physics.container->bounds();
  if (const auto& region = physics.species[species].freedom.region) {
    room.lo = room.lo.cwiseMax(region->bounds().lo);
    room.hi = room.hi.cwiseMin(region->bounds().hi);
  }
  find(room, threads, mostParts);
}

AccessibleSpace::AccessibleSpace(const Container& container, const Threads& threads, Points points)
    : fit_(std::make_unique<CellFit>(container, points)) {
  find(container.bounds(), threads, mostPartsOfSpace, points == Points::covered);
}

void AccessibleSpace::find(const Box& room, const Threads& threads, std::size_t mostParts, bool covers) {
  if (room.empty()) return;
  const auto edge = [](const Part& part) { return 2.0 * double(part.half.maxCoeff()); };
  // The parts of each size, and of those that were divided how many of their parts are left.
  std::vector<std::vector<Part>> ofLevel = {{{room.center(), (0.5 * room.size()).cast<float>(), undecided}}};
  std::vector<std::vector<std::uint8_t>> counts;
  levels_ = {ofLevel[0][0].half};
  while (2.0 * double(levels_.back().maxCoeff()) > fit_->longestEdge)
    levels_.push_back(halved(levels_.back()));
  std::size_t total = 1;
  while (complete_) {
    std::vector<Part>& parts = ofLevel.back();
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < parts.size(); ++i)
      if (parts[i].orientation == undecided && edge(parts[i]) > fit_->longestEdge) open.push_back(i);
    if (open.empty()) break;
    if (total + 7 * open.size() > mostParts) {
      complete_ = std::all_of(open.begin(), open.end(),
                              [&](std::size_t i) { return edge(parts[i]) <= coarsest * fit_->longestEdge; });
      break;
    }
    counts.emplace_back(open.size());
    std::vector<Part> next = partsOf(*fit_, parts, open, threads, counts.back());
    for (const std::size_t i : open) parts[i].orientation = isDivided;
    total += next.size() - open.size();
    ofLevel.push_back(std::move(next));
  }
  std::vector<Part> parts = inOrder(ofLevel, counts, total);
  if (covers) complete_ = false;
  if (complete_) {
    threads.forEachPart(
        std::int64_t(parts.size()),
        [&](std::int64_t begin, std::int64_t end, int) {
          CellFit::InWall inWall{};
          for (std::int64_t i = begin; i < end; ++i)
            if (parts[i].orientation < anyOrientation)
              parts[i].orientation =
                  fit_->orientationAt(parts[i].centre, parts[i].orientation == atRim, inWall);
        },
        partsAtOnce);
    parts.erase(
        std::remove_if(parts.begin(), parts.end(), [](const Part& p) { return p.orientation == nowhere; }),
        parts.end());
  }
  parts_ = std::move(parts);
  double sum = 0.0;
  for (const Part& part : parts_) ends_.push_back(sum += part.volume());
}

AccessibleSpace::~AccessibleSpace() = default;

namespace {

/// A cell of a grid, by its key, and a part.
struct Occupied {
  std::int64_t key;
  int part;
};

/// The cells at the faces of parts, by ascending keys.
std::vector<Occupied> occupiedCells(const std::vector<AccessibleSpace::Part>& parts, const Vec3& origin,
                                    const Vec3& edge) {
  std::vector<Occupied> occupied;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Vec3 from = parts[i].centre - origin, inner = 0.999 * parts[i].half.cast<double>();
    const auto lo = gridIndex(from - inner, edge), hi = gridIndex(from + inner, edge);
    for (std::int64_t z = lo[2]; z <= hi[2]; ++z)
      for (std::int64_t y = lo[1]; y <= hi[1]; ++y) {
        const bool atFace = z == lo[2] || z == hi[2] || y == lo[1] || y == hi[1];
        const std::int64_t step = atFace ? 1 : std::max<std::int64_t>(1, hi[0] - lo[0]);
        for (std::int64_t x = lo[0]; x <= hi[0]; x += step) occupied.push_back({keyOf({x, y, z}), int(i)});
      }
  }
  std::sort(occupied.begin(), occupied.end(),
            [](const Occupied& a, const Occupied& b) { return a.key < b.key; });
  return occupied;
}

}  // namespace

std::vector<double> AccessibleSpace::apart() const {
  // On a grid about as fine as the smallest boxes, unless that has too many cells.
  if (parts_.empty()) return {};
  Box box;
  for (const Part& part : parts_) box.add(part.centre - part.half.cast<double>());
  const Vec3 edge = Vec3::Constant(std::max(double(fit_->longestEdge), std::cbrt(volume() / mostGridCells)));
  const auto cellOf = [&](const Vec3& p) { return gridIndex(p - box.lo, edge); };
  std::vector<Occupied> occupied = occupiedCells(parts_, box.lo, edge);
  UnionFind joined(parts_.size());
  std::size_t cells = 0;  // of each one of its parts
  for (const Occupied& one : occupied)
    if (cells > 0 && one.key == occupied[cells - 1].key)
      joined.join(one.part, occupied[cells - 1].part);
    else
      occupied[cells++] = one;
  occupied.resize(cells);
  for (int k = 0; k < 3; ++k) {
    GridIndex ahead{};
    ahead[k] = 1;
    const std::int64_t step = keyOf(ahead);
    auto next = occupied.cbegin();  // beside `one`, with the keys of which it increases
    for (const Occupied& one : occupied) {
      while (next != occupied.cend() && next->key < one.key + step) ++next;
      if (next != occupied.cend() && next->key == one.key + step) joined.join(one.part, next->part);
    }
    if (!fit_->isPeriodic(k)) continue;
    for (const Occupied& one : occupied) {  // across periodic faces
      const GridIndex cell = cellOfKey(one.key);
      Vec3 beside = Vec3::Constant(0.5);
      for (int axis = 0; axis < 3; ++axis) beside[axis] += double(cell[axis]);
      beside[k] += 1.0;
      const std::int64_t key = keyOf(cellOf(fit_->within(box.lo + edge.cwiseProduct(beside))));
      if (key == one.key + step) continue;
      const auto found =
          std::lower_bound(occupied.cbegin(), occupied.cend(), key,
                           [](const Occupied& other, std::int64_t wanted) { return other.key < wanted; });
      if (found != occupied.cend() && found->key == key) joined.join(one.part, found->part);
    }
  }
  std::map<int, double> volumes;
  for (std::size_t i = 0; i < parts_.size(); ++i)
    volumes[joined.first(int(i))] += parts_[i].volume() / volume();
  std::vector<double> shares;
  for (const auto& [set, share] : volumes) shares.push_back(share);
  std::sort(shares.rbegin(), shares.rend());
  return shares;
}

std::optional<Pose> AccessibleSpace::fitting(const Vec3& centre, const Quaternion& wanted) const {
  if (fit_->depthInRegion(centre) < 0.0 || fit_->depth(centre) < 0.0) return {};
  if (fit_->fits(centre, wanted)) return Pose{1.0, wanted, centre};
  const std::int16_t orientation = fit_->orientationAt(centre);
  if (orientation == nowhere) return {};
  return Pose{1.0, fit_->orientation(orientation, centre), centre};
}

Pose AccessibleSpace::pose(double at, const std::array<double, 4>& within, const Quaternion& wanted) const {
  const auto found = std::upper_bound(ends_.begin(), ends_.end(), at * volume());
  const Part& part = parts_[std::min<std::size_t>(found - ends_.begin(), parts_.size() - 1)];
  Pose pose;
  const Vec3 offset = Vec3(within[0], within[1], within[2]) - Vec3::Constant(0.5);
  pose.position = part.centre + 2.0 * part.half.cast<double>().cwiseProduct(offset);
  pose.orientation = wanted;
  if (part.orientation == anyOrientation) return pose;
  if (fit_->depthInRegion(pose.position) < 0.0) pose.position = part.centre;
  if (fit_->fits(pose.position, wanted)) return pose;
  if (part.orientation < anyOrientation) {
    const std::int16_t orientation = fit_->orientationAt(pose.position);
    if (orientation != nowhere) pose.orientation = fit_->orientation(orientation, pose.position);
    return pose;
  }
  pose.orientation = fit_->orientation(part.orientation, pose.position);
  if (fit_->fits(pose.position, pose.orientation)) return pose;
  pose.position = part.centre;
  pose.orientation = fit_->orientation(part.orientation, part.centre);
  return pose;
}

AccessibleSpaces::AccessibleSpaces(const Physics& physics, const Threads& threads)
    : physics_(physics), threads_(threads), made_(physics.species.size()) {}

const AccessibleSpace* AccessibleSpaces::of(int species) {
  const Wall* const wall = physics_.wallOf(species);
  if (!wall || wall->closedForm()) return nullptr;
  std::unique_ptr<const AccessibleSpace>& space = made_[species];
  if (!space) space = std::make_unique<const AccessibleSpace>(physics_, species, threads_);
  return space->volume() > 0.0 ? space.get() : nullptr;
}

}  // namespace packmesh
