// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/placement.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "packMesh/core/random.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/parallel/blocks.h"
#include "packMesh/placement/accessible_space.h"

namespace packmesh {
namespace {

/// Number of tries per cell; if all fail (a lumen that fills a tiny part of its bounds), the best one is
/// used.
constexpr std::uint32_t tries = 2000;

/// A space that is less than this share of its bounds is drawn from at once.
constexpr double sparse = 0.2;

/// Poses that are drawn from the accessible space until one does not meet the wall: only thin plates are
/// overlooked, unless the space is incomplete.
constexpr std::uint32_t drawn = 12, drawnFromIncomplete = 100;

/// Cells between two polls: a fraction of a second even if all tries fail.
constexpr std::int64_t betweenPolls = 100;

/// The first tries use a quasirandom sequence, which has fewer clusters and holes than independent points, so
/// that cells have to move less: at a volume fraction of 0.35 this saves a quarter of the sweeps, at 0.55 a
/// twentieth.
constexpr std::uint32_t evenTries = 8;

/// Orientations that are tried until a cell does not meet its own images.
constexpr std::uint32_t clearTries = 200;

/// Position at which to try to place the centre of a cell.
Vec3 centre(const Box& room, double volume, std::uint64_t seed, std::uint64_t id, std::uint32_t attempt) {
  const auto u = uniform4(seed, RandomStream::position, id, attempt);
  Vec3 at(u[0], u[1], u[2]);
  if (attempt < evenTries) {
    const Vec3 reach = 2.0 * jitter * std::cbrt(volume) * room.size().cwiseInverse();
    const auto begin = uniform4(seed, RandomStream::begin, 0, attempt);  // of every try its own
    at = evenPoint(begin, id, (at - Vec3::Constant(0.5)).cwiseProduct(reach));
  }
  return room.lo + room.size().cwiseProduct(at);
}

/// Axis uniform over the cone, with a uniform rotation about it, from three uniform numbers.
Quaternion withinCone(const AxisCone& cone, double u, double v, double w) {
  constexpr double twoPi = 6.283185307179586;
  const double c = 1.0 - u * (1.0 - std::cos(cone.spread)), s = std::sqrt(std::max(0.0, 1.0 - c * c));
  const Quaternion tilt =
      Quaternion::FromTwoVectors(Vec3::UnitY(), Vec3(s * std::cos(twoPi * v), c, s * std::sin(twoPi * v)));
  const Quaternion toAxis = Quaternion::FromTwoVectors(Vec3::UnitY(), cone.axis);
  const Quaternion turn(Quaternion::around(Vec3::UnitY(), twoPi * w));
  return cone.nearest((toAxis * tilt * turn).normalized());
}

/// The orientation in which a cell is placed at first.
Quaternion firstOrientation(const Physics& physics, const Freedom& freedom, const Shape& shape,
                            std::uint64_t id) {
  if (!physics.rotate) return Quaternion::Identity();
  Quaternion orientation;
  for (std::uint32_t attempt = 0; attempt < clearTries; ++attempt) {
    const auto u = uniform4(physics.seed, RandomStream::orientation, id, attempt);
    orientation = randomOrientation(freedom.cone, u[0], u[1], u[2]);
    if (isClearOfItself(physics, shape, orientation)) break;
  }
  return orientation;
}

}  // namespace

Vec3 evenPoint(const std::array<double, 4>& begin, std::uint64_t n, const Vec3& offset) {
  constexpr double g = 1.22074408460575947536, step[] = {1.0 / g, 1.0 / (g * g), 1.0 / (g * g * g)};
  Vec3 point;
  for (int k = 0; k < 3; ++k) {
    const double p = begin[k] + static_cast<double>(n) * step[k] + offset[k];
    point[k] = p - std::floor(p);
  }
  return point;
}

double evenShare(double begin, std::uint64_t n) {
  constexpr double golden = 0.618033988749894848;
  const double share = begin + golden * static_cast<double>(n);
  return share - std::floor(share);
}

Quaternion randomOrientation(const std::optional<AxisCone>& cone, double u, double v, double w) {
  return cone ? withinCone(*cone, u, v, w) : uniformRotation(u, v, w);
}

bool isClearOfItself(const Physics& physics, const Shape& shape, const Quaternion& orientation) {
  const Vec3& period = physics.container->period();
  const double reach = 2.0 * shape.radius();
  std::array<int, 3> most = {0, 0, 0};
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) most[k] = int(reach / period[k]);
  const Placement at = Pose{1.0, orientation, Vec3::Zero()}.placement();
  for (int i = 0; i <= most[0]; ++i)
    for (int j = i == 0 ? 0 : -most[1]; j <= most[1]; ++j)
      for (int k = i == 0 && j == 0 ? 1 : -most[2]; k <= most[2]; ++k) {
        const Vec3 shift = period.cwiseProduct(Vec3(i, j, k));
        if (shift.norm() > reach) continue;
        const Placement image = {at.linear, at.translation + shift};
        if (relate(shape.hierarchy(), at, shape.hierarchy(), image).relation != MeshRelation::apart)
          return false;
      }
  return true;
}

