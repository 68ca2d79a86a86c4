// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "packMesh/core/poll.h"
#include "packMesh/core/tolerances.h"

namespace packmesh {
ClosestPoint::ClosestPoint(const TriangleMesh& mesh) : tree_(mesh) {
  const std::size_t n = mesh.triangles.size();
  facets_.reserve(n);
  normals_.resize(n);
  struct Side {
    int lo, hi, triangle, edge;
  };
  std::vector<Side> sides;
  std::vector<Vec3> atVertex(mesh.vertices.size(), Vec3::Zero());
  for (std::size_t t = 0; t < n; ++t) {
    pollAt(t);
    const Triangle& corners = mesh.triangles[t];
    const Vec3& a = mesh.vertices[corners[0]];
    facets_.emplace_back(a, mesh.vertices[corners[1]], mesh.vertices[corners[2]]);
    const Vec3 normal = facets_[t].u.cross(facets_[t].v).normalized();
    normals_[t][6] = normal;
    for (int k = 0; k < 3; ++k) {
      const int here = corners[k], next = corners[(k + 1) % 3], previous = corners[(k + 2) % 3];
      const Vec3 out = mesh.vertices[next] - mesh.vertices[here],
                 back = mesh.vertices[previous] - mesh.vertices[here];
      atVertex[here] += std::atan2(out.cross(back).norm(), out.dot(back)) * normal;
      sides.push_back({std::min(here, next), std::max(here, next), static_cast<int>(t), k});
    }
  }
  for (std::size_t t = 0; t < n; ++t)
    for (int k = 0; k < 3; ++k) normals_[t][k] = atVertex[mesh.triangles[t][k]];
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.lo != b.lo ? a.lo < b.lo : a.hi != b.hi ? a.hi < b.hi : a.triangle < b.triangle;
  });
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    Vec3 sum = Vec3::Zero();
    for (to = from; to < sides.size() && sides[to].lo == sides[from].lo && sides[to].hi == sides[from].hi;
         ++to)
      sum += normals_[sides[to].triangle][6];
    for (std::size_t s = from; s < to; ++s) normals_[sides[s].triangle][3 + sides[s].edge] = sum;
  }
}

ClosestPoint::Nearest ClosestPoint::nearest(const Vec3& p, int hint, double slack) const {
  Nearest best{0.0, -1, 6, p};
  double squared = std::numeric_limits<double>::infinity();
  const double enough = 1.0 / ((1.0 + slack) * (1.0 + slack));
  const auto visit = [&](int t) {
    const Facet& facet = facets_[t];
    const Facet::Nearest on = facet.nearest(p);
    const Vec3 point = facet.at(on);
    const double d2 = (point - p).squaredNorm();
    if (d2 < squared) {
      squared = d2;
      best.triangle = t;
      best.feature = on.feature;
      best.point = point;
    }
    return squared * enough;
  };
  double bound = std::numeric_limits<double>::infinity();
  if (hint >= 0) bound = visit(hint);
  tree_.visitNearer(p, bound, visit);
  best.distance = std::sqrt(squared);
  return best;
}

ClosestPoint::Nearest ClosestPoint::onTriangle(int triangle, const Vec3& p) const {
  const Facet& facet = facets_[triangle];
  const Facet::Nearest on = facet.nearest(p);
  const Vec3 point = facet.at(on);
  return {(point - p).norm(), triangle, on.feature, point};
}

int ClosestPoint::side(const Vec3& p, const Nearest& nearest) const {
  return (p - nearest.point).dot(normals_[nearest.triangle][nearest.feature]) >= 0.0 ? 1 : -1;
}

DiscSearch::DiscSearch(const MeshTree& tree, const ClosestPoint& surface)
    : tree_(tree), surface_(surface), kernels_(triangleKernels(chosenInstructionSet())) {
  facts_.reserve(tree.mesh->triangles.size());
  for (std::size_t t = 0; t < tree.mesh->triangles.size(); ++t)
    facts_.push_back(factsOf(*tree.mesh, static_cast<int>(t)));
}

