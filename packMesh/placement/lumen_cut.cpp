// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/placement/lumen_cut.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "packMesh/core/box.h"
#include "packMesh/core/error.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/union_find.h"
#include "packMesh/placement/accessible_space.h"

namespace packmesh {
namespace {

using Part = AccessibleSpace::Part;

/// How far the point of a cut may be from all parts, so that points next to the wall count as inside
/// [edges of the smallest parts].
constexpr double nextTo = 1.5;

/// The parts of a space, found by points in them.
class PartGrid {
 public:
  PartGrid(const AccessibleSpace& space, const Vec3& origin) : parts_(space.parts()), origin_(origin) {
    for (const Vec3f& half : space.levels()) levels_.push_back({2.0 * half.cast<double>(), {}});
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      level_.push_back(int(std::find(space.levels().begin(), space.levels().end(), parts_[i].half) -
                           space.levels().begin()));
      levels_[level_[i]].parts[keyAt(parts_[i].centre, level_[i])] = int(i);
    }
  }

  int levels() const { return int(levels_.size()); }
  const Vec3& edge(int level) const { return levels_[level].edge; }
  const Vec3& edgeOf(int part) const { return edge(level_[part]); }
  int levelOf(int part) const { return level_[part]; }
  std::int64_t keyAt(const Vec3& p, int level) const { return keyOf(gridIndex(p - origin_, edge(level))); }

  /// The part that contains a point; -1: none.
  int at(const Vec3& p) const {
    for (int level = levels() - 1; level >= 0; --level)
      if (const auto found = levels_[level].parts.find(keyAt(p, level)); found != levels_[level].parts.end())
        return found->second;
    return -1;
  }

  /// Calls visit(part, other, place) where another part, not smaller, is beside a part: beyond its faces, or
  /// also beyond edges and corners. `place` is on the border of both. Boxes are halved along the same planes,
  /// so it suffices to look there.
  template <class Visit>
  void forEachContact(bool diagonally, const std::vector<int>& of, const Visit& visit) const {
    constexpr double little = 0.1;  // [edges of the smallest parts]
    const Vec3 step = little * edge(levels() - 1);
    for (const int i : of)
      for (int n = 0; n < 27; ++n) {
        const Vec3 towards(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        const int axes = int(towards.cwiseAbs().sum());
        if (axes == 0 || (axes > 1 && !diagonally)) continue;
        const Vec3 place = parts_[i].centre + 0.5 * towards.cwiseProduct(edgeOf(i));
        const int other = at(place + towards.cwiseProduct(step));
        if (other >= 0 && level_[other] <= level_[i]) visit(i, other, place);
      }
  }

 private:
  struct Level {
    Vec3 edge;  ///< [µm]
    std::unordered_map<std::int64_t, int> parts;
  };
  const std::vector<Part>& parts_;
  Vec3 origin_;
  std::vector<Level> levels_;
  std::vector<int> level_;  ///< of each part
};

std::vector<int> numbersTo(std::size_t count) {
  std::vector<int> all(count);
  for (std::size_t i = 0; i < count; ++i) all[i] = int(i);
  return all;
}

/// The parts that the plane of a cut meets around its point.
std::vector<char> findSection(const AccessibleSpace& space, const PartGrid& grid, const Vec3& point,
                              const Vec3& normal) {
  const std::vector<Part>& parts = space.parts();
  const Vec3 steep = normal.cwiseAbs();
  constexpr double rounding = 1e-6;  // [edges], of the sizes in single precision
  std::vector<int> meeting;
  std::vector<int> order(parts.size(), -1);  // among them
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double reach = 0.5 * steep.dot(grid.edgeOf(int(i)));
    if (std::abs((parts[i].centre - point).dot(normal)) > (1.0 + rounding) * reach) continue;
    order[i] = int(meeting.size());
    meeting.push_back(int(i));
  }
  UnionFind joined(meeting.size());
  grid.forEachContact(true, meeting, [&](int i, int other, const Vec3& place) {
    if (order[other] >= 0 && std::abs((place - point).dot(normal)) <= steep.dot(grid.edgeOf(i)))
      joined.join(order[i], order[other]);
  });
  int nearest = -1;
  double least = std::pow(nextTo * grid.edge(grid.levels() - 1).maxCoeff(), 2);
  for (std::size_t m = 0; m < meeting.size(); ++m) {
    const Vec3& centre = parts[meeting[m]].centre;
    const Vec3 half = 0.5 * grid.edgeOf(meeting[m]);
    const double away = Box{centre - half, centre + half}.squaredDistance(point);
    if (away < least) least = away, nearest = int(m);
  }
  if (nearest < 0) throw InputError(fmt::format("the point {} is not in the lumen", toText(point)));
  std::vector<char> section(parts.size(), 0);
  for (std::size_t m = 0; m < meeting.size(); ++m)
    section[meeting[m]] = joined.first(int(m)) == joined.first(nearest);
  return section;
}

/// The parts that are connected with the far side of the section.
std::vector<char> flood(const AccessibleSpace& space, const PartGrid& grid, const std::vector<char>& section,
                        const Vec3& point, const Vec3& normal) {
  const std::vector<Part>& parts = space.parts();
  const std::vector<int> all = numbersTo(parts.size());
  UnionFind joined(parts.size());
  grid.forEachContact(false, all, [&](int i, int other, const Vec3&) {
    if (!section[i] && !section[other]) joined.join(i, other);
  });
  std::vector<char> isBefore(parts.size(), 0), isBeyond(parts.size(), 0);
  grid.forEachContact(false, all, [&](int i, int other, const Vec3& place) {
    if (section[i] == section[other]) return;
    const int outer = section[i] ? other : i;
    const double depth = (parts[outer].centre - point).dot(normal);
    const bool isMet = std::abs(depth) <= 0.5 * normal.cwiseAbs().dot(grid.edgeOf(outer));
    const bool beyond = (isMet ? (place - point).dot(normal) : depth) > 0.0;
    (beyond ? isBeyond : isBefore)[joined.first(outer)] = 1;
  });
  std::vector<char> flooded(parts.size(), 0);
  for (const int i : all) {
    const int set = joined.first(i);
    flooded[i] = isBeyond[set];
    if (isBeyond[set] && isBefore[set])
      throw InputError(fmt::format(
          "the cut at {} does not separate the lumen: its two sides are connected elsewhere", toText(point)));
  }
  return flooded;
}

}  // namespace