std::vector<Pose> placeRandomly(const Physics& physics, const Execution& execution, int species,
                                int shapeNumber, std::int64_t firstId, std::int64_t count,
                                const AccessibleSpace* space) {
  std::vector<Pose> poses(count);
  const Shape& shape = *physics.shapes[shapeNumber];
  const Wall* wall = physics.wallOf(species);
  const Freedom& freedom = physics.species[species].freedom;
  const Region* region = freedom.region.get();
  const Box room = region ? region->bounds() : physics.container->bounds();
  const double wanted = shape.bound().semiAxes.minCoeff();
  const auto meetsWall = [&](const Pose& pose) {
    return wall->examine({shape.hierarchy(), pose.placement()}, 0.0).violation.has_value();
  };
  const bool inBounds = space && space->volume() > sparse * room.volume();
  const auto placeWithin = [&](std::uint64_t id, Pose& pose) {
    const Quaternion wish = firstOrientation(physics, freedom, shape, id);
    for (std::uint32_t attempt = inBounds ? 0 : evenTries; attempt < evenTries; ++attempt) {
      const auto fit = space->fitting(centre(room, shape.volume(), physics.seed, id, attempt), wish);
      if (!fit) continue;
      pose = *fit;
      if (!meetsWall(pose)) return;
    }
    const std::uint32_t last = evenTries + (space->complete() ? drawn : drawnFromIncomplete);
    for (std::uint32_t attempt = evenTries; attempt < last; ++attempt) {
      const auto begin = uniform4(physics.seed, RandomStream::begin, 1, attempt);
      pose = space->pose(evenShare(begin[0], id), uniform4(physics.seed, RandomStream::position, id, attempt),
                         wish);
      if (!meetsWall(pose)) return;
    }
  };
  const auto place = [&](std::int64_t i) {
    const std::uint64_t id = firstId + i;
    Pose& pose = poses[i];
    if (space) return placeWithin(id, pose);
    double best = -std::numeric_limits<double>::infinity();
    for (std::uint32_t attempt = 0; attempt < tries && best < wanted; ++attempt) {
      const Vec3 p = centre(room, shape.volume(), physics.seed, id, attempt);
      double distance = wall != nullptr ? wall->distance(p).distance : wanted;
      if (region) distance = std::min(distance, wanted + std::min(region->distance(p).distance, 0.0));
      if (distance <= best) continue;
      best = distance;
      pose.position = p;
    }
    pose.orientation = firstOrientation(physics, freedom, shape, id);
  };
  std::atomic<bool> stops{false};
  execution.threads.forEachPart(
      count,
      [&](std::int64_t begin, std::int64_t end, int thread) {
        if (thread == 0 && execution.interrupted && execution.interrupted()) stops = true;
        for (std::int64_t i = begin; i < end && !stops; ++i) place(i);
      },
      betweenPolls);
  return poses;
}

