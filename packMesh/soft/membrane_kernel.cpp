// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_kernels.h"

#include "packMesh/simd/lanes.h"
#include "packMesh/soft/membrane_laws.h"

namespace packmesh {
namespace {

static_assert(MembraneBatch::cells == laneCount);

struct LanesAccess {
  using Real = Lanes;
  using Stored = float;
  static constexpr int width = laneCount;
  static Lanes real(float v) { return splat(v); }
  static Lanes root(const Lanes& v) { return squareRoot(v); }
  static Lanes clamp(const Lanes& v, float most) { return smaller(larger(v, splat(-most)), splat(most)); }
  static Lanes least(const Lanes& v, float other) { return smaller(v, splat(other)); }
  static Lanes load(const float* from, int i) { return packmesh::load(from + std::ptrdiff_t(i) * laneCount); }
  static void store(const Lanes& v, float* to, int i) {
    packmesh::store(v, to + std::ptrdiff_t(i) * laneCount);
  }
};
using Access = LanesAccess;
using V = Vector<Lanes>;

inline V get(const float* from, int i) {
  return {Access::load(from, i), Access::load(from, i + 1), Access::load(from, i + 2)};
}
inline void put(float* to, int i, const V& v) {
  Access::store(v.x, to, i), Access::store(v.y, to, i + 1), Access::store(v.z, to, i + 2);
}

/// A cell as a whole.
struct RigidMotion {
  V center, shift, turn;
  V at(const V& position) const { return shift + cross(turn, position - center); }
};

/// The step of a rigid cell. Steps of vertices alone move it slowly, since they pass a push on from one to
/// the next. Pre: forces are those of contacts alone
/// @param base stiffness that is added to that of the contacts [pN/µm]
RigidMotion rigidMotion(const MembraneView& m, const MembraneBatch& batch, const Lanes& base) {
  const V zero{splat(0.0f), splat(0.0f), splat(0.0f)};
  V center = zero, force = zero, torque = zero;
  for (int v = 0; v < m.vertices; ++v) center = center + get(batch.position, 3 * v);
  center = splat(1.0f / float(m.vertices)) * center;
  Lanes stiffness = base, ofTurn = base;  // the latter is that of a turn at 1 µm
  for (int v = 0; v < m.vertices; ++v) {
    const V f = get(batch.force, 4 * v), r = get(batch.position, 3 * v) - center;
    const Lanes k = Access::load(batch.force, 4 * v + 3);
    force = force + f;
    torque = torque + cross(r, f);
    stiffness += k;
    ofTurn += k * dot(r, r);
  }
  return {center, (splat(1.0f) / stiffness) * force, (splat(1.0f) / ofTurn) * torque};
}

void advance(const MembraneView& m, const MembraneBatch& batch, const StepSettings& settings) {
  const Lanes zero = splat(0.0f), tiny = splat(tinySquare);
  const Lanes scale = load(batch.scale), moves = load(batch.moves);
  MembraneLaws<Access> laws(m, batch.position, scale, batch.scratch);
  const Lanes volume = laws.measure();
  store(volume, batch.volume);
  const Lanes base = splat(settings.stiffness) / scale;
  const RigidMotion together = rigidMotion(m, batch, base);
  laws.addTo(volume, batch.force);

  // A cell whose last step went uphill loses its momentum.
  Lanes power = zero, largestForce = zero;
  for (int v = 0; v < m.vertices; ++v) {
    const V f = get(batch.force, 4 * v);
    power += dot(f, get(batch.step, 3 * v));
    largestForce = larger(largestForce, dot(f, f));
  }
  store(squareRoot(largestForce), batch.largestForce);
  const Lanes momentum = select(power < zero, zero, splat(settings.momentum));
  Lanes farthest = zero;
  for (int v = 0; v < m.vertices; ++v) {
    const V f = get(batch.force, 4 * v);
    const Lanes mobility = splat(1.0f) / (base + Access::load(batch.force, 4 * v + 3));
    V step = momentum * get(batch.step, 3 * v) + mobility * f + together.at(get(batch.position, 3 * v));
    const Lanes most = smaller(settings.shareOfGap * Access::load(batch.gap, v), splat(settings.most));
    const Lanes length = squareRoot(dot(step, step) + tiny);
    step = (moves * smaller(splat(1.0f), most / length)) * step;
    const V to = get(batch.position, 3 * v) + step;
    put(batch.step, 3 * v, step);
    put(batch.position, 3 * v, to);
    const V off = to - get(batch.listed, 3 * v);
    farthest = larger(farthest, dot(off, off));
  }
  store(squareRoot(farthest), batch.farthest);
}

}  // namespace

template <InstructionSet set>
MembraneKernel membraneKernel() {
  return advance;
}
template MembraneKernel membraneKernel<InstructionSet::PACKMESH_INSTRUCTION_SET>();

}  // namespace packmesh
