// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_kernels.h"

#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

constexpr float tiny = 1e-20f;  // [µm⁴] far below rounding: keeps what collapses from dividing by 0
constexpr float leastParallel = 1e-12f;  // [µm⁴] of parallel edges: below rounding, any point will do
constexpr float leastGap = 4e-6f;        // [µm] rounding of positions and distances
constexpr float rounding = 1e-4f;        // [µm] of the sums of steps: more than enough

static_assert(sizeof(VertexFours) == 4 * laneCount * sizeof(std::int16_t));

struct Point {
  Lanes x, y, z;
};
inline Point operator+(const Point& a, const Point& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Point operator-(const Point& a, const Point& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Point operator*(const Lanes& s, const Point& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline Lanes dot(const Point& a, const Point& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Lanes clamped(const Lanes& v) {
  return smaller(larger(v, splat(0.0f)), splat(1.0f));
}

inline Ints indices(const std::int16_t* of) {
  typedef std::int16_t Shorts __attribute__((vector_size(registerLanes * 2), may_alias, aligned(2)));
  return eachMask([&](int k) {
    return __builtin_convertvector(*reinterpret_cast<const Shorts*>(of + k * registerLanes), MaskRegister);
  });
}

inline Point vertices(const float* cell, const std::int16_t* of) {
  const Ints at = indices(of) << 2;
  const auto component = [&](int k) {
    const Ints bits = gather(cell + k, at);
    return each([&](int r) { return reinterpret_cast<Register>(bits.r[r]); });
  };
  return {component(0), component(1), component(2)};
}

/// From the second to the first: the shortest vector between them, and where it ends on both.
struct Nearest {
  Point apart;
  Lanes squared;        ///< its length
  Lanes first;          ///< edge: share of its second end
  Lanes second, third;  ///< weights of the second cell's second and third vertex
};

struct Closest {
  Lanes squared, second, third;
};
inline void keepNearer(Closest& best, const Lanes& squared, const Lanes& second, const Lanes& third) {
  const Mask nearer = squared < best.squared;
  best = {smaller(squared, best.squared), select(nearer, second, best.second),
          select(nearer, third, best.third)};
}

/// The point of a segment from the origin along `d` that is nearest to p; its squared distance.
inline Lanes onSegment(const Point& p, const Point& d, const Lanes& inverse, Lanes& share) {
  share = clamped(dot(p, d) * inverse);
  const Point off = p - share * d;
  return dot(off, off);
}

inline Lanes inverseOf(const Lanes& v) {
  return splat(1.0f) / larger(v, splat(tiny));
}

/// A triangle a, a + u, a + v, and one divided by squared lengths of its sides and of its doubled area.
struct Plane {
  Point a, u, v;
  Lanes inverseU, inverseV, inverseW, inverseArea;
};
inline Plane planeOf(const Point& a, const Point& b, const Point& c) {
  Plane p{a, b - a, c - a, {}, {}, {}, {}};
  const Point w = c - b;
  const Lanes uu = dot(p.u, p.u), vv = dot(p.v, p.v), uv = dot(p.u, p.v);
  p.inverseU = inverseOf(uu), p.inverseV = inverseOf(vv), p.inverseW = inverseOf(dot(w, w));
  p.inverseArea = inverseOf(uu * vv - uv * uv);
  return p;
}

inline Nearest vertexTriangle(const Point& p, const Plane& plane) {
  const Lanes zero = splat(0.0f), one = splat(1.0f);
  const Point &u = plane.u, &v = plane.v, w = p - plane.a;
  const Lanes uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v);
  const Lanes s = (vv * wu - uv * wv) * plane.inverseArea, t = (uu * wv - uv * wu) * plane.inverseArea;
  Lanes share;
  Closest best;
  best.squared = onSegment(w, u, plane.inverseU, share);
  best.second = share, best.third = zero;
  Lanes squared = onSegment(w, v, plane.inverseV, share);
  keepNearer(best, squared, zero, share);
  squared = onSegment(w - u, v - u, plane.inverseW, share);
  keepNearer(best, squared, one - share, share);
  const Mask outside = (s < zero) | (t < zero) | (one < s + t);
  const Lanes second = select(outside, best.second, s), third = select(outside, best.third, t);
  const Point apart = w - (second * u + third * v);
  return {apart, dot(apart, apart), zero, second, third};
}

inline Nearest edgeEdge(const Point& a, const Point& u, const Lanes& inverseU, const Point& c, const Point& v,
                        const Lanes& inverseV) {
  const Point r = a - c;
  const Lanes uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), ur = dot(u, r), vr = dot(v, r);
  Lanes s = clamped((uv * vr - ur * vv) / larger(uu * vv - uv * uv, splat(leastParallel)));
  const Lanes t = clamped((uv * s + vr) * inverseV);
  s = clamped((uv * t - ur) * inverseU);
  const Point apart = r + s * u - t * v;
  return {apart, dot(apart, apart), s, t, splat(0.0f)};
}

inline Nearest nearest(ContactKind kind, const CellPair& pair, const VertexFours& block) {
  const Point offset{splat(pair.offset[0]), splat(pair.offset[1]), splat(pair.offset[2])};
  const Point first = vertices(pair.first, block[0]);
  const Point c = vertices(pair.second, block[2]) + offset, d = vertices(pair.second, block[3]) + offset;
  if (kind == ContactKind::vertexTriangle)
    return vertexTriangle(first, planeOf(vertices(pair.second, block[1]) + offset, c, d));
  const Point u = vertices(pair.first, block[1]) - first, v = d - c;
  return edgeEdge(first, u, inverseOf(dot(u, u)), c, v, inverseOf(dot(v, v)));
}

inline unsigned presentLanes(int size, int begin) {
  return size - begin >= laneCount ? 0xffffu : (1u << (size - begin)) - 1u;
}

inline float leastDistance(const Lanes& squared, unsigned present) {
  float distances[laneCount];
  store(squareRoot(squared), distances);
  float least = distances[0];  // lanes that are not present come last
  for (int lane = 1; lane < laneCount; ++lane)
    least = (present >> lane & 1u) != 0 && distances[lane] < least ? distances[lane] : least;
  return least;
}

inline void push(float* to, float share, const float force[3], float stiffness) {
  for (int k = 0; k < 3; ++k) to[k] += share * force[k];
  to[3] += share * stiffness;
}

int contactForces(ContactKind kind, const CellPair& pair, const VertexFours* blocks, int size,
                  const Barrier& barrier, const Approach& approach, float* forces, float* gaps,
                  Reaction* reactions) {
  const Lanes one = splat(1.0f), range = splat(barrier.range);
  const Lanes reach = splat(barrier.clearance + barrier.range);
  const float near = approach.moved + barrier.clearance + barrier.range + rounding;
  int found = 0;
  for (int begin = 0; begin < size; begin += laneCount) {
    float& until = approach.until[begin / laneCount];
    if (until > near) continue;
    const VertexFours& block = blocks[begin / laneCount];
    const Nearest at = nearest(kind, pair, block);
    unsigned bits = bitsWhereLess(at.squared, reach * reach) & presentLanes(size, begin);
    if (bits == 0) until = approach.moved + leastDistance(at.squared, presentLanes(size, begin));
    if (bits == 0) continue;
    const Lanes distance = squareRoot(at.squared);
    const Lanes left = distance - barrier.clearance, gap = larger(left, splat(leastGap));
    const Lanes safely = larger(left - leastGap, splat(0.0f));
    const Lanes ratio = range / gap, slope = barrier.stiffness * ratio;
    Lanes strength = slope * (range - gap);
    Lanes stiff = slope * ratio;
    if (kind == ContactKind::edgeEdge) {
      // Where an end of an edge is nearest, the contacts of that vertex are sufficient.
      const Lanes inner = 16.0f * at.first * (one - at.first) * at.second * (one - at.second);
      strength = strength * inner;
      stiff = stiff * inner;
    }
    const Point f = (strength / larger(distance, splat(leastGap))) * at.apart;
    float x[laneCount], y[laneCount], z[laneCount], k[laneCount], g[laneCount], s[laneCount], t[laneCount],
        u[laneCount];
    store(f.x, x), store(f.y, y), store(f.z, z), store(stiff, k), store(safely, g);
    store(at.first, s), store(at.second, t), store(at.third, u);
    for (; bits != 0; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      const float force[3] = {x[lane], y[lane], z[lane]};
      Reaction& other = reactions[found++];
      int mine = 1;
      if (kind == ContactKind::edgeEdge) {
        mine = 2;
        push(forces + 4 * block[0][lane], 1.0f - s[lane], force, k[lane]);
        push(forces + 4 * block[1][lane], s[lane], force, k[lane]);
        other.vertex[0] = block[2][lane], other.vertex[1] = other.vertex[2] = block[3][lane];
      } else {
        push(forces + 4 * block[0][lane], 1.0f, force, k[lane]);
        for (int c = 0; c < 3; ++c) other.vertex[c] = block[1 + c][lane];
      }
      for (int c = 0; c < mine; ++c) {
        float& nearby = gaps[block[c][lane]];
        nearby = g[lane] < nearby ? g[lane] : nearby;
      }
      other.second = t[lane], other.third = u[lane];
      for (int c = 0; c < 3; ++c) other.force[c] = force[c];
      other.stiffness = k[lane];
      other.gap = g[lane];
    }
  }
  return found;
}

inline Lanes along(const float axis[3], const Point& p) {
  return axis[0] * p.x + axis[1] * p.y + axis[2] * p.z;
}

unsigned boxesThatMeet(const BoxBlock& block, const float lo[3], const float hi[3]) {
  unsigned bits = 0xffffu;
  for (int k = 0; k < 3; ++k)
    bits &= bitsWhereLess(load(block.lo[k]), splat(hi[k])) & bitsWhereLess(splat(lo[k]), load(block.hi[k]));
  return bits;
}

void loadCluster(const float* cell, const float offset[3], int corners, Cluster& out) {
  const Point shift{splat(offset[0]), splat(offset[1]), splat(offset[2])};
  Point corner[3], center{splat(0.0f), splat(0.0f), splat(0.0f)};
  for (int c = 0; c < corners; ++c) {
    corner[c] = vertices(cell, out.vertex[c]) + shift;
    center = center + corner[c];
    store(corner[c].x, out.at[c][0]), store(corner[c].y, out.at[c][1]), store(corner[c].z, out.at[c][2]);
  }
  Lanes low = along(out.axis, corner[0]), high = low;
  for (int c = 1; c < corners; ++c) {
    low = smaller(low, along(out.axis, corner[c]));
    high = larger(high, along(out.axis, corner[c]));
  }
  float lows[laneCount], highs[laneCount];
  store(low, lows), store(high, highs);
  out.from = lows[0], out.to = highs[0];
  for (int k = 1; k < out.count; ++k) {
    out.from = lows[k] < out.from ? lows[k] : out.from;
    out.to = highs[k] > out.to ? highs[k] : out.to;
  }
  center = splat(1.0f / float(corners)) * center;
  Lanes squared = splat(0.0f);
  for (int c = 0; c < corners; ++c) {
    const Point off = corner[c] - center;
    squared = larger(squared, dot(off, off));
  }
  store(center.x, out.center[0]), store(center.y, out.center[1]), store(center.z, out.center[2]);
  store(squareRoot(squared), out.radius);
  if (corners == 2) {
    const Point u = corner[1] - corner[0];
    store(inverseOf(dot(u, u)), out.inverse[0]);
  } else if (corners == 3) {
    const Plane plane = planeOf(corner[0], corner[1], corner[2]);
    store(plane.inverseU, out.inverse[0]), store(plane.inverseV, out.inverse[1]);
    store(plane.inverseW, out.inverse[2]), store(plane.inverseArea, out.inverse[3]);
  }
}

inline Point corners(const Cluster& cluster, int c) {
  return {load(cluster.at[c][0]), load(cluster.at[c][1]), load(cluster.at[c][2])};
}
/// Those of the second cluster whose spheres are near the box of the first, and near it along its axis.
inline unsigned nearBox(const Cluster& first, const Cluster& second, float limit) {
  const Lanes reach = load(second.radius) + limit;
  const Lanes t = along(first.axis, {load(second.center[0]), load(second.center[1]), load(second.center[2])});
  const unsigned bits =
      bitsWhereLess(larger(first.from - t, t - first.to), reach) & ((1u << second.count) - 1u);
  if (bits == 0) return bits;
  Lanes squared = splat(0.0f);
  for (int k = 0; k < 3; ++k) {
    const Lanes at = load(second.center[k]);
    const Lanes off = larger(larger(first.lo[k] - at, at - first.hi[k]), splat(0.0f));
    squared = squared + off * off;
  }
  return bitsWhereLess(squared, reach * reach) & bits;
}

int listContacts(ContactKind kind, const Cluster& first, const Cluster& second, float limit, bool same,
                 std::int16_t (*fours)[4]) {
  const bool edges = kind == ContactKind::edgeEdge;
  const Point center{load(first.center[0]), load(first.center[1]), load(first.center[2])};
  const Point a = corners(first, 0), u = edges ? corners(first, 1) - a : a;
  const Lanes inverseU = edges ? load(first.inverse[0]) : splat(0.0f);
  const Point normal{load(first.normal[0]), load(first.normal[1]), load(first.normal[2])};
  const Lanes reach = load(first.radius) + limit;
  const unsigned present = (1u << first.count) - 1u;
  int found = 0;
  for (unsigned left = nearBox(first, second, limit); left != 0; left &= left - 1) {
    const int k = __builtin_ctz(left);
    const auto of = [&](const float(*all)[16]) {
      return Point{splat(all[0][k]), splat(all[1][k]), splat(all[2][k])};
    };
    const Point off = center - of(second.center);
    const Lanes together = reach + second.radius[k];
    unsigned bits = bitsWhereLess(dot(off, off), together * together) & present;
    if (same && bits != 0) bits &= bitsWhereLess(dot(normal, of(second.normal)), splat(facing));
    if (bits == 0) continue;
    const Point c = of(second.at[0]), v = of(second.at[1]) - c;
    const Lanes squared = edges ? edgeEdge(a, u, inverseU, c, v, splat(second.inverse[0][k])).squared
                                : vertexTriangle(a, {c, v, of(second.at[2]) - c, splat(second.inverse[0][k]),
                                                     splat(second.inverse[1][k]), splat(second.inverse[2][k]),
                                                     splat(second.inverse[3][k])})
                                      .squared;
    bits &= bitsWhereLess(squared, splat(limit * limit));
    for (; bits != 0; bits &= bits - 1) {
      const int lane = __builtin_ctz(bits);
      std::int16_t* four = fours[found++];
      four[0] = first.vertex[0][lane];
      four[1] = edges ? first.vertex[1][lane] : second.vertex[0][k];
      four[2] = second.vertex[edges ? 0 : 1][k];
      four[3] = second.vertex[edges ? 1 : 2][k];
    }
  }
  return found;
}

}  // namespace

template <InstructionSet set>
ContactKernels proximityKernels() {
  return {contactForces, boxesThatMeet, loadCluster, listContacts};
}
template ContactKernels proximityKernels<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