void DiscSearch::search(Query& query) const {
  struct Context {
    Query& query;
    const ClosestPoint& surface;
    float slack;
  };
  double furthest = 0.0;
  for (const Vec3& p : query.point) furthest = std::max(furthest, p.norm());
  const float slack = static_cast<float>(slackAt(furthest));
  PointLanes lanes;
  float limits[points];
  for (int k = 0; k < points; ++k) {
    lanes.x[k] = static_cast<float>(query.point[k].x());
    lanes.y[k] = static_cast<float>(query.point[k].y());
    lanes.z[k] = static_cast<float>(query.point[k].z());
    const double atMost = query.atMost[k];
    limits[k] = atMost < 0.0
                    ? -1.0f
                    : static_cast<float>(std::min((1.0 + searchGrowth) * atMost * atMost + slack, 1e30));
    query.nearest[k] = {std::numeric_limits<double>::infinity(), -1, 6, query.point[k]};
  }
  Context context{query, surface_, slack};
  const auto examine = [](void* data, const int* triangles, const float* squared, int count,
                          float(&most)[points]) {
    const Context& c = *static_cast<const Context*>(data);
    for (int k = 0; k < points; ++k)
      for (int t = 0; t < count; ++t) {
        if (squared[points * t + k] > most[k]) continue;
        const ClosestPoint::Nearest found = c.surface.onTriangle(triangles[t], c.query.point[k]);
        if (found.distance < c.query.nearest[k].distance) c.query.nearest[k] = found;
      }
  };
  kernels_.search(lanes, tree_.quads.data(), facts_.data(), slack, limits, examine, &context);
}

namespace {

constexpr int lanes = 16;

/// Points along the edge of a block that is searched as a whole.
constexpr int blockEdge = 5;

/// A block is subdivided if, for all that its middle tells, more triangles can be nearest. They are at least
/// one of so many of those.
constexpr int mostNear = 4000, fewestOfNear = 8;

/// Upper bound of the error of distances from squared distances in floats [µm].
constexpr float roundingOfFloats = 1e-4f;

/// Roughly: blocks this many times their radius inside the surface are not measured point by point, and of
/// points further from it than this [spacings] the distance is at least the true one divided by 1 + slack.
/// (In the middle of a tube all triangles around are candidates for the nearest.)
constexpr double farInside = 4.0, exactWithin = 2.0, slackBeyond = 0.01;

/// Adjacent points: first[k] ... first[k] + count[k] - 1 along each axis.
struct Block {
  int first[3], count[3];
  int points() const { return count[0] * count[1] * count[2]; }

  /// Half `k` of the block along `axis`.
  Block half(int axis, int k) const { return part(axis, (count[axis] + 1) / 2, k); }

  /// The points below (0) or from (1) the `low`-th on.
  Block part(int axis, int low, int k) const {
    Block out = *this;
    out.first[axis] += k * low;
    out.count[axis] = k == 0 ? low : count[axis] - low;
    return out;
  }
};

/// How blocks are cut into the fewest parts of at most `lanes` points, and of these the most compact ones.
class Cuts {
 public:
  struct Cut {
    int axis, low;  ///< Block::part(); low = 0: none
    double cost;    ///< of the parts
  };

  Cuts() {
    constexpr double perPart = 1e4;
    for (int x = 1; x <= blockEdge; ++x)
      for (int y = 1; y <= blockEdge; ++y)
        for (int z = 1; z <= blockEdge; ++z) {
          const int count[3] = {x, y, z};
          Cut& best = of(count);
          best = {0, 0, std::numeric_limits<double>::infinity()};
          if (x * y * z <= lanes) {
            best.cost = perPart + (x - 1) * (x - 1) + (y - 1) * (y - 1) + (z - 1) * (z - 1);
            continue;
          }
          for (int axis = 0; axis < 3; ++axis)
            for (int low = 1; low < count[axis]; ++low) {
              int part[2][3] = {{x, y, z}, {x, y, z}};
              part[0][axis] = low;
              part[1][axis] = count[axis] - low;
              const double cost = of(part[0]).cost + of(part[1]).cost;
              if (cost < best.cost) best = {axis, low, cost};
            }
        }
  }

  const Cut& of(const int (&count)[3]) const { return cuts_[count[0] - 1][count[1] - 1][count[2] - 1]; }

 private:
  Cut& of(const int (&count)[3]) { return cuts_[count[0] - 1][count[1] - 1][count[2] - 1]; }

