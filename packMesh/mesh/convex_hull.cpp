// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "packMesh/core/poll.h"
#include "packMesh/mesh/predicates.h"

namespace packmesh {

namespace {

/// Quickhull (C. Barber, D. Dobkin, H. Huhdanpaa, ACM Trans. Math. Software 22 (1996)) with exact predicates:
/// a face is visible from points strictly above it, so coplanar and duplicate points need no special
/// treatment.
class Quickhull {
 public:
  explicit Quickhull(const std::vector<Vec3>& points) : points_(points), faceFrom_(points.size(), -1) {}

  /// Pairs of vertices joined by an edge, in both directions; empty if the points are coplanar.
  std::vector<std::array<int, 2>> edges() {
    if (!startTetrahedron()) return {};
    for (std::size_t f = 0; f < faces_.size(); ++f)  // faces are appended during the loop
      while (faces_[f].alive && !faces_[f].above.empty()) {
        poll();
        addPoint(static_cast<int>(f));
      }
    std::vector<std::array<int, 2>> edges;
    for (const Face& f : faces_)
      if (f.alive)
        for (int k = 0; k < 3; ++k) edges.push_back({f.vertex[k], f.vertex[(k + 1) % 3]});
    return edges;
  }

 private:
  struct Face {
    std::array<int, 3> vertex;              ///< counter-clockwise from outside
    std::array<int, 3> across{-1, -1, -1};  ///< face across the edge from vertex k to k + 1
    std::vector<int> above;                 ///< points that see this face; each is stored at one face only
    bool alive = true;
  };

  int side(const Face& f, int p) const {
    return sideOfPlane(points_[f.vertex[0]], points_[f.vertex[1]], points_[f.vertex[2]], points_[p]);
  }

  bool startTetrahedron() {
    const int n = static_cast<int>(points_.size());
    // Distant points first, so that most others are discarded early; any affinely independent points are
    // valid.
    const auto furthest = [&](auto&& measure) {
      int best = 0;
      double most = -1.0;
      for (int i = 0; i < n; ++i)
        if (const double m = measure(i); m > most) most = m, best = i;
      return best;
    };
    const auto firstOf = [&](int guess, auto&& holds) {
      if (holds(guess)) return guess;
      for (int i = 0; i < n; ++i)
        if (holds(i)) return i;
      return -1;
    };
    const Vec3& a = points_[0];
    const int second = furthest([&](int i) { return (points_[i] - a).squaredNorm(); });
    const Vec3& b = points_[second];
    const int third = firstOf(furthest([&](int i) { return (b - a).cross(points_[i] - a).squaredNorm(); }),
                              [&](int i) { return axisShowing(a, b, points_[i]) >= 0; });
    if (third < 0) return false;
    const Vec3& c = points_[third];
    const int fourth =
        firstOf(furthest([&](int i) { return std::abs((b - a).cross(c - a).dot(points_[i] - a)); }),
                [&](int i) { return sideOfPlane(a, b, c, points_[i]) != 0; });
    if (fourth < 0) return false;
    int v[4] = {0, second, third, fourth};
    if (sideOfPlane(a, b, c, points_[fourth]) > 0)
      std::swap(v[1], v[2]);  // the fourth lies below the first face
    faces_ = {{{v[0], v[1], v[2]}, {3, 1, 2}, {}, true},
              {{v[1], v[3], v[2]}, {3, 2, 0}, {}, true},
              {{v[2], v[3], v[0]}, {1, 3, 0}, {}, true},
              {{v[0], v[3], v[1]}, {2, 1, 0}, {}, true}};
    std::vector<int> all(n);
    std::iota(all.begin(), all.end(), 0);
    share(all, 0);
    return true;
  }

  /// Assigns each point to the first face from `begin` on that it sees; the others are inside the hull.
  void share(const std::vector<int>& points, std::size_t begin) {
    for (int p : points)
      for (std::size_t f = begin; f < faces_.size(); ++f)
        if (side(faces_[f], p) > 0) {
          faces_[f].above.push_back(p);
          break;
        }
  }

