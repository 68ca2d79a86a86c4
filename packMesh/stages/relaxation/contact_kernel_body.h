// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Body of the contact kernel; included by one translation unit per instruction set, which defines
/// PACKMESH_KERNEL_NAMESPACE. See contact_kernel.h.

#include "packMesh/stages/relaxation/contact_kernel.h"

namespace packmesh {
namespace PACKMESH_KERNEL_NAMESPACE {
namespace {

constexpr int width = 16;
typedef float Lanes __attribute__((vector_size(width * sizeof(float)), may_alias, aligned(4)));
typedef int Mask __attribute__((vector_size(width * sizeof(int))));

inline Lanes splat(float v) { return Lanes{} + v; }
inline Lanes load(const float* p) { return *reinterpret_cast<const Lanes*>(p); }
inline Lanes select(Mask m, Lanes a, Lanes b) { return m ? a : b; }
inline Lanes larger(Lanes a, Lanes b) { return select(a > b, a, b); }
inline Lanes smaller(Lanes a, Lanes b) { return select(a < b, a, b); }
inline Lanes magnitude(Lanes a) { return select(a < 0.0f, -a, a); }
inline Lanes squareRoot(Lanes a) {
  Lanes r;
  for (int k = 0; k < width; ++k) r[k] = __builtin_sqrtf(a[k]);
  return r;
}

/// Sum in an order that every instruction set keeps.
inline float sum(Lanes a) {
  for (int half = width / 2; half > 0; half /= 2)
    for (int k = 0; k < half; ++k) a[k] = a[k] + a[k + half];
  return a[0];
}
inline float largest(Lanes a) {
  float r = a[0];
  for (int k = 1; k < width; ++k) r = a[k] > r ? a[k] : r;
  return r;
}
inline float smallest(Lanes a) {
  float r = a[0];
  for (int k = 1; k < width; ++k) r = a[k] < r ? a[k] : r;
  return r;
}

struct Point {
  Lanes x, y, z;
};

inline Point transform(const RelativeFrame& f, Lanes x, Lanes y, Lanes z) {
  return {f.m[0] * x + f.m[1] * y + f.m[2] * z + f.t[0], f.m[3] * x + f.m[4] * y + f.m[5] * z + f.t[1],
          f.m[6] * x + f.m[7] * y + f.m[8] * z + f.t[2]};
}

/// A distance that the surface certainly has from points around `p`: from the disc + ellipsoid and the box.
inline Lanes lowerBound(const FieldView& field, const Point& p) {
  const Lanes rho = squareRoot(p.x * p.x + p.z * p.z);
  const Lanes beyond = larger(rho - field.ring, Lanes{});
  const Lanes rounded = squareRoot(beyond * beyond + p.y * p.y) - field.thickness;
  const Lanes flat = larger(magnitude(p.y) - field.extent[1],
                            larger(magnitude(p.x) - field.extent[0], magnitude(p.z) - field.extent[2]));
  return larger(rounded, flat);
}

struct Distance {
  Lanes value;
  Point gradient;  ///< not normalised
};

/// F = y² - P(s), d = F / (|grad F|/2 + sqrt(|grad F|²/4 - F)): exact for spheres, second order elsewhere.
inline Distance closedForm(const FieldView& field, const Point& q) {
  const Lanes s = field.a * q.x * q.x + field.c * q.z * q.z;
  Lanes value = splat(field.p[5]), slope = splat(5.0f * field.p[5]);
  for (int k = 4; k >= 0; --k) value = value * s + field.p[k];
  for (int k = 4; k >= 1; --k) slope = slope * s + static_cast<float>(k) * field.p[k];
  const Lanes f = q.y * q.y - value;
  const Lanes radial = -2.0f * slope;
  Distance d;
  d.gradient = {radial * field.a * q.x, 2.0f * q.y, radial * field.c * q.z};
  const Lanes quarter =
      0.25f * (d.gradient.x * d.gradient.x + d.gradient.y * d.gradient.y + d.gradient.z * d.gradient.z);
  const Lanes denominator = squareRoot(quarter) + squareRoot(larger(quarter - f, Lanes{}));
  d.value = f / larger(denominator, splat(1e-6f));
  return d;
}

/// Trilinear interpolation; points outside the grid are further away than any clearance.
inline Distance sampled(const FieldView& field, const Point& q) {
  Lanes u[3] = {(q.x - field.origin[0]) * field.nodesPerLength, (q.y - field.origin[1]) * field.nodesPerLength,
                (q.z - field.origin[2]) * field.nodesPerLength};
  Lanes corner[8], t[3], outside = Lanes{};
  for (int k = 0; k < 3; ++k) {
    const Lanes inside = smaller(larger(u[k], Lanes{}), splat(static_cast<float>(field.nodes[k]) - 1.0001f));
    outside = larger(outside, magnitude(u[k] - inside));
    u[k] = inside;
  }
  const int row = field.nodes[0], slab = field.nodes[0] * field.nodes[1];
  for (int lane = 0; lane < width; ++lane) {
    const int i = static_cast<int>(u[0][lane]), j = static_cast<int>(u[1][lane]), k = static_cast<int>(u[2][lane]);
    t[0][lane] = u[0][lane] - static_cast<float>(i);
    t[1][lane] = u[1][lane] - static_cast<float>(j);
    t[2][lane] = u[2][lane] - static_cast<float>(k);
    const float* v = field.value + i + row * j + slab * k;
    corner[0][lane] = v[0];
    corner[1][lane] = v[1];
    corner[2][lane] = v[row];
    corner[3][lane] = v[row + 1];
    corner[4][lane] = v[slab];
    corner[5][lane] = v[slab + 1];
    corner[6][lane] = v[slab + row];
    corner[7][lane] = v[slab + row + 1];
  }
  const auto mix = [](Lanes a, Lanes b, Lanes w) { return a + (b - a) * w; };
  const Lanes y00 = mix(corner[0], corner[1], t[0]), y10 = mix(corner[2], corner[3], t[0]);
  const Lanes y01 = mix(corner[4], corner[5], t[0]), y11 = mix(corner[6], corner[7], t[0]);
  const Lanes z0 = mix(y00, y10, t[1]), z1 = mix(y01, y11, t[1]);
  Distance d;
  d.value = mix(z0, z1, t[2]) + outside / field.nodesPerLength;
  d.gradient.x = mix(mix(corner[1] - corner[0], corner[3] - corner[2], t[1]),
                     mix(corner[5] - corner[4], corner[7] - corner[6], t[1]), t[2]);
  d.gradient.y = mix(y10 - y00, y11 - y01, t[2]);
  d.gradient.z = z1 - z0;
  return d;
}

}  // namespace

void contact(const SampleView& samples, const RelativeFrame& frame, const FieldView& field, float clearance,
             ContactSums& out) {
  Lanes weight{}, px{}, py{}, pz{}, nx{}, ny{}, nz{}, deepest{};
  Lanes nearest = splat(1e30f);
  for (int group = 0; group < samples.clusters; group += width) {
    const Point center = transform(frame, load(samples.centerX + group), load(samples.centerY + group),
                                   load(samples.centerZ + group));
    const Lanes apart = lowerBound(field, center) - frame.scale * load(samples.radius + group);
    const int count = samples.clusters - group < width ? samples.clusters - group : width;
    for (int member = 0; member < count; ++member) {
      if (apart[member] >= clearance) {
        nearest[member] = apart[member] < nearest[member] ? apart[member] : nearest[member];
        continue;
      }
      const int first = (group + member) * width;
      const Point q = transform(frame, load(samples.x + first), load(samples.y + first), load(samples.z + first));
      const Distance d = field.onGrid ? sampled(field, q) : closedForm(field, q);
      nearest = smaller(nearest, d.value);
      const Lanes penetration = larger(clearance - d.value, Lanes{});
      const Lanes length = squareRoot(d.gradient.x * d.gradient.x + d.gradient.y * d.gradient.y +
                                      d.gradient.z * d.gradient.z);
      const Lanes perLength = penetration / larger(length, splat(1e-6f));
      weight += penetration;
      px += penetration * q.x;
      py += penetration * q.y;
      pz += penetration * q.z;
      nx += perLength * d.gradient.x;
      ny += perLength * d.gradient.y;
      nz += perLength * d.gradient.z;
      deepest = larger(deepest, penetration);
    }
  }
  out.weight = sum(weight);
  out.point[0] = sum(px);
  out.point[1] = sum(py);
  out.point[2] = sum(pz);
  out.normal[0] = sum(nx);
  out.normal[1] = sum(ny);
  out.normal[2] = sum(nz);
  out.deepest = largest(deepest);
  out.nearest = smallest(nearest);
}

}  // namespace PACKMESH_KERNEL_NAMESPACE
}  // namespace packmesh