  Cut cuts_[blockEdge][blockEdge][blockEdge];
};

/// A disc around a triangle, about the middle of its longest edge or about its centroid.
TriangleDisc discAround(const TriangleMesh& mesh, int triangle, const float (&normal)[3]) {
  const Vec3* corner[3];
  for (int k = 0; k < 3; ++k) corner[k] = &mesh.corner(triangle, k);
  const auto radiusAbout = [&](const Vec3& center) {
    double squared = 0.0;
    for (const Vec3* c : corner) squared = std::max(squared, (*c - center).squaredNorm());
    return std::sqrt(squared);
  };
  Vec3 center = (*corner[0] + *corner[1] + *corner[2]) / 3.0;
  double radius = radiusAbout(center);
  for (int k = 0; k < 3; ++k) {
    const Vec3 middle = 0.5 * (*corner[k] + *corner[(k + 1) % 3]);
    if (const double about = radiusAbout(middle); about < radius) center = middle, radius = about;
  }
  double half = 0.0;
  for (const Vec3* c : corner) {
    double height = 0.0;
    for (int k = 0; k < 3; ++k) height += double(normal[k]) * ((*c)[k] - center[k]);
    half = std::max(half, std::abs(height));
  }
  TriangleDisc disc;
  for (int k = 0; k < 3; ++k) {
    disc.center[k] = center[k];
    disc.normal[k] = normal[k];
  }
  constexpr double rounding = 1e-6;  // some of single precision
  disc.radius = static_cast<float>((1.0 + rounding) * radius);
  disc.half = static_cast<float>(half + rounding * radius);
  return disc;
}

}  // namespace

/// One call of sample().
class SignedDistances::Search {
 public:
  Search(const SignedDistances& all, const std::array<std::vector<double>, 3>& coordinates, bool rough,
         float* distances)
      : all_(all), surface_(all.surface_), coordinates_(coordinates), rough_(rough), distance_(distances) {
    slab_ = coordinates[0].size() * coordinates[1].size();
    for (const std::vector<double>& along : coordinates)
      if (along.size() > 1) exactWithin_ = std::max(exactWithin_, exactWithin * (along[1] - along[0]));
    nearest_.resize(slab_ * coordinates[2].size());
  }

  void operator()() {
    Block block;
    int n[3];
    for (int k = 0; k < 3; ++k) n[k] = static_cast<int>(coordinates_[k].size());
    for (block.first[2] = 0; block.first[2] < n[2]; block.first[2] += blockEdge)
      for (block.first[1] = 0; block.first[1] < n[1]; block.first[1] += blockEdge)
        for (block.first[0] = 0; block.first[0] < n[0]; block.first[0] += blockEdge) {
          for (int k = 0; k < 3; ++k) block.count[k] = std::min(blockEdge, n[k] - block.first[k]);
          search(block);
        }
    giveSigns();
  }

 private:
  static constexpr int inside = -1;  ///< instead of a nearest triangle: not measured, certainly inside

  std::size_t indexOf(int i, int j, int k) const { return i + coordinates_[0].size() * j + slab_ * k; }
  Vec3 position(int i, int j, int k) const {
    return {coordinates_[0][i], coordinates_[1][j], coordinates_[2][k]};
  }
  Box boxOf(const Block& b) const {
    return {position(b.first[0], b.first[1], b.first[2]),
            position(b.first[0] + b.count[0] - 1, b.first[1] + b.count[1] - 1, b.first[2] + b.count[2] - 1)};
  }
  template <class Visit>
  void forEach(const Block& b, Visit&& visit) const {
    for (int k = b.first[2]; k < b.first[2] + b.count[2]; ++k)
      for (int j = b.first[1]; j < b.first[1] + b.count[1]; ++j)
        for (int i = b.first[0]; i < b.first[0] + b.count[0]; ++i) visit(indexOf(i, j, k), position(i, j, k));
  }

