// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The elastic forces that packing uses, for numbers of any kind: double, and sixteen floats at a time.
#pragma once

#include <initializer_list>

#include "packMesh/soft/soft_kernels.h"

namespace packmesh {
namespace {

constexpr float tinySquare =
    1e-20f;  // [µm², µm⁴] far below rounding; keeps what collapses from dividing by 0

template <class Real>
struct Vector {
  Real x, y, z;
};
template <class Real>
inline Vector<Real> operator+(const Vector<Real>& a, const Vector<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
inline Vector<Real> operator-(const Vector<Real>& a, const Vector<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
inline Vector<Real> operator*(const Real& s, const Vector<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
inline Real dot(const Vector<Real>& a, const Vector<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
inline Vector<Real> cross(const Vector<Real>& a, const Vector<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Positions, forces and scratch of one cell, or of sixteen. `Access` says how a number is stored:
/// Access::Stored, Access::Real, load(const Stored*, index), store(Real, Stored*, index).
template <class Access>
class MembraneLaws {
 public:
  using Real = typename Access::Real;
  using Stored = typename Access::Stored;
  using V = Vector<Real>;

  /// @param scratch MembraneView::scratch numbers per cell
  MembraneLaws(const MembraneView& m, const Stored* position, const Real& scale, Stored* scratch)
      : m_(m),
        position_(position),
        scale_(scale),
        inverse_(Access::real(1.0f) / scale),
        normal_(scratch),
        bend_(scratch + 5 * Access::width * m.triangles),
        twist_(scratch + (5 * m.triangles + 3 * m.vertices) * Access::width) {}

  /// Volume, normals of triangles.
  Real measure() {
    Real volume = Access::real(0.0f);
    for (int t = 0; t < m_.triangles; ++t) {
      const std::int16_t* corner = m_.corner + 3 * t;
      const V a = at(corner[0]), b = at(corner[1]), c = at(corner[2]);
      const V across = cross(b - a, c - a);
      volume = volume + dot(a, across);
      const Real doubled = Access::root(dot(across, across) + Access::real(tinySquare));
      const Real inverse = Access::real(1.0f) / doubled;
      put(normal_, 5 * t, inverse * across);
      Access::store(inverse, normal_, 5 * t + 3);
      Access::store(doubled, normal_, 5 * t + 4);
    }
    return volume * Access::real(1.0f / 6.0f);
  }

  /// Adds up to four numbers per vertex: a force, and a bound of the stiffness [pN/µm].
  void addTo(const Real& volume, Stored* force) {
    edges(force);
    springs(force);
    if (m_.model.hinges.corner)
      hinges(force);
    else
      vertices(force);
    triangles(pressure(volume), force);
  }

 private:
  V at(int v) const {
    return {Access::load(position_, 3 * v), Access::load(position_, 3 * v + 1),
            Access::load(position_, 3 * v + 2)};
  }
  static V get(const Stored* from, int i) {
    return {Access::load(from, i), Access::load(from, i + 1), Access::load(from, i + 2)};
  }
  static void put(Stored* to, int i, const V& v) {
    Access::store(v.x, to, i), Access::store(v.y, to, i + 1), Access::store(v.z, to, i + 2);
  }
  static void add(Stored* to, int v, const V& f) { put(to, 4 * v, get(to, 4 * v) + f); }
  static void stiffen(Stored* to, int v, const Real& k) {
    Access::store(Access::load(to, 4 * v + 3) + k, to, 4 * v + 3);
  }
  struct Law {
    Real value, slope;
  };
  static Law law(const MembraneLaw& l, const Real& x) {
    const Real inside = Access::clamp(x, l.turn), squared = inside * inside;
    const Real inverse = Access::real(1.0f) / (Access::real(l.limit) - squared);
    return {inside + inside * inverse + Access::real(l.slope) * (x - inside),
            Access::real(1.0f) + (Access::real(l.limit) + squared) * inverse * inverse};
  }

  void edges(Stored* force) {
    for (int e = 0; e < m_.edges; ++e) {
      const int a = m_.end[2 * e], b = m_.end[2 * e + 1];
      const V along = at(b) - at(a);
      const Real length = Access::root(dot(along, along) + Access::real(tinySquare));
      const Real strain = length * inverse_ * Access::real(m_.inverseLength[e]) - Access::real(1.0f);
      const V f = (Access::real(m_.linkForce) * forceOfLink(strain, length)) * along;
      add(force, a, f);
      put(force, 4 * b, get(force, 4 * b) - f);
    }
  }

  /// The law of links divided by the length, with a single division.
  Real forceOfLink(const Real& strain, const Real& length) const {
    const Real inside = Access::clamp(strain, m_.link.turn);
    const Real rest = Access::real(m_.link.limit) - inside * inside;
    const Real beyond = Access::real(m_.link.slope) * (strain - inside);
    return (inside * (rest + Access::real(1.0f)) + beyond * rest) / (rest * length);
  }

  void springs(Stored* force) {
    for (int s = 0; s < m_.model.springs.count; ++s) {
      const int a = m_.model.springs.end[2 * s], b = m_.model.springs.end[2 * s + 1];
      const float* const spring = m_.model.springs.number + 3 * s;
      const V along = at(b) - at(a);
      const Real length = Access::root(dot(along, along) + Access::real(tinySquare));
      const Real perLength = inverse_ * Access::real(spring[0]);
      const Real strain = Access::least(length * perLength - Access::real(1.0f), spring[2]);
      const V f = (Access::real(spring[1]) * strain / length) * along;
      add(force, a, f);
      put(force, 4 * b, get(force, 4 * b) - f);
      for (const int v : {a, b}) stiffen(force, v, Access::real(2.0f * spring[1]) * perLength);
    }
  }

  /// An angle of a sine and a cosine: four times that of its quarter, of which the tangent is at most 1
  /// (Abramowitz and Stegun 1964, 4.4.49: to 4e-5).
  static Real angle(const Real& sine, const Real& cosine) {
    constexpr float folded = 1e-6f;  // keeps the half of an angle of π from dividing by 0
    const Real one = Access::real(1.0f), half = sine / (cosine + Access::real(1.0f + folded));
    const Real quarter = half / (one + Access::root(one + half * half)), squared = quarter * quarter;
    Real sum = Access::real(0.0208351f);
    for (const float c : {-0.0851330f, 0.1801410f, -0.3302995f, 0.9998660f})
      sum = sum * squared + Access::real(c);
    return Access::real(4.0f) * quarter * sum;
  }

  /// Bending by the angles between triangles, whose gradients are their normals divided by their heights.
  void hinges(Stored* force) {
    const V zero{Access::real(0.0f), Access::real(0.0f), Access::real(0.0f)};
    for (int v = 0; v < m_.vertices; ++v) put(twist_, 3 * v, zero);
    const Real unit = scale_ * Access::real(m_.bendForce * m_.model.hinges.height);
    for (int e = 0; e < m_.edges; ++e) {
      const std::int16_t* const hinge = m_.model.hinges.corner + 4 * e;
      const int a = m_.end[2 * e], b = m_.end[2 * e + 1];
      const V along = at(b) - at(a), right = get(normal_, 5 * hinge[2]), left = get(normal_, 5 * hinge[3]);
      const Real squared = dot(along, along) + Access::real(tinySquare), length = Access::root(squared);
      const Real sine = dot(cross(right, left), along) / length, cosine = dot(right, left);
      const Real cosineRest = Access::real(m_.model.hinges.rest[2 * e]),
                 sineRest = Access::real(m_.model.hinges.rest[2 * e + 1]);
      const Law bending =
          law(m_.bend, angle(sine * cosineRest - cosine * sineRest, cosine * cosineRest + sine * sineRest));
      const Real perRight = length * Access::load(normal_, 5 * hinge[2] + 3);
      const Real perLeft = length * Access::load(normal_, 5 * hinge[3] + 3);
      const V atRight = (unit * bending.value * perRight) * right,
              atLeft = (unit * bending.value * perLeft) * left;
      const V atB = (dot(at(hinge[0]) - at(a), along) / squared) * atRight +
                    (dot(at(hinge[1]) - at(a), along) / squared) * atLeft;
      put(force, 4 * hinge[0], get(force, 4 * hinge[0]) - atRight);
      put(force, 4 * hinge[1], get(force, 4 * hinge[1]) - atLeft);
      add(force, b, atB);
      add(force, a, atRight + atLeft - atB);
      const Real k = unit * bending.slope * (perRight + perLeft) * (perRight + perLeft);
      for (const int v : {a, b, int(hinge[0]), int(hinge[1])}) stiffen(force, v, k);
    }
  }

  void vertices(Stored* force) {
    const Real perEdge = inverse_ * Access::real(m_.inverseMeanEdge);
    for (int v = 0; v < m_.vertices; ++v) {
      const int begin = m_.ringBegin[v], end = m_.ringBegin[v + 1];
      const V here = at(v);
      V middle{Access::real(0.0f), Access::real(0.0f), Access::real(0.0f)}, normal = middle;
      for (int k = begin; k < end; ++k) {
        middle = middle + (at(m_.ring[k]) - here);
        normal = normal + get(normal_, 5 * m_.ringTriangle[k]);
      }
      const Real share = Access::real(1.0f / float(end - begin));
      const V away = share * middle;
      const Real inverse = Access::real(1.0f) / Access::root(dot(normal, normal) + Access::real(tinySquare));
      normal = inverse * normal;
      const Real deviation = dot(normal, away);
      const Real strain = (deviation - scale_ * Access::real(m_.deviation[v])) * perEdge;
      const Law bending = law(m_.bend, strain);
      const Real f = Access::real(m_.bendForce) * bending.value;
      put(bend_, 3 * v, f * normal);
      put(twist_, 3 * v, (f * inverse) * (away - deviation * normal));
      const Real k = Access::real(m_.bendForce) * bending.slope * perEdge;
      stiffen(force, v, k);
      for (int n = begin; n < end; ++n) stiffen(force, m_.ring[n], share * k);
    }
    for (int v = 0; v < m_.vertices; ++v) {
      const int begin = m_.ringBegin[v], end = m_.ringBegin[v + 1];
      V f = get(bend_, 3 * v);
      for (int k = begin; k < end; ++k) f = f - Access::real(m_.ringShare[k]) * get(bend_, 3 * m_.ring[k]);
      add(force, v, f);
    }
  }

  /// Force per area on the membrane [pN/µm²].
  Real pressure(const Real& volume) const {
    const Real strain =
        volume * (inverse_ * inverse_ * inverse_) * Access::real(m_.inverseVolume) - Access::real(1.0f);
    return Access::real(-3.0f * m_.volumeForce * m_.inverseMeanArea) * inverse_ * inverse_ *
           law(m_.volume, strain).value;
  }

  /// Area, volume, and what turns the normals that bending refers to.
  void triangles(const Real& pressure, Stored* force) {
    const Real perArea = inverse_ * inverse_;
    for (int t = 0; t < m_.triangles; ++t) {
      const std::int16_t* corner = m_.corner + 3 * t;
      const V a = at(corner[0]), b = at(corner[1]), c = at(corner[2]);
      const V normal = get(normal_, 5 * t);
      const Real inverse = Access::load(normal_, 5 * t + 3), doubled = Access::load(normal_, 5 * t + 4);
      const Real strain = Access::real(0.5f * m_.inverseArea[t]) * perArea * doubled - Access::real(1.0f);
      const Law stretching = law(m_.area, strain);
      const Real tension = Access::real(0.5f * m_.areaForce) * stretching.value;
      const V turning = get(twist_, 3 * corner[0]) + get(twist_, 3 * corner[1]) + get(twist_, 3 * corner[2]);
      // Energy per change of the vector (b - a) x (c - a).
      const V q = tension * normal + inverse * (turning - dot(turning, normal) * normal);
      const V outward = (pressure * Access::real(1.0f / 6.0f) * doubled) * normal;
      const V atB = cross(c - a, q), atC = cross(q, b - a);
      add(force, corner[0], outward + (atB + atC));
      add(force, corner[1], outward - atB);
      add(force, corner[2], outward - atC);
      // In an equilateral triangle, the squared gradient of the area is √3/3 times the area.
      const Real k = Access::real(0.6f * m_.areaForce) * stretching.slope;
      for (int n = 0; n < 3; ++n) stiffen(force, corner[n], k);
    }
  }

  const MembraneView& m_;
  const Stored* position_;
  Real scale_, inverse_;
  Stored *normal_, *bend_, *twist_;
};

}  // namespace
}  // namespace packmesh
