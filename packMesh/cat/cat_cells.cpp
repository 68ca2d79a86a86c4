// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "packMesh/mesh/mesh_repair.h"

namespace packmesh {
namespace {

/// Which corners have equal labels: one bit for each pair of corners.
int equalities(int a, int b, int c, int d) {
  return (a == b) | (a == c) << 1 | (a == d) << 2 | (b == c) << 3 | (b == d) << 4 | (c == d) << 5;
}

ChordalPattern patternOf(const std::array<int, 4>& label) {
  // Corners sorted by the frequency of their label, those with the same label together.
  ChordalPattern pattern;
  std::array<int, 4> count{}, firstWith{};
  for (int k = 0; k < 4; ++k)
    for (int j = 3; j >= 0; --j)
      if (label[j] == label[k]) {
        ++count[k];
        firstWith[k] = j;
      }
  int placed = 0;
  for (int wanted = 4; wanted >= 1; --wanted)
    for (int first = 0; first < 4; ++first)
      for (int k = first; k < 4; ++k)
        if (count[k] == wanted && firstWith[k] == first)
          pattern.order[placed++] = static_cast<std::uint8_t>(k);
  const int largest = count[pattern.order[0]];
  pattern.kind = largest == 4                   ? ChordalCase::none
                 : largest == 3                 ? ChordalCase::threeOne
                 : largest == 1                 ? ChordalCase::allDifferent
                 : count[pattern.order[2]] == 2 ? ChordalCase::twoTwo
                                                : ChordalCase::twoOneOne;
  return pattern;
}

/// Indexed by equalities(); combinations that cannot occur stay empty.
using PatternTable = std::array<ChordalPattern, 64>;

PatternTable makeTable() {
  PatternTable table;
  std::array<int, 4> label;
  for (int code = 0; code < 256; ++code) {
    for (int k = 0; k < 4; ++k) label[k] = code >> 2 * k & 3;
    table[equalities(label[0], label[1], label[2], label[3])] = patternOf(label);
  }
  return table;
}

const PatternTable patterns = makeTable();

/// Splits one tetrahedron after the other.
class Splitter {
 public:
  /// @param out of sufficient size
  Splitter(const Tetrahedra& tetrahedra, WallFaces wall, ChordalFaces& out)
      : points_(tetrahedra.points.data()),
        labels_(tetrahedra.labels.data()),
        atWall_(wall == WallFaces::atWall),
        face_(out.faces.data()) {}

  void split(int index, const Tetrahedron& t, const ChordalPattern& pattern) {
    tetrahedron_ = index;
    order_ = pattern.order.data();
    for (int k = 0; k < 4; ++k) corner_[k] = t[order_[k]];
    withCase(pattern.kind, [this](auto kind) {
      addAll<kind.value>(std::make_index_sequence<chordalCuts<kind.value>.size()>());
    });
  }

 private:
  const Vec3& at(int k) const { return points_[corner_[k]]; }

  template <int mask>
  std::uint8_t bits() const {
    int bits = 0;
    for (int k = 0; k < 4; ++k)
      if (mask >> k & 1) bits |= 1 << order_[k];
    return static_cast<std::uint8_t>(bits);
  }

  template <ChordalCase kind, std::size_t... cuts>
  void addAll(std::index_sequence<cuts...>) {
    (add<kind, cuts>(), ...);
  }

  /// A face, or two in a plane; it cuts the edges between the corners on both sides in half.
  template <ChordalCase kind, std::size_t number>
  void add() {
    constexpr ChordalCut cut = chordalCuts<kind>[number];
    constexpr int i = lowestCorner(cut.first), j = lowestCorner(cut.second);
    const Vec3 normal = cut.normal(at(0), at(1), at(2), at(3)), edge = at(j) - at(i);
    const double length = normal.norm(), along = normal.dot(edge);
    face_->normal = normal / (along < 0.0 ? -length : length);
    if (!(length > 0.0)) face_->normal = edge.normalized();  // flat up to rounding
    const bool toWall = atWall_ && labels_[corner_[j]] == wallLabel;
    const bool fromWall = atWall_ && labels_[corner_[i]] == wallLabel;
    face_->away = length > 0.0 && !toWall && !fromWall ? 0.5 * std::abs(along) / length : 0.0;
    face_->point = toWall ? at(j) : fromWall ? at(i) : Vec3(0.5 * (at(i) + at(j)));
    finish<cut.first, cut.second>();
    if constexpr (cut.twice) {
      face_->normal = face_[-1].normal;
      face_->away = face_[-1].away;
      face_->point = face_[-1].point;
      finish<cut.first, cut.second>();
    }
  }