  void search(const Block& block) {
    const Box box = boxOf(block);
    const Vec3 middle = box.center();
    const double radius = 0.5 * box.size().norm();
    const double most = rough_ ? 1.0 + slackBeyond : 1.0;
    ClosestPoint::Nearest atMiddle = surface_.nearest(middle, hint_, most - 1.0);
    hint_ = atMiddle.triangle;
    const double atLeast = atMiddle.distance / most;
    if (rough_ && farInside * radius <= atLeast && block.points() > 1 && sideOf(middle, hint_) < 0) {
      forEach(block, [&](std::size_t n, const Vec3& p) {
        distance_[n] = static_cast<float>(atLeast - (p - middle).norm());
        nearest_[n] = inside;
      });
      return;
    }
    if (block.points() == 1) {
      if (rough_) {
        if (isRough(atLeast))
          atMiddle.distance = atLeast;
        else
          atMiddle = surface_.nearest(middle, hint_);
      }
      forEach(block, [&](std::size_t n, const Vec3&) {
        distance_[n] = static_cast<float>(atMiddle.distance);
        nearest_[n] = atMiddle.triangle;
      });
      return;
    }
    // Distances from a triangle are largest at a corner of the box.
    double furthest = 0.0;
    for (int c = 0; c < 8; ++c)
      furthest = std::max(furthest, surface_.onTriangle(hint_, cornerOf(box, c)).distance);
    near_.clear();
    surface_.forEachNear(box, furthest + tolerance::culling, [&](int t) {
      near_.push_back(t);
      return static_cast<int>(near_.size()) <= mostNear;
    });
    int fromMiddle = static_cast<int>(near_.size());
    if (fewestOfNear * fromMiddle > mostNear && fromMiddle <= mostNear) {
      fromMiddle = 0;
      surface_.forEachNear(middle, atMiddle.distance + 2.0 * radius + tolerance::culling,
                           [&](int) { return ++fromMiddle <= mostNear; });
    }
    if (fromMiddle > mostNear) {
      forEachPart(block, [&](const Block& part) { search(part); });
      return;
    }
    setOrigin(middle, radius);
    compareParts(block);
  }

  static Vec3 cornerOf(const Box& box, int c) {
    return {(c & 1 ? box.hi : box.lo).x(), (c & 2 ? box.hi : box.lo).y(), (c & 4 ? box.hi : box.lo).z()};
  }

  template <class Visit>
  static void forEachPart(const Block& block, Visit&& visit) {
    for (int p = 0; p < 8; ++p) {
      const Block part = block.half(0, p & 1).half(1, p >> 1 & 1).half(2, p >> 2);
      if (part.points() > 0) visit(part);
    }
  }