  /// Replaces all faces visible from the highest point above face `f` by a cone of new faces.
  void addPoint(int f) {
    const Face& start = faces_[f];
    const Vec3& a = points_[start.vertex[0]];
    const Vec3 normal = (points_[start.vertex[1]] - a).cross(points_[start.vertex[2]] - a);
    const int p = *std::max_element(start.above.begin(), start.above.end(), [&](int i, int j) {
      return normal.dot(points_[i] - a) < normal.dot(points_[j] - a);
    });

    std::vector<int> visible{f}, orphans;
    std::vector<std::array<int, 2>> horizon;  // visible face, edge
    faces_[f].alive = false;
    for (std::size_t i = 0; i < visible.size(); ++i) {
      for (int across : faces_[visible[i]].across)
        if (faces_[across].alive && side(faces_[across], p) > 0) {
          faces_[across].alive = false;
          visible.push_back(across);
        }
      std::vector<int>& above = faces_[visible[i]].above;
      orphans.insert(orphans.end(), above.begin(), above.end());
      std::vector<int>().swap(above);
    }
    for (int v : visible)
      for (int k = 0; k < 3; ++k)
        if (faces_[faces_[v].across[k]].alive) horizon.push_back({v, k});

    const std::size_t begin = faces_.size();
    for (const auto& [v, k] : horizon) {
      const int from = faces_[v].vertex[k], to = faces_[v].vertex[(k + 1) % 3], beyond = faces_[v].across[k];
      const int created = static_cast<int>(faces_.size());
      faces_.push_back({{from, to, p}, {beyond, -1, -1}, {}, true});
      Face& other = faces_[beyond];
      for (int l = 0; l < 3; ++l)
        if (other.vertex[l] == to && other.vertex[(l + 1) % 3] == from) other.across[l] = created;
      faceFrom_[from] = created;
    }
    for (std::size_t i = begin; i < faces_.size(); ++i) {
      const int next = faceFrom_[faces_[i].vertex[1]];
      faces_[i].across[1] = next;
      faces_[next].across[2] = static_cast<int>(i);
    }
    share(orphans, begin);
  }

  const std::vector<Vec3>& points_;
  std::vector<Face> faces_;
  std::vector<int> faceFrom_;  ///< per vertex: newest face of the cone whose horizon edge starts there
};

}  // namespace

ConvexHull::ConvexHull(const TriangleMesh& mesh) {
  std::vector<Vec3> used;
  std::vector<bool> seen(mesh.vertices.size(), false);
  for (const Triangle& t : mesh.triangles)
    for (int v : t)
      if (!seen[v]) {
        seen[v] = true;
        used.push_back(mesh.vertices[v]);
      }

  std::vector<std::array<int, 2>> edges = Quickhull(used).edges();
  if (edges.empty())  // flat: not a cell mesh, but handled correctly
    for (int i = 0; i < static_cast<int>(used.size()); ++i)
      for (int j = 0; j < static_cast<int>(used.size()); ++j) edges.push_back({i, j});

  std::vector<int> index(used.size(), -1);
  for (const auto& edge : edges)
    if (index[edge[0]] < 0) {
      index[edge[0]] = static_cast<int>(points_.size());
      points_.push_back(used[edge[0]]);
    }
  for (auto& edge : edges) edge = {index[edge[0]], index[edge[1]]};
  std::sort(edges.begin(), edges.end());
  firstNeighbor_.assign(points_.size() + 1, 0);
  for (const auto& edge : edges) {
    ++firstNeighbor_[edge[0] + 1];
    neighbors_.push_back(edge[1]);
  }
  std::partial_sum(firstNeighbor_.begin(), firstNeighbor_.end(), firstNeighbor_.begin());

  starts_.fill(0);
  for (int axis = 0; axis < 3; ++axis)
    for (double sign : {1.0, -1.0})
      for (int u = 0; u < cells; ++u)
        for (int v = 0; v < cells; ++v) {
          Vec3 direction;
          direction[axis] = sign;
          direction[(axis + 1) % 3] = (2 * u + 1.0) / cells - 1.0;
          direction[(axis + 2) % 3] = (2 * v + 1.0) / cells - 1.0;
          const int found = furthest(direction);
          starts_[startCell(direction)] = found;
        }
}

namespace {

/// Maximum number of rounds. Nested pairs need a few until the origin is enclosed; more are not worth their
/// time.
constexpr int maxRounds = 20;

/// A simplex of the Minkowski difference; the last point is the newest.
struct Simplex {
  Vec3 point[4];
  int size = 0;

