// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growth_kernels.h"

#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

constexpr int width = laneCount;

/// Keeps quotients finite for lanes beyond the last plane, which are not used.
constexpr float leastSquare = 1e-30f;

struct Plane {
  Lanes arm[3], normal[3], distance;

  Plane(const float* const planes[7], int at) {
    for (int k = 0; k < 3; ++k) {
      arm[k] = load(planes[k] + at);
      normal[k] = load(planes[3 + k] + at);
    }
    distance = load(planes[6] + at);
  }
};

inline Lanes dot(const Lanes (&a)[3], const Lanes (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Component of a x b.
inline Lanes cross(const Lanes (&a)[3], const Lanes (&b)[3], int k) {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  return a[i] * b[j] - a[j] * b[i];
}

int reachedPlanes(const float* const planes[7], int count, const StepReach& reach, float* const out[7],
                  float& room) {
  int kept = 0;
  Lanes least = splat(1e30f);
  for (int at = 0; at < count; at += width) {
    const Plane p(planes, at);
    const Lanes along = dot(p.arm, p.normal), now = reach.scale * along, then = reach.largest * along;
    const Lanes limit = larger(p.distance - reach.padding, now);
    Lanes shift = splat(0.0f), turn = splat(0.0f);
    for (int k = 0; k < 3; ++k) {
      shift += magnitude(p.normal[k]);
      turn += magnitude(cross(p.arm, p.normal, k));
    }
    const Lanes most =
        larger(now, then) + reach.translation * shift + (reach.rotation * reach.largest) * turn;
    unsigned bits = bitsWhereLess(limit, most + reach.margin);
    if (count - at < width) bits &= (1u << (count - at)) - 1u;
    for (int k = 0; k < 3; ++k) {
      storeWhere(bits, p.arm[k], out[k] + kept);
      storeWhere(bits, p.normal[k], out[3 + k] + kept);
    }
    storeWhere(bits, limit, out[6] + kept);
    float rooms[width];
    storeWhere(bits, limit - then, rooms);
    const int found = __builtin_popcount(bits);
    for (int k = found; k < width; ++k) rooms[k] = 1e30f;
    least = smaller(least, load(rooms));
    kept += found;
  }
  room = smallest(least);
  return kept;
}

void rowsOfPlanes(const float* const planes[7], int count, const float rotation[9], float scale,
                  bool atBarrier, double* const out[8]) {
  for (int at = 0; at < count; at += width) {
    const Plane p(planes, at);
    Lanes arm[3], row[8];
    for (int k = 0; k < 3; ++k)
      arm[k] = rotation[3 * k] * p.arm[0] + rotation[3 * k + 1] * p.arm[1] + rotation[3 * k + 2] * p.arm[2];
    const Lanes along = dot(p.normal, arm);
    row[0] = atBarrier ? splat(1.0f) : along;
    for (int k = 0; k < 3; ++k) {
      row[1 + k] = scale * cross(arm, p.normal, k);
      row[4 + k] = p.normal[k];
    }
    row[7] = atBarrier ? p.distance - scale * along : p.distance;
    Lanes square = row[0] * row[0];
    for (int k = 1; k < 7; ++k) square += row[k] * row[k];
    const Lanes unit = splat(1.0f) / squareRoot(larger(square, splat(leastSquare)));
    for (int k = 0; k < 8; ++k) {
      float value[width];
      store(unit * row[k], value);
      for (int lane = 0; lane < width; ++lane) out[k][at + lane] = static_cast<double>(value[lane]);
    }
  }
}

}  // namespace

template <InstructionSet set>
GrowthRowKernel growthRowKernel() {
  return {reachedPlanes, rowsOfPlanes};
}
template GrowthRowKernel growthRowKernel<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