  /// Sets the candidates' discs relative to the middle of the block of this radius.
  void setOrigin(const Vec3& middle, double radius) {
    const std::size_t count = near_.size(), padded = (count + lanes - 1) / lanes * lanes;
    constexpr float farAway = 1e15f;
    middle_ = middle;
    for (std::vector<float>* along : {&centers_[0], &centers_[1], &centers_[2]})
      along->assign(padded, farAway);
    radii_.assign(padded, 0.0f);
    scratch_.resize(padded);
    place_.assign(count, -1);
    facts_.clear();
    double extent = 0.0;
    for (std::size_t c = 0; c < count; ++c) {
      const TriangleDisc& disc = all_.discs_[near_[c]];
      double squared = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double from = disc.center[k] - middle[k];
        centers_[k][c] = static_cast<float>(from);
        squared += from * from;
      }
      radii_[c] = disc.radius;
      extent = std::max(extent, std::sqrt(squared) + double(disc.radius));
    }
    slack_ = static_cast<float>(searchSlack(extent + radius));
  }

  /// The facts of a candidate, relative to the middle of the block.
  const TriangleFacts& factsOf(int candidate) {
    int& place = place_[candidate];
    if (place >= 0) return facts_[place];
    place = static_cast<int>(facts_.size());
    const int t = near_[candidate];
    facts_.push_back(all_.facts_[t]);
    for (int c = 0; c < 3; ++c) {
      const Vec3 corner = surface_.corner(t, c) - middle_;
      for (int k = 0; k < 3; ++k) facts_.back().corner[c][k] = static_cast<float>(corner[k]);
    }
    return facts_.back();
  }

  void compareParts(const Block& block) {
    static const Cuts cuts;
    const Cuts::Cut& cut = cuts.of(block.count);
    if (cut.low == 0) return compare(block);
    for (const int k : {0, 1}) compareParts(block.part(cut.axis, cut.low, k));
  }

  /// Pre: at most `lanes` points
  void compare(const Block& block) {
    std::size_t index[lanes];
    PointLanes points;
    int used = 0;
    const auto setLane = [&](int lane, const Vec3& p) {
      const Vec3 from = p - middle_;
      points.x[lane] = static_cast<float>(from.x());
      points.y[lane] = static_cast<float>(from.y());
      points.z[lane] = static_cast<float>(from.z());
    };
    forEach(block, [&](std::size_t n, const Vec3& p) {
      setLane(used, p);
      index[used++] = n;
    });
    for (int lane = used; lane < lanes; ++lane)
      setLane(lane, position(block.first[0], block.first[1], block.first[2]));
    float squared[lanes], nearest[lanes];
    all_.kernels_.nearest(
        points,
        {centers_[0].data(), centers_[1].data(), centers_[2].data(), radii_.data(), near_.data(),
         all_.discs_.data(), static_cast<int>(near_.size())},
        slack_, scratch_.data(),
        [](void* search, int candidate) -> const TriangleFacts& {
          return static_cast<Search*>(search)->factsOf(candidate);
        },
        this, squared, nearest);
    for (int lane = 0; lane < used; ++lane) {
      distance_[index[lane]] = std::sqrt(squared[lane]);
      nearest_[index[lane]] = near_[static_cast<int>(nearest[lane])];
    }
  }

  /// The surface passes between neighbours on different sides: the sum of their distances from it is at most
  /// the distance between them.
  void giveSigns() {
    const int n[3] = {static_cast<int>(coordinates_[0].size()), static_cast<int>(coordinates_[1].size()),
                      static_cast<int>(coordinates_[2].size())};
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i) {
          const std::size_t here = indexOf(i, j, k);
          if (nearest_[here] == inside || isInside(here, i, j, k)) distance_[here] = -distance_[here];
        }
  }
  bool isInside(std::size_t here, int i, int j, int k) const {
    const int axis = i > 0 ? 0 : j > 0 ? 1 : 2, at = axis == 0 ? i : axis == 1 ? j : k;
    if (at > 0) {
      const std::size_t before = here - (axis == 0 ? 1 : axis == 1 ? coordinates_[0].size() : slab_);
      const double apart = coordinates_[axis][at] - coordinates_[axis][at - 1];
      if (std::abs(distance_[before]) + distance_[here] > apart + roundingOfFloats)
        return std::signbit(distance_[before]);
    }
    const Vec3 p = position(i, j, k);
    return (isRough(distance_[here]) ? sideOf(p, nearest_[here])
                                     : surface_.side(p, surface_.onTriangle(nearest_[here], p))) < 0;
  }
  bool isRough(double distance) const { return rough_ && exactWithin_ > 0.0 && distance > exactWithin_; }
  /// @param hint a triangle near p
  int sideOf(const Vec3& p, int hint) const { return surface_.side(p, surface_.nearest(p, hint)); }

  const SignedDistances& all_;
  const ClosestPoint& surface_;
  const std::array<std::vector<double>, 3>& coordinates_;
  bool rough_;
  double exactWithin_ = 0.0;  ///< [µm]
  float* distance_;           ///< initially unsigned
  std::size_t slab_;
  std::vector<int> nearest_;
  int hint_ = -1;
  std::vector<int> near_;                  ///< candidates: triangles that can be nearest in a block
  Vec3 middle_;                            ///< of that block, the origin of their coordinates
  std::vector<float> centers_[3], radii_;  ///< see NearDiscs
  float slack_ = 0.0f;                     ///< searchSlack()
  std::vector<float> scratch_;
  std::vector<int> place_;            ///< of each candidate in facts_; -1: none
  std::vector<TriangleFacts> facts_;  ///< of the candidates that were asked for
};

SignedDistances::SignedDistances(const TriangleMesh& mesh)
    : surface_(mesh), kernels_(triangleKernels(chosenInstructionSet())) {
  facts_.reserve(mesh.triangles.size());
  discs_.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    pollAt(t);
    facts_.push_back(factsOf(mesh, static_cast<int>(t)));
    discs_.push_back(discAround(mesh, static_cast<int>(t), facts_.back().normal));
  }
}

void SignedDistances::sample(const std::array<std::vector<double>, 3>& coordinates, bool rough,
                             float* distances) const {
  Search(*this, coordinates, rough, distances)();
}

}  // namespace packmesh
