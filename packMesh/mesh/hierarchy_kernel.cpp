// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/mesh_kernels.h"
#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

/// Of two patches, the one larger than the other by this factor is subdivided alone.
constexpr float muchLarger = 2.0f;

/// Added to the square of a sine, 1 - cosine², computed in floats.
constexpr float sineRounding = 2e-6f;

/// Shorter axes are skipped: the squares of projections on them would underflow [µm⁴].
constexpr float smallestAxis2 = 1e-30f;

/// Safety factor in comparisons of squares.
constexpr float squareGrowth = 1.0001f;

/// Each step down a tree leaves at most 15 entries on the stack, and trees of quads are not deeper than 34.
constexpr int stackSize = 1024;

constexpr unsigned allLanes = (1u << laneCount) - 1;

struct Vector {
  Lanes x, y, z;
};
inline Vector operator-(const Vector& a, const Vector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Lanes dot(const Vector& a, const Vector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline Four four(const float (&v)[4]) {
  return *reinterpret_cast<const UnalignedFour*>(v);
}
inline void set(float (&out)[4], Four v) {
  *reinterpret_cast<UnalignedFour*>(out) = v;
}

/// The disc around a quad or a triangle, in the first lane.
inline void discOf(const TreeView& tree, int content, FourDiscs& out) {
  const int disc = content < 0 ? tree.discs[~content] : tree.quads[content].disc;
  const FourDiscs& from = tree.quads[disc / 4].discs;
  const int lane = disc % 4;
  for (int k = 0; k < 3; ++k) {
    set(out.center[k], Four{from.center[k][lane], 0, 0, 0});
    set(out.normal[k], Four{from.normal[k][lane], 0, 0, 0});
  }
  set(out.radius, Four{from.radius[lane], -emptyDisc, -emptyDisc, -emptyDisc});
  set(out.half, Four{from.half[lane], -emptyDisc, -emptyDisc, -emptyDisc});
}

inline void see(const FourDiscs& discs, const SeenFrom& map, FourDiscs& out) {
  const Four x = four(discs.center[0]), y = four(discs.center[1]), z = four(discs.center[2]);
  const Four u = four(discs.normal[0]), v = four(discs.normal[1]), w = four(discs.normal[2]);
  for (int i = 0; i < 3; ++i) {
    set(out.center[i], map.point[i][0] * x + map.point[i][1] * y + map.point[i][2] * z + map.shift[i]);
    set(out.normal[i], map.direction[i][0] * u + map.direction[i][1] * v + map.direction[i][2] * w);
  }
  set(out.radius, map.stretch * four(discs.radius));
  set(out.half, map.slab * four(discs.half));
}

/// Quads of the second mesh in the frame of the first; the most recent ones are cached.
class SeenQuads {
 public:
  SeenQuads(const TreeView& tree, const SeenFrom& map) : tree_(tree), map_(map) {
    for (int& quad : remembered_) quad = -1;
  }
  const FourDiscs& operator()(int quad) {
    const int slot = quad & (slots - 1);
    if (remembered_[slot] != quad) {
      see(tree_.quads[quad].discs, map_, discs_[slot]);
      remembered_[slot] = quad;
    }
    return discs_[slot];
  }

 private:
  static constexpr int slots = 64;
  const TreeView& tree_;
  const SeenFrom& map_;
  int remembered_[slots];
  FourDiscs discs_[slots];
};

/// Determines which of four discs (lane / 4) and four others (lane % 4) could be nearer to each other than
/// `distance`, and lower bounds of their distances: the separation along either normal. No bounds are
/// computed if the bounding spheres are further apart.
inline unsigned couldBeNear(const FourDiscs& first, const FourDiscs& second, float skew, float distance,
                            Lanes& apart) {
  const Vector n{loadEachFourTimes(first.normal[0]), loadEachFourTimes(first.normal[1]),
                 loadEachFourTimes(first.normal[2])};
  const Vector m{loadAllFourTimes(second.normal[0]), loadAllFourTimes(second.normal[1]),
                 loadAllFourTimes(second.normal[2])};
  const Vector offset{loadAllFourTimes(second.center[0]) - loadEachFourTimes(first.center[0]),
                      loadAllFourTimes(second.center[1]) - loadEachFourTimes(first.center[1]),
                      loadAllFourTimes(second.center[2]) - loadEachFourTimes(first.center[2])};
  const Lanes firstRadius = loadEachFourTimes(first.radius), secondRadius = loadAllFourTimes(second.radius);
  const Lanes firstHalf = loadEachFourTimes(first.half), secondHalf = loadAllFourTimes(second.half);
  const Lanes cosine = magnitude(dot(n, m));
  const Lanes sine = squareRoot((1.0f + sineRounding) - cosine * cosine);
  const Lanes alongFirst =
      magnitude(dot(offset, n)) - firstHalf - skew * cosine * secondHalf - sine * secondRadius;
  const Lanes alongSecond = magnitude(dot(offset, m)) - secondHalf - cosine * firstHalf - sine * firstRadius;
  const Lanes touch = firstRadius + secondRadius + distance;
  apart = larger(alongFirst, alongSecond);
  return ~bitsOf((splat(distance) < apart) | (touch * touch < dot(offset, offset))) & allLanes;
}

/// Pairs of triangles to be tested together.
struct Batch {
  float first[9][laneCount], second[9][laneCount];
  int firstTriangle[laneCount], secondTriangle[laneCount];
  int size = 0;
  unsigned used() const { return (1u << size) - 1; }
};

inline Vector cornerOf(const float (&values)[9][laneCount], int k) {
  return {load(values[3 * k]), load(values[3 * k + 1]), load(values[3 * k + 2])};
}

inline Vector seen(const Vector& v, const SeenFrom& map) {
  return {map.point[0][0] * v.x + map.point[0][1] * v.y + map.point[0][2] * v.z + map.shift[0],
          map.point[1][0] * v.x + map.point[1][1] * v.y + map.point[1][2] * v.z + map.shift[1],
          map.point[2][0] * v.x + map.point[2][1] * v.y + map.point[2][2] * v.z + map.shift[2]};
}

struct Corners {
  Vector v[3];
};

/// Raises the lower bound of the squares of the distances, lane by lane, to what the axis `axis`, of any
/// length, separates.
inline void separate(const Vector& axis, const Corners& a, const Corners& b, Lanes& apart2) {
  const Lanes a0 = dot(axis, a.v[0]), a1 = dot(axis, a.v[1]), a2 = dot(axis, a.v[2]);
  const Lanes b0 = dot(axis, b.v[0]), b1 = dot(axis, b.v[1]), b2 = dot(axis, b.v[2]);
  const Lanes gap = larger(smaller(smaller(b0, b1), b2) - larger(larger(a0, a1), a2),
                           smaller(smaller(a0, a1), a2) - larger(larger(b0, b1), b2));
  const Lanes length2 = dot(axis, axis);
  const Mask valid = (splat(0.0f) < gap) & (splat(smallestAxis2) < length2);
  apart2 = larger(apart2, select(valid, gap * gap / length2, splat(0.0f)));
}

/// Lower bounds of the squares of the distances of two triangles, up to rounding errors, or one above
/// `enough2`. Separating axes are their normals and the products of their edges.
inline Lanes separation2(const Batch& batch, const SeenFrom& map, float enough2) {
  Corners a, b;
  for (int k = 0; k < 3; ++k) {
    a.v[k] = cornerOf(batch.first, k);
    b.v[k] = seen(cornerOf(batch.second, k), map);
  }
  const Vector e[3] = {a.v[1] - a.v[0], a.v[2] - a.v[1], a.v[0] - a.v[2]};
  const Vector f[3] = {b.v[1] - b.v[0], b.v[2] - b.v[1], b.v[0] - b.v[2]};
  Lanes apart2 = splat(0.0f);
  separate(cross(e[0], e[1]), a, b, apart2);
  separate(cross(f[0], f[1]), a, b, apart2);
  for (int i = 0; i < 3 && (~bitsOf(splat(enough2) < apart2) & batch.used()); ++i)
    for (int j = 0; j < 3; ++j) separate(cross(e[i], f[j]), a, b, apart2);
  return apart2;
}

class Search {
 public:
  Search(const TreeView& first, const TreeView& second, const SeenFrom& map, float rounding, float limit,
         ExaminePair examine, void* context)
      : first_(first),
        second_(second),
        map_(map),
        seen_(second, map),
        rounding_(rounding),
        limit_(limit),
        examine_(examine),
        context_(context) {}

  bool run() {
    Entry stack[stackSize];
    int size = 0;
    stack[size++] = {0, 0, 0.0f};
    while (size > 0) {
      const Entry entry = stack[--size];
      if (entry.apart > limit_) continue;
      bool openA = entry.first >= 0, openB = entry.second >= 0;
      if (openA && openB) {
        const float sizeA = first_.quads[entry.first].size,
                    sizeB = map_.stretch * second_.quads[entry.second].size;
        openA = muchLarger * sizeA > sizeB;
        openB = muchLarger * sizeB > sizeA;
      }
      FourDiscs singleA, singleB, seenSingleB;
      if (!openA) discOf(first_, entry.first, singleA);
      if (!openB) {
        discOf(second_, entry.second, singleB);
        see(singleB, map_, seenSingleB);
      }
      const FourDiscs& a = openA ? first_.quads[entry.first].discs : singleA;
      const FourDiscs& b = openB ? seen_(entry.second) : seenSingleB;
      const int* childrenA = openA ? first_.quads[entry.first].content : &entry.first;
      const int* childrenB = openB ? second_.quads[entry.second].content : &entry.second;
      Lanes apart;
      unsigned near = couldBeNear(a, b, map_.skew, limit_ + rounding_, apart);
      if (!near) continue;
      float bound[laneCount];
      store(apart - rounding_, bound);
      int nearest = size;
      for (; near; near &= near - 1) {
        const int lane = __builtin_ctz(near);
        const Entry child{childrenA[lane / 4], childrenB[lane % 4], bound[lane]};
        if ((child.first & child.second) < 0) {
          add(~child.first, ~child.second);
          if (batch_.size == laneCount && !examineBatch()) return false;
          continue;
        }
        stack[size] = child;
        if (child.apart < stack[nearest].apart) nearest = size;
        ++size;
      }
      // The nearest pair on top of the stack: it lowers the limit for the others.
      if (nearest < size) {
        const Entry top = stack[nearest];
        stack[nearest] = stack[size - 1];
        stack[size - 1] = top;
      }
    }
    return examineBatch();
  }

 private:
  struct Entry {
    int first, second;  ///< contents of discs (DiscQuad::content)
    float apart;        ///< lower bound of their distance
  };

  void add(int a, int b) {
    for (int c = 0; c < 3; ++c) {
      const float *p = first_.vertices[first_.triangles[a][c]],
                  *q = second_.vertices[second_.triangles[b][c]];
      for (int k = 0; k < 3; ++k) {
        batch_.first[3 * c + k][batch_.size] = p[k];
        batch_.second[3 * c + k][batch_.size] = q[k];
      }
    }
    batch_.firstTriangle[batch_.size] = a;
    batch_.secondTriangle[batch_.size] = b;
    ++batch_.size;
  }

  /// Nearer pairs first: they lower the limit for the others.
  bool examineBatch() {
    if (batch_.size == 0) return true;
    float apart2[laneCount];
    store(separation2(batch_, map_, squareOf(limit_ + rounding_)), apart2);
    const float disjoint2 = squareOf(rounding_);
    for (unsigned left = batch_.used();;) {
      int nearest = -1;
      for (unsigned rest = left; rest; rest &= rest - 1) {
        const int lane = __builtin_ctz(rest);
        if (nearest < 0 || apart2[lane] < apart2[nearest]) nearest = lane;
      }
      if (nearest < 0 || apart2[nearest] > squareOf(limit_ + rounding_)) break;
      left &= ~(1u << nearest);
      limit_ = examine_(context_, batch_.firstTriangle[nearest], batch_.secondTriangle[nearest],
                        !(apart2[nearest] > disjoint2));
      if (limit_ < 0.0f) return false;
    }
    batch_.size = 0;
    return true;
  }

  static float squareOf(float distance) { return squareGrowth * distance * distance; }

  const TreeView &first_, &second_;
  const SeenFrom& map_;
  SeenQuads seen_;
  const float rounding_;
  float limit_;
  ExaminePair examine_;
  void* context_;
  Batch batch_;
};

bool searchPairs(const TreeView& first, const TreeView& second, const SeenFrom& map, float rounding,
                 float limit, ExaminePair examine, void* context) {
  return Search(first, second, map, rounding, limit, examine, context).run();
}

}  // namespace

template <InstructionSet set>
PairSearch* pairSearch() {
  return searchPairs;
}
template PairSearch* pairSearch<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