  template <int first, int second>
  void finish() {
    face_->tetrahedron = tetrahedron_;
    face_->first = bits<first>();
    face_->second = bits<second>();
    ++face_;
  }

  const Vec3* points_;
  const int* labels_;
  bool atWall_;
  ChordalFace* face_;
  int tetrahedron_ = 0;
  int corner_[4];
  const std::uint8_t* order_ = nullptr;
};

}  // namespace

const ChordalPattern& chordalPattern(int a, int b, int c, int d) {
  return patterns[equalities(a, b, c, d)];
}

void splitChordally(const Tetrahedra& tetrahedra, WallFaces wall, ChordalFaces& out) {
  const std::vector<int>& labels = tetrahedra.labels;
  const auto patternAt = [&](const Tetrahedron& t) -> const ChordalPattern& {
    return patterns[equalities(labels[t[0]], labels[t[1]], labels[t[2]], labels[t[3]])];
  };
  // Count first, so that memory is allocated once.
  out.tetrahedra.fill(0);
  for (const Tetrahedron& t : tetrahedra.tetrahedra) {
    const ChordalCase kind = patternAt(t).kind;
    if (kind != ChordalCase::none) ++out.tetrahedra[static_cast<int>(kind)];
  }
  std::int64_t count = 0;
  for (int kind = 0; kind < 5; ++kind) count += out.tetrahedra[kind] * chordalFaceCount[kind];
  out.faces.resize(count);

  Splitter splitter(tetrahedra, wall, out);
  for (std::size_t i = 0; i < tetrahedra.tetrahedra.size(); ++i) {
    const Tetrahedron& t = tetrahedra.tetrahedra[i];
    const ChordalPattern& pattern = patternAt(t);
    if (pattern.kind != ChordalCase::none) splitter.split(static_cast<int>(i), t, pattern);
  }
}

namespace {

/// A vertex of a cell: the mean of up to four points, given by their indices in ascending order, -1 for none.
using Middle = std::array<int, 4>;

/// A triangle of the cell of one label.
struct Facet {
  int label;
  std::array<Middle, 3> corners;
};

/// Tetrahedra with three or four corners on the container.
struct WallTetrahedron {
  int index;
  int owner;  ///< label of the fourth corner, or of the cell it was assigned to
};

/// A face with all corners on the container.
struct WallFace {
  std::array<int, 3> points;  ///< ascending
  int tetrahedron;            ///< index among the WallTetrahedra
  int opposite;               ///< its corner that is not in the face
};

bool sameFace(const WallFace& a, const WallFace& b) {
  return a.points == b.points;
}

class CellBuilder {
 public:
  CellBuilder(const Tetrahedra& tetrahedra, WallFaces wall)
      : t_(tetrahedra),
        atWall_(wall == WallFaces::atWall),
        layer_(!atWall_ &&
               std::all_of(t_.bodies.begin(), t_.bodies.end(), [](auto& body) { return body.primary; })) {
    for (std::size_t i = 0; i < t_.tetrahedra.size(); ++i) split(static_cast<int>(i));
    findWallFaces();
    if (atWall_) giveAway();
    addWallFaces();
  }

  CatCells cells() {
    std::stable_sort(facets_.begin(), facets_.end(),
                     [](const Facet& a, const Facet& b) { return a.label < b.label; });
    int objects = 0;
    for (const TetrahedraBody& body : t_.bodies) objects = std::max(objects, body.object + 1);
    CatCells result;
    result.cells.resize(objects);
    for (std::size_t from = 0, to = 0; from < facets_.size(); from = to) {
      const int label = facets_[from].label;
      for (to = from; to < facets_.size() && facets_[to].label == label;) ++to;
      const Vec3 shift = label == wallLabel ? Vec3(Vec3::Zero()) : t_.bodies[label].shift;
      (label == wallLabel ? result.wallLayer : result.cells[t_.bodies[label].object]) =
          meshOf(from, to, shift);
    }
    return result;
  }

