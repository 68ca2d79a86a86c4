// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Distances from the surface of a shape in lanes of floats, for kernels: everything has internal
/// linkage, as in lanes.h. (SurfaceDistance has the same in double precision.)
#pragma once

#include "packMesh/field/interpolation.h"
#include "packMesh/shape/field_view.h"
#include "packMesh/simd/lanes.h"

namespace packmesh {
namespace {

struct Point {
  Lanes x, y, z;
};

inline Point transform(const RelativeFrame& f, Lanes x, Lanes y, Lanes z) {
  return {f.m[0] * x + f.m[1] * y + f.m[2] * z + f.t[0], f.m[3] * x + f.m[4] * y + f.m[5] * z + f.t[1],
          f.m[6] * x + f.m[7] * y + f.m[8] * z + f.t[2]};
}

/// Lower bound of the distance between the surface and the points around `p`, from the disc + ellipsoid bound
/// and the box.
inline Lanes lowerBound(const FieldView& field, const Point& p) {
  const Lanes rho = squareRoot(p.x * p.x + p.z * p.z);
  const Lanes beyond = larger(rho - field.ring, splat(0.0f));
  const Lanes rounded = squareRoot(beyond * beyond + p.y * p.y) - field.thickness;
  const Lanes flat = larger(magnitude(p.y) - field.extent[1],
                            larger(magnitude(p.x) - field.extent[0], magnitude(p.z) - field.extent[2]));
  return larger(rounded, flat);
}

/// Value F and gradient of a function that vanishes on the surface, with |gradient|²/4; distance() converts
/// it to the distance to the surface.
struct Level {
  Lanes f;
  Point gradient;
  Lanes quarter;
};

inline Lanes quarterOf(const Point& g) {
  return 0.25f * (g.x * g.x + g.y * g.y + g.z * g.z);
}

/// F = y² - P(s), with P continued beyond the rim s = 1 by a parabola: the polynomial itself is meaningless
/// there; a red cell's returns to zero at 1.36 radii.
inline Level closedForm(const FieldView& field, const Point& q) {
  const Lanes s = field.a * q.x * q.x + field.c * q.z * q.z;
  const Lanes inner = smaller(s, splat(1.0f)), beyond = s - inner, bend = field.bend * beyond;
  const float* p = field.p;
  const Lanes square = inner * inner;  // Estrin's order: shorter chains than Horner's
  Lanes value = (p[0] + p[1] * inner) + square * ((p[2] + p[3] * inner) + square * (p[4] + p[5] * inner));
  Lanes slope =
      (p[1] + 2.0f * p[2] * inner) + square * ((3.0f * p[3] + 4.0f * p[4] * inner) + square * (5.0f * p[5]));
  value += (slope + bend) * beyond;
  slope += 2.0f * bend;
  Level level;
  level.f = q.y * q.y - value;
  const Lanes radial = -2.0f * slope;
  level.gradient = {radial * field.a * q.x, 2.0f * q.y, radial * field.c * q.z};
  level.quarter = quarterOf(level.gradient);
  return level;
}

/// F = the sampled distance, by trilinear interpolation. Outside the grid, where points are further away than
/// any clearance, a lower bound: the cell lies on the other side of the nearest point of the grid.
inline Level sampled(const FieldView& field, const Point& q) {
  Lanes u[3] = {field.nodesPerLength * (q.x - field.origin[0]),
                field.nodesPerLength * (q.y - field.origin[1]),
                field.nodesPerLength * (q.z - field.origin[2])};
  Lanes outside = splat(0.0f);
  float at[3][laneCount];
  for (int k = 0; k < 3; ++k) {
    const Lanes inside =
        smaller(larger(u[k], splat(0.0f)), splat(static_cast<float>(field.nodes[k]) - 1.0001f));
    outside = larger(outside, magnitude(u[k] - inside));
    store(inside, at[k]);
  }
  const int row = field.nodes[0], slab = field.nodes[0] * field.nodes[1];
  float corner[8][laneCount], fraction[3][laneCount];
  for (int lane = 0; lane < laneCount; ++lane) {
    int node[3];
    for (int k = 0; k < 3; ++k) {
      node[k] = static_cast<int>(at[k][lane]);
      fraction[k][lane] = at[k][lane] - static_cast<float>(node[k]);
    }
    const float* v = field.value + node[0] + row * node[1] + slab * node[2];
    corner[0][lane] = v[0];
    corner[1][lane] = v[1];
    corner[2][lane] = v[row];
    corner[3][lane] = v[row + 1];
    corner[4][lane] = v[slab];
    corner[5][lane] = v[slab + 1];
    corner[6][lane] = v[slab + row];
    corner[7][lane] = v[slab + row + 1];
  }
  const Lanes t[3] = {load(fraction[0]), load(fraction[1]), load(fraction[2])};
  Lanes c[8];
  for (int k = 0; k < 8; ++k) c[k] = load(corner[k]);
  const Trilinear<Lanes> interpolated(c, t);
  Level level;
  level.f = interpolated.value;
  level.f = select(splat(0.0f) < outside, larger(level.f, outside / splat(field.nodesPerLength)), level.f);
  level.gradient = {interpolated.slope[0], interpolated.slope[1], interpolated.slope[2]};
  level.quarter = quarterOf(level.gradient);
  return level;
}

}  // namespace
}  // namespace packmesh