namespace {

using Periods = std::array<int, 3>;

/// Columns close after at most this many periods of an edge. In large boxes, where one cell more or less in a
/// long column does not matter, they are parallel to edges.
constexpr int mostPeriods = 4;
constexpr std::int64_t manyCells = 20000;

/// Number of column counts tried, beginning with the smallest that could hold all cells.
constexpr int numbersTried = 100;

/// The hexagonal lattice has the smallest area per column for a given distance d: sqrt(3)/2 d².
constexpr double hexagonalArea = 0.8660254037844386;

/// Bounding cylinder of a cell about an axis of its body frame.
struct Cylinder {
  int axis = 1;
  double radius = 0.0, height = 0.0, middle = 0.0;
};

Cylinder cylinderOf(const Shape& shape) {
  const Box box = boundingBox(shape.mesh());
  Cylinder c;
  c.height = box.size().minCoeff(&c.axis);
  c.middle = box.center()[c.axis];
  for (Vec3 v : shape.mesh().vertices) {
    v[c.axis] = 0.0;
    c.radius = std::max(c.radius, v.norm());
  }
  return c;
}

/// A basis of the same plane lattice with the shortest vector first (Lagrange reduction).
std::pair<Vec2, Vec2> reduced(Vec2 u, Vec2 v) {
  for (;;) {
    if (v.squaredNorm() < u.squaredNorm()) std::swap(u, v);
    const Vec2 shorter = v - std::round(u.dot(v) / u.squaredNorm()) * u;
    if (!(shorter.squaredNorm() < v.squaredNorm())) return {u, v};
    v = shorter;
  }
}

/// g = gcd(a, b) >= 0, and (u, v) with a u + b v = g.
struct Bezout {
  int g, u, v;
};
Bezout bezout(int a, int b) {
  if (b == 0) return {std::abs(a), a < 0 ? -1 : 1, 0};
  const Bezout below = bezout(b, a % b);
  return {below.g, below.v, below.u - (a / b) * below.v};
}

/// Possible directions of columns, one of each opposite pair: those with coprime numbers of periods.
std::vector<Periods> directions(bool alongEdgesOnly) {
  const int most = alongEdgesOnly ? 1 : mostPeriods;
  std::vector<Periods> all;
  for (int i = 0; i <= most; ++i)
    for (int j = -most; j <= most; ++j)
      for (int k = -most; k <= most; ++k) {
        if (std::make_tuple(i, j, k) <= std::make_tuple(0, 0, 0)) continue;
        if (std::gcd(std::gcd(i, j), k) != 1) continue;
        if (alongEdgesOnly && std::abs(i) + std::abs(j) + std::abs(k) > 1) continue;
        all.push_back({i, j, k});
      }
  return all;
}

/// Projection of the box along a direction: its periods form a plane lattice.
struct View {
  Vec3 along, right, up;  ///< unit, orthogonal
  double length;          ///< length of a column until it closes [µm]
  Vec2 first, second;     ///< basis of the lattice [µm]

  View(const Vec3& size, const Periods& periods) {
    const auto [a, b, c] = periods;
    const Vec3 whole = size.cwiseProduct(Vec3(a, b, c));
    length = whole.norm();
    along = whole / length;
    right = along.unitOrthogonal();
    up = along.cross(right);
    // Integer vectors that complete (a, b, c) to a basis of all integer vectors.
    const Bezout ab = bezout(a, b), all = bezout(ab.g, c);
    const int i = ab.g == 0 ? 1 : a / ab.g, j = ab.g == 0 ? 0 : b / ab.g;
    const Vec3 one = ab.g == 0 ? Vec3(0, 1, 0) : Vec3(-ab.v, ab.u, 0);
    const Vec3 other = Vec3(-all.v * i, -all.v * j, all.u);
    std::tie(first, second) = reduced(onPlane(size.cwiseProduct(one)), onPlane(size.cwiseProduct(other)));
  }