 private:
  int label(int point) const { return t_.labels[point]; }
  bool isWall(int point) const { return label(point) == wallLabel; }

  /// Of some corners of a tetrahedron, ascending.
  Middle middle(const std::array<int, 4>& points, int corners) const {
    Middle m{-1, -1, -1, -1};
    int count = 0, onWall = -1;
    for (int k = 0; k < 4; ++k) {
      if (!(corners >> k & 1)) continue;
      int at = count++;
      for (; at > 0 && m[at - 1] > points[k]; --at) m[at] = m[at - 1];
      m[at] = points[k];
      if (onWall < 0 && isWall(points[k])) onWall = points[k];
    }
    // Split points are moved to the container's corner; two of them are never requested.
    return atWall_ && onWall >= 0 ? Middle{onWall, -1, -1, -1} : m;
  }

  /// Triangles of a face, a convex polygon that is counter-clockwise as seen from the second side.
  void add(int first, int second, const std::vector<Middle>& polygon) {
    if (atWall_ && (first == wallLabel || second == wallLabel)) return;
    for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
      const Middle &a = polygon[0], &b = polygon[k], &c = polygon[k + 1];
      if (a == b || b == c || c == a) continue;  // merged at the wall
      addFacet(first, {a, b, c});
      addFacet(second, {a, c, b});
    }
  }
  void addFacet(int label, const std::array<Middle, 3>& corners) {
    if (label == wallLabel ? layer_ : t_.isPrimary(label)) facets_.push_back({label, corners});
  }

  void split(int index) {
    const Tetrahedron& t = t_.tetrahedra[index];
    const ChordalPattern& pattern = chordalPattern(label(t[0]), label(t[1]), label(t[2]), label(t[3]));
    std::array<int, 4> p;
    int inversions = 0;
    for (int k = 0; k < 4; ++k) {
      p[k] = t[pattern.order[k]];
      for (int j = 0; j < k; ++j) inversions += pattern.order[j] > pattern.order[k];
    }
    // Make the volume of a, b, c, d positive: exchange two corners with the same label or, if all differ, any
    // two.
    if (inversions % 2 == 1) {
      if (pattern.kind == ChordalCase::allDifferent)
        std::swap(p[2], p[3]);
      else
        std::swap(p[0], p[1]);
    }
    withCase(pattern.kind, [&](auto kind) {
      for (const ChordalCut& cut : chordalCuts<kind.value>) {
        std::vector<Middle> polygon;
        for (const int corners : cut.polygon)
          if (corners != 0) polygon.push_back(middle(p, corners));
        add(label(p[lowestCorner(cut.first)]), label(p[lowestCorner(cut.second)]), polygon);
      }
    });
  }

  void findWallFaces() {
    for (std::size_t i = 0; i < t_.tetrahedra.size(); ++i) {
      const Tetrahedron& t = t_.tetrahedra[i];
      const auto wallCorners = std::count_if(t.begin(), t.end(), [&](int p) { return isWall(p); });
      if (wallCorners < 3) continue;
      const int number = static_cast<int>(wallTetrahedra_.size());
      wallTetrahedra_.push_back({static_cast<int>(i), wallLabel});
      for (int k = 0; k < 4; ++k) {
        if (!isWall(t[k])) wallTetrahedra_.back().owner = label(t[k]);
        if (wallCorners == 3 && isWall(t[k])) continue;
        std::array<int, 3> points{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]};
        std::sort(points.begin(), points.end());
        wallFaces_.push_back({points, number, k});
      }
    }
    std::sort(wallFaces_.begin(), wallFaces_.end(), [](const WallFace& a, const WallFace& b) {
      return a.points != b.points ? a.points < b.points : a.tetrahedron < b.tetrahedron;
    });
  }