  /// Adds a point that lies further on the origin's side than all others, keeps only the face nearest to the
  /// origin and returns its nearest point. That face contains the new point.
  Vec3 add(const Vec3& p) {
    const Vec3 old[3] = {point[0], point[1], point[2]};
    const int count = size;
    Vec3 nearest = p;
    double least = p.squaredNorm();
    point[0] = p, size = 1;
    for (int i = 0; i < count; ++i) {
      const Vec3 edge = old[i] - p;
      const double along = -p.dot(edge), squared = edge.squaredNorm();
      if (along <= 0.0 || along >= squared) continue;
      keep(p + along / squared * edge, p, {old[i], old[i]}, 2, nearest, least);
    }
    for (int i = 0; i < count; ++i)
      for (int j = i + 1; j < count; ++j) {
        const Vec3 e = old[i] - p, f = old[j] - p;
        const double ee = e.squaredNorm(), ef = e.dot(f), ff = f.squaredNorm(), pe = -p.dot(e),
                     pf = -p.dot(f);
        const double determinant = ee * ff - ef * ef;
        const double s = pe * ff - pf * ef, t = pf * ee - pe * ef;
        if (s <= 0.0 || t <= 0.0 || s + t >= determinant) continue;
        keep(p + (s * e + t * f) / determinant, p, {old[i], old[j]}, 3, nearest, least);
      }
    if (count == 3 && encloses(p, old)) return Vec3::Zero();
    return nearest;
  }

 private:
  struct Others {
    Vec3 a, b;
  };
  void keep(const Vec3& candidate, const Vec3& p, const Others& others, int count, Vec3& nearest,
            double& least) {
    const double squared = candidate.squaredNorm();
    if (squared >= least) return;
    least = squared;
    nearest = candidate;
    point[0] = others.a;
    if (count == 3) point[1] = others.b;
    point[count - 1] = p;
    size = count;
  }

  /// True if the origin is on the inner side of the three faces at p.
  static bool encloses(const Vec3& p, const Vec3 (&old)[3]) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 normal = (old[k] - p).cross(old[(k + 1) % 3] - p);
      if (normal.dot(p) * normal.dot(old[(k + 2) % 3] - p) > 0.0) return false;
    }
    return true;
  }
};

}  // namespace

bool hullsApart(const ConvexHull& first, const ConvexHull& second, const Mat3& linear,
                const Vec3& translation, const Vec3& direction, double distance, double rounding) {
  const Mat3 transposed = linear.transpose();
  Vec3 toOrigin = direction;
  Simplex simplex;
  for (int round = 0; round < maxRounds; ++round) {
    const int a = first.furthest(-toOrigin), b = second.furthest(transposed * toOrigin);
    const Vec3 point = first.points()[a] - (linear * second.points()[b] + translation);
    const double length = toOrigin.norm(), gap = toOrigin.dot(point) / length;
    if (gap > distance + rounding) return true;
    // No progress: the distance of the simplex is that of the hulls, and too small.
    if (round > 0 && gap > length - rounding) return false;
    toOrigin = simplex.add(point);
    if (toOrigin.norm() <= distance + rounding) return false;
  }
  return false;
}

}  // namespace packmesh
