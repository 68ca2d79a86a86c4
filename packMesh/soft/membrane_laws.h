// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The elastic forces that packing uses, for numbers of any kind: double, and sixteen floats at a time.
#pragma once

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