  /// The other tetrahedron at a face; -1: none.
  int beyond(std::size_t face) const {
    if (face > 0 && sameFace(wallFaces_[face - 1], wallFaces_[face])) return wallFaces_[face - 1].tetrahedron;
    if (face + 1 < wallFaces_.size() && sameFace(wallFaces_[face + 1], wallFaces_[face]))
      return wallFaces_[face + 1].tetrahedron;
    return -1;
  }

  /// Tetrahedra with all corners on the container are assigned to neighbouring cells, layer by layer inwards.
  void giveAway() {
    struct Offer {
      double area = 0.0;
      int owner = wallLabel;
    };
    for (bool changed = true; changed;) {
      changed = false;
      std::vector<Offer> best(wallTetrahedra_.size());
      for (std::size_t f = 0; f < wallFaces_.size(); ++f) {
        const int here = wallFaces_[f].tetrahedron, there = beyond(f);
        if (there < 0 || wallTetrahedra_[here].owner != wallLabel ||
            wallTetrahedra_[there].owner == wallLabel)
          continue;
        const auto& [p, q, r] = wallFaces_[f].points;
        const double area = (t_.points[q] - t_.points[p]).cross(t_.points[r] - t_.points[p]).norm();
        if (area > best[here].area) best[here] = {area, wallTetrahedra_[there].owner};
      }
      for (std::size_t i = 0; i < best.size(); ++i)
        if (best[i].owner != wallLabel) {
          wallTetrahedra_[i].owner = best[i].owner;
          changed = true;
        }
    }
  }

  /// Faces on the container belong to the surface of a cell at the wall if something else is beyond them, and
  /// to that of the wall layer where it ends.
  void addWallFaces() {
    for (std::size_t f = 0; f < wallFaces_.size(); ++f) {
      const WallTetrahedron& here = wallTetrahedra_[wallFaces_[f].tetrahedron];
      const int there = beyond(f);
      const int owner = atWall_ ? here.owner : wallLabel;
      const int other = there < 0 ? outside : atWall_ ? wallTetrahedra_[there].owner : wallLabel;
      if (owner == other || (atWall_ && owner == wallLabel)) continue;
      // Seen from corner k of a tetrahedron of positive volume, the other corners in this order are
      // counter-clockwise from outside.
      static constexpr int facing[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
      const Tetrahedron& t = t_.tetrahedra[here.index];
      std::array<Middle, 3> corners;
      for (int k = 0; k < 3; ++k) corners[k] = {t[facing[wallFaces_[f].opposite][k]], -1, -1, -1};
      addFacet(owner, corners);
    }
  }

  TriangleMesh meshOf(std::size_t from, std::size_t to, const Vec3& shift) const {
    std::vector<Middle> middles;
    for (std::size_t f = from; f < to; ++f)
      middles.insert(middles.end(), facets_[f].corners.begin(), facets_[f].corners.end());
    std::sort(middles.begin(), middles.end());
    middles.erase(std::unique(middles.begin(), middles.end()), middles.end());
    TriangleMesh mesh;
    for (const Middle& m : middles) {
      Vec3 sum = Vec3::Zero();
      int count = 0;
      for (const int p : m)
        if (p >= 0) {
          sum += t_.points[p];
          ++count;
        }
      mesh.vertices.push_back(sum / count - shift);
    }
    for (std::size_t f = from; f < to; ++f) {
      Triangle triangle;
      for (int k = 0; k < 3; ++k)
        triangle[k] = static_cast<int>(
            std::lower_bound(middles.begin(), middles.end(), facets_[f].corners[k]) - middles.begin());
      mesh.triangles.push_back(triangle);
    }
    return atWall_ ? separateTouchingParts(mesh) : mesh;
  }

  static constexpr int outside = -2;

  const Tetrahedra& t_;
  bool atWall_;
  bool layer_;  ///< whether the wall layer is requested
  std::vector<Facet> facets_;
  std::vector<WallTetrahedron> wallTetrahedra_;
  std::vector<WallFace> wallFaces_;
};

}  // namespace

CatCells catCells(const Tetrahedra& tetrahedra, WallFaces wall) {
  return CellBuilder(tetrahedra, wall).cells();
}

}  // namespace packmesh