LumenCut::LumenCut(const Container& lumen, const Vec3& point, const Vec3& direction, const Threads& threads)
    : lumen_(lumen.bounds()), period_(lumen.period()), point_(point), normal_(direction.normalized()) {
  if (!lumen.wall()) throw InputError("a lumen without walls cannot be cut");
  const AccessibleSpace space(lumen, threads, AccessibleSpace::Points::exact);
  if (!space.complete()) throw InputError("the lumen is too large to find what is beyond a cut");
  const std::vector<Part>& parts = space.parts();
  const PartGrid grid(space, lumen_.lo);
  const std::vector<char> section = findSection(space, grid, point, normal_);
  const std::vector<char> flooded = flood(space, grid, section, point, normal_);
  for (int level = grid.levels() - 1; level >= 0; --level) levels_.push_back({grid.edge(level), {}});
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const Vec3 half = 0.5 * grid.edgeOf(int(i));
    const Side side = section[i] ? Side::cut : flooded[i] ? Side::beyond : Side::before;
    // The boxes around it, too: points next to the wall are in no part.
    for (int level = grid.levelOf(int(i)); level >= 0; --level) {
      const auto [found, isNew] =
          levels_[grid.levels() - 1 - level].sides.insert({grid.keyAt(parts[i].centre, level), side});
      if (!isNew && (found->second == side || found->second == Side::cut)) break;
      found->second = isNew ? side : Side::cut;
    }
    if (side == Side::before) continue;
    bounds_.add(parts[i].centre - half);
    bounds_.add(parts[i].centre + half);
    if (side != Side::cut) continue;
    const Vec3 from = parts[i].centre - point;
    radius_ = std::max(radius_, (from - from.dot(normal_) * normal_).norm() + half.norm());
  }
  const Vec3 margin = grid.edge(grid.levels() - 1);
  bounds_.lo = (bounds_.lo - margin).cwiseMax(lumen_.lo);
  bounds_.hi = (bounds_.hi + margin).cwiseMin(lumen_.hi);
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (int k = 0; k < 3; ++k)
      for (const int end : {0, 1}) {
        if (period_[k] == 0.0 || !(section[i] || flooded[i])) continue;
        Vec3 beside = parts[i].centre;
        const double face = end ? lumen_.hi[k] : lumen_.lo[k];
        if (std::abs(face - beside[k]) > 0.75 * grid.edgeOf(int(i))[k]) continue;
        beside[k] = end ? lumen_.lo[k] + 0.25 * margin[k] : lumen_.hi[k] - 0.25 * margin[k];
        const int other = grid.at(beside);
        if (other >= 0 && !section[other] && !flooded[other]) ends_[k][end] = true;
      }
}

LumenCut::Side LumenCut::sideAt(const Vec3& p) const {
  for (const Level& level : levels_)
    if (const auto found = level.sides.find(keyOf(gridIndex(p - lumen_.lo, level.edge)));
        found != level.sides.end())
      return found->second;
  return Side::cut;
}

WallDistance LumenCut::distance(const Vec3& given) const {
  Vec3 p = given;
  for (int k = 0; k < 3; ++k)
    if (period_[k] > 0.0) p[k] -= period_[k] * std::floor((p[k] - lumen_.lo[k]) / period_[k]);
  const double depth = (p - point_).dot(normal_);
  const Vec3 sideways = p - point_ - depth * normal_;
  const double outside = sideways.norm() - radius_;
  const Side side = sideAt(p);
  const bool beyond = side == Side::cut ? depth >= 0.0 : side == Side::beyond;
  // Away from the disc.
  WallDistance nearest{std::abs(depth), depth >= 0.0 ? normal_ : Vec3(-normal_)};
  if (outside > 0.0)
    nearest = {std::hypot(depth, outside), (depth * normal_ + outside * sideways.normalized()).normalized()};
  if (!beyond) nearest = {-nearest.distance, -nearest.gradient};
  for (int k = 0; k < 3; ++k)
    for (const int end : {0, 1}) {
      if (!ends_[k][beyond ? end : 1 - end]) continue;
      const double away = end ? lumen_.hi[k] - p[k] : p[k] - lumen_.lo[k];
      if (away >= std::abs(nearest.distance)) continue;
      const Vec3 inwards = end ? Vec3(-Vec3::Unit(k)) : Vec3(Vec3::Unit(k));
      nearest = beyond ? WallDistance{away, inwards} : WallDistance{-away, Vec3(-inwards)};
    }
  return nearest;
}

}  // namespace packmesh