  Vec2 onPlane(const Vec3& v) const { return {right.dot(v), up.dot(v)}; }
  double area() const { return std::abs(first.x() * second.y() - first.y() * second.x()); }
};

/// A lattice of columns that contains the view's lattice: `rows` rows of `perRow` columns, each row displaced
/// by `shift` steps of 1/(perRow rows) of the first basis vector.
struct Lattice {
  std::int64_t perRow = 1, rows = 1, shift = 0;

  std::pair<Vec2, Vec2> basis(const View& view) const {
    const double p = static_cast<double>(perRow), r = static_cast<double>(rows);
    return {view.first / p, view.second / r + static_cast<double>(shift) / (p * r) * view.first};
  }
};

/// The lattice of `columns` columns with the largest distance between neighbours, and that distance [µm].
std::pair<Lattice, double> widest(const View& view, std::int64_t columns) {
  std::pair<Lattice, double> best{{}, 0.0};
  for (std::int64_t perRow = 1; perRow <= columns; ++perRow) {
    if (columns % perRow != 0) continue;
    for (std::int64_t shift = 0; shift < columns / perRow; ++shift) {
      const Lattice lattice{perRow, columns / perRow, shift};
      const auto [u, v] = lattice.basis(view);
      const double distance = reduced(u, v).first.norm();
      if (distance > best.second) best = {lattice, distance};
    }
  }
  return best;
}

}  // namespace

Columns::Columns(const Shape& shape, std::int64_t count, const Box& box, double gap, std::uint64_t seed)
    : box_(box), seed_(seed), count_(count) {
  const Cylinder cylinder = cylinderOf(shape);
  axis_ = Vec3::Unit(cylinder.axis);
  middle_ = cylinder.middle * axis_;
  const double across = 2.0 * cylinder.radius + gap, step = cylinder.height + gap;
  for (const Periods& periods : directions(count > manyCells)) {
    const View view(box.size(), periods);
    const auto perColumn = std::max<std::int64_t>(1, static_cast<std::int64_t>(view.length / step));
    const std::int64_t fewest = (count + perColumn - 1) / perColumn;
    for (std::int64_t columns = fewest; columns < fewest + numbersTried; ++columns) {
      // No lattice can exceed this: skip the search if it is not better than the best so far.
      const double most = std::sqrt(view.area() / (hexagonalArea * static_cast<double>(columns))) / across;
      if (most <= room_) break;
      const std::int64_t cells = (count + columns - 1) / columns;  // in the tallest column
      const double pitch = view.length / static_cast<double>(cells) / step;
      if (pitch <= room_) continue;
      const auto [lattice, distance] = widest(view, columns);
      const double room = std::min(pitch, distance / across);
      if (room <= room_) continue;
      room_ = room;
      along_ = view.along;
      length_ = view.length;
      feet_.clear();
      const auto [u, v] = lattice.basis(view);
      for (std::int64_t row = 0; row < lattice.rows; ++row)
        for (std::int64_t k = 0; k < lattice.perRow; ++k) {
          const Vec2 foot = static_cast<double>(k) * u + static_cast<double>(row) * v;
          feet_.push_back(foot.x() * view.right + foot.y() * view.up);
        }
    }
  }
}

Pose Columns::pose(std::int64_t cell) const {
  const std::int64_t columns = columnCount(), column = cell % columns, place = cell / columns;
  const std::int64_t cells = count_ / columns + (column < count_ % columns);  // of this column
  const double begin = uniform4(seed_, RandomStream::begin, static_cast<std::uint64_t>(column), 0)[0];
  const double height = length_ * (begin + static_cast<double>(place) / static_cast<double>(cells));
  const auto u = uniform4(seed_, RandomStream::orientation, static_cast<std::uint64_t>(cell), 0);
  constexpr double twoPi = 6.283185307179586;
  Pose pose;
  pose.orientation = (Quaternion::FromTwoVectors(axis_, u[0] < 0.5 ? along_ : Vec3(-along_)) *
                      Quaternion::around(axis_, twoPi * u[1]))
                         .normalized();
  pose.position =
      wrapped(box_.lo + feet_[column] + height * along_ - pose.orientation * middle_, box_, box_.size());
  return pose;
}

}  // namespace packmesh
