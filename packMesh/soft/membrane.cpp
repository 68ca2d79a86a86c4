// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/membrane.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "packMesh/core/error.h"
#include "packMesh/soft/membrane_laws.h"

namespace packmesh {
namespace {

/// HemoCell's persistence length and length of reference (cellMechanics.h) [µm].
constexpr double persistenceLength = 7.5e-3, referenceLength = 0.5;
/// The number of triangles for which the constants of area and volume are meant.
constexpr double referenceTriangles = 1280.0;
/// Triangles of a packing keep this far from the pole of HemoCell's law, at 0.3.
constexpr double areaPole = 0.0625;

/// Share of the limit beyond which a law is linear: nearer to the pole it is stiffer than steps allow for.
constexpr double linkTurn = 0.5, bendTurn = 0.8, areaTurn = 0.92, volumeTurn = 0.2;
/// Links through platelets are so much stiffer than those of edges (pltSimpleModel.cpp).
constexpr double innerLinkFactor = 5.0;
/// More than any strain: a spring that pulls.
constexpr float anyStrain = 1e9f;

MembraneLaw law(double limit, double share) {
  const double x2 = share * limit, rest = limit - x2;
  return {float(limit), float(std::sqrt(x2)), float(1.0 + (limit + x2) / (rest * rest))};
}

/// The integral of a law.
double integral(const MembraneLaw& l, double x) {
  const double inside = std::min(std::abs(x), double(l.turn)), beyond = std::abs(x) - inside;
  const double limit = l.limit, atTurn = inside + inside / (limit - inside * inside);
  return 0.5 * inside * inside - 0.5 * std::log1p(-inside * inside / limit) + atTurn * beyond +
         0.5 * l.slope * beyond * beyond;
}

/// HemoCell's laws.
double hemocellLaw(double limit, double x) {
  return x + x / std::abs(limit - x * x);
}

struct DoubleAccess {
  using Real = double;
  using Stored = double;
  static constexpr int width = 1;
  static double real(float v) { return v; }
  static double root(double v) { return std::sqrt(v); }
  static double clamp(double v, float most) { return std::min(std::max(v, -double(most)), double(most)); }
  static double least(double v, float other) { return std::min(v, double(other)); }
  static double load(const double* from, int i) { return from[i]; }
  static void store(double v, double* to, int i) { to[i] = v; }
};

Vec3 crossOfEdges(const std::vector<Vec3>& v, const Triangle& t) {
  return (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
}

}  // namespace

Membrane::Membrane(const TriangleMesh& mesh, const MembraneConstants& constants)
    : mesh_(mesh), constants_(constants) {
  constexpr std::size_t most = std::numeric_limits<std::int16_t>::max();
  if (mesh.vertices.size() > most || mesh.triangles.size() > most)
    throw InputError(fmt::format("a soft cell has {} vertices and {} triangles; at most {} are possible",
                                 mesh.vertices.size(), mesh.triangles.size(), most));
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      corner_.push_back(std::int16_t(t[k]));
      if (t[k] < t[(k + 1) % 3]) edges_.push_back({t[k], t[(k + 1) % 3]});
    }
  for (const auto& edge : edges_)
    for (const int v : edge) end_.push_back(std::int16_t(v));
  const double kT = constants.thermalEnergy;
  linkForce_ = constants.link * kT / persistenceLength;
  findRings();
  measureRest();
  if (constants.model == MembraneModel::platelet) findHinges();
  if (constants.model != MembraneModel::highOrder) findSprings();
  bendForce_ = constants.bend * kT / referenceLength;
  const double triangles = referenceTriangles / double(mesh.triangles.size());
  areaForce_ = constants.area * triangles * kT / referenceLength;
  volumeForce_ = constants.volume * triangles * kT / referenceLength;
}

void Membrane::findRings() {
  struct Sector {
    int from, to, triangle;
  };
  std::vector<std::vector<Sector>> sectors(mesh_.vertices.size());
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const Triangle& corner = mesh_.triangles[t];
      sectors[corner[k]].push_back({corner[(k + 1) % 3], corner[(k + 2) % 3], int(t)});
    }
  ringBegin_ = {0};
  for (const std::vector<Sector>& around : sectors) {
    int at = around.empty() ? -1 : around.front().from;
    for (std::size_t n = 0; n < around.size(); ++n) {
      const auto next =
          std::find_if(around.begin(), around.end(), [&](const Sector& s) { return s.from == at; });
      if (next == around.end()) throw InputError("the surface of a soft cell is not closed");
      ring_.push_back(std::int16_t(at));
      ringTriangle_.push_back(std::int16_t(next->triangle));
      at = next->to;
    }
    ringBegin_.push_back(int(ring_.size()));
  }
  for (const std::int16_t v : ring_) ringShare_.push_back(1.0f / float(ringBegin_[v + 1] - ringBegin_[v]));
}

void Membrane::measureRest() {
  const std::vector<Vec3>& x = mesh_.vertices;
  for (const auto& [a, b] : edges_) {
    length_.push_back((x[b] - x[a]).norm());
    meanEdge_ += length_.back() / double(edges_.size());
    inverseLength_.push_back(float(1.0 / length_.back()));
  }
  for (const Triangle& t : mesh_.triangles) {
    triangleArea_.push_back(0.5 * crossOfEdges(x, t).norm());
    area_ += triangleArea_.back();
    inverseArea_.push_back(float(1.0 / triangleArea_.back()));
  }
  volume_ = signedVolume(mesh_);
  std::vector<Vec3> gradient(x.size(), Vec3::Zero());
  for (const Triangle& t : mesh_.triangles)
    for (const int v : t) gradient[v] += crossOfEdges(x, t) / 6.0;
  for (const Vec3& g : gradient) volumeGradient_ += g.squaredNorm();
  for (std::size_t v = 0; v < x.size(); ++v) {
    deviation_.push_back(patchAt(x, int(v)).second);
    deviationView_.push_back(float(deviation_.back()));
  }
}

/// HemoCell takes the two triangles of an edge in the order in which they stand around its first vertex, from
/// the first triangle of the mesh with that vertex on (Palabos:
/// TriangularSurfaceMesh::getAdjacentTriangleIds(), TriangleToDef::computeEmanatingEdges()). With these in
/// the other order, as at the edge where that begins, the angle has the other sign, and so has the force:
/// away from rest.
void Membrane::findHinges() {
  std::map<std::array<int, 2>, std::array<int, 2>> leftOf;  // of an edge: the triangle, its third corner
  std::vector<int> beginsAt(mesh_.vertices.size(), -1);
  for (int t = 0; t < int(mesh_.triangles.size()); ++t)
    for (int k = 0; k < 3; ++k) {
      const Triangle& corner = mesh_.triangles[t];
      const int from = corner[k], to = corner[(k + 1) % 3];
      leftOf[{from, to}] = {t, corner[(k + 2) % 3]};
      if (beginsAt[from] < 0) beginsAt[from] = to;
    }
  for (const auto& [a, b] : edges_) {
    const auto [leftTriangle, left] = leftOf.at({a, b});
    const auto [rightTriangle, right] = leftOf.at({b, a});
    hinges_.all.push_back({right, left, rightTriangle, leftTriangle, 0.0, beginsAt[a] == b ? -1.0 : 1.0});
    Hinge& hinge = hinges_.all.back();
    hinge.angle = angleAt(mesh_.vertices, hinges_.all.size() - 1);
    for (const int number : {right, left, rightTriangle, leftTriangle})
      hinges_.corner.push_back(std::int16_t(number));
    hinges_.rest.insert(hinges_.rest.end(), {float(std::cos(hinge.angle)), float(std::sin(hinge.angle))});
  }
}

void Membrane::findSprings() {
  const auto add = [&](const std::array<int, 2>& end, double length, double force, bool pulls) {
    if (force == 0.0 || length == 0.0) return;
    springs_.all.push_back({end, length, force, pulls});
    for (const int v : end) springs_.end.push_back(std::int16_t(v));
    springs_.number.insert(springs_.number.end(),
                           {float(1.0 / length), float(force), pulls ? anyStrain : 0.0f});
  };
  for (const auto& end : constants_.innerLinks) {
    for (const int v : end)
      if (v < 0 || v >= int(mesh_.vertices.size()) || end[0] == end[1])
        throw InputError(fmt::format("an inner link between the vertices {} and {}, of {} from 0 on", end[0],
                                     end[1], mesh_.vertices.size()));
    if (constants_.model == MembraneModel::platelet)
      add(end, (mesh_.vertices[end[1]] - mesh_.vertices[end[0]]).norm(), innerLinkFactor * linkForce_, true);
    else
      for (const MembraneConstants::Core& core : {constants_.cytoskeleton, constants_.core})
        add(end, 2.0 * core.radius, core.force, false);
  }
}

/// Between the triangles at an edge, negative where it is convex [rad].
double Membrane::angleAt(const std::vector<Vec3>& x, std::size_t edge) const {
  const auto& [a, b] = edges_[edge];
  const Vec3 right = crossOfEdges(x, mesh_.triangles[hinges_.all[edge].rightTriangle]).normalized();
  const Vec3 left = crossOfEdges(x, mesh_.triangles[hinges_.all[edge].leftTriangle]).normalized();
  return std::atan2(right.cross(left).dot((x[b] - x[a]).normalized()), right.dot(left));
}

/// The normal that bending refers to, and the deviation of the centre of the neighbours along it.
std::pair<Vec3, double> Membrane::patchAt(const std::vector<Vec3>& x, int v) const {
  Vec3 normal = Vec3::Zero(), middle = Vec3::Zero();
  for (int k = ringBegin_[v]; k < ringBegin_[v + 1]; ++k) {
    normal += crossOfEdges(x, mesh_.triangles[ringTriangle_[k]]).normalized();
    middle += x[ring_[k]];
  }
  normal.normalize();
  return {normal, normal.dot(middle / double(ringBegin_[v + 1] - ringBegin_[v]) - x[v])};
}

MembraneView Membrane::view() const {
  MembraneView m{};
  m.vertices = int(mesh_.vertices.size());
  m.edges = int(edges_.size());
  m.triangles = int(mesh_.triangles.size());
  m.corner = corner_.data();
  m.end = end_.data();
  m.ringBegin = ringBegin_.data();
  m.ring = ring_.data();
  m.ringTriangle = ringTriangle_.data();
  m.ringShare = ringShare_.data();
  m.inverseLength = inverseLength_.data();
  m.inverseArea = inverseArea_.data();
  m.deviation = deviationView_.data();
  // HemoCell's force does not depend on the height of the triangles; that of an energy does.
  const auto height = float(0.5 * std::sqrt(3.0) * meanEdge_);
  m.model.hinges = {hinges_.all.empty() ? nullptr : hinges_.corner.data(), hinges_.rest.data(), height};
  m.model.springs = {int(springs_.all.size()), springs_.end.data(), springs_.number.data()};
  m.inverseMeanEdge = float(1.0 / meanEdge_);
  m.inverseMeanArea = float(double(m.triangles) / area_);
  m.inverseVolume = float(1.0 / volume_);
  m.linkForce = float(linkForce_);
  m.bendForce = float(bendForce_);
  // Per gradient of the area instead of the arm from a corner to the centroid: in an equilateral triangle
  // with sides of 1 these are 1/2 and 1/√3.
  m.areaForce = float(areaForce_ / constants_.spacing * 2.0 / std::sqrt(3.0));
  m.volumeForce = float(volumeForce_);
  m.link = law(MembraneLimits::link, linkTurn);
  m.bend = law(hinges_.all.empty() ? MembraneLimits::bend : MembraneLimits::angle, bendTurn);
  m.area = law(areaPole, areaTurn);
  m.volume = law(MembraneLimits::volume, volumeTurn);
  m.volumeStiffness = float(3.0 * volumeForce_ * double(m.triangles) / area_ / volume_ * volumeGradient_ *
                            double(m.volume.slope));
  return m;
}

double membraneEnergy(const Membrane& membrane, const std::vector<Vec3>& vertices, double scale,
                      std::vector<Vec3>* forces) {
  const MembraneView m = membrane.view();
  std::vector<double> position, scratch(m.scratch()), force(4 * vertices.size(), 0.0);
  for (const Vec3& v : vertices) position.insert(position.end(), {v.x(), v.y(), v.z()});
  MembraneLaws<DoubleAccess> laws(m, position.data(), scale, scratch.data());
  const double volume = laws.measure();
  if (forces) {
    laws.addTo(volume, force.data());
    for (std::size_t v = 0; v < vertices.size(); ++v)
      forces->emplace_back(force[4 * v], force[4 * v + 1], force[4 * v + 2]);
  }
  double energy = 0.0;
  for (int e = 0; e < m.edges; ++e) {
    const auto& [a, b] = membrane.edges_[e];
    const double rest = scale * membrane.length_[e];
    energy += m.linkForce * rest * integral(m.link, (vertices[b] - vertices[a]).norm() / rest - 1.0);
  }
  for (const Membrane::Spring& spring : membrane.springs_.all) {
    const double rest = scale * spring.length;
    const double x = spring.strain((vertices[spring.end[1]] - vertices[spring.end[0]]).norm() / scale);
    energy += 0.5 * spring.force * rest * x * x;
  }
  for (std::size_t e = 0; e < membrane.hinges_.all.size(); ++e) {
    const double off = membrane.angleAt(vertices, e) - membrane.hinges_.all[e].angle;
    energy += m.bendForce * scale * m.model.hinges.height * integral(m.bend, std::remainder(off, 2.0 * M_PI));
  }
  for (int v = 0; v < (m.model.hinges.corner ? 0 : m.vertices); ++v) {
    const double off = membrane.patchAt(vertices, v).second - scale * membrane.deviation_[v];
    const double unit = scale * membrane.meanEdge_;
    energy += m.bendForce * unit * integral(m.bend, off / unit);
  }
  for (int t = 0; t < m.triangles; ++t) {
    const double rest = scale * scale * membrane.triangleArea_[t];
    const double area = 0.5 * crossOfEdges(vertices, membrane.mesh_.triangles[t]).norm();
    energy += m.areaForce * rest * integral(m.area, area / rest - 1.0);
  }
  const double rest = scale * scale * scale * membrane.volume_;
  energy += 3.0 * m.volumeForce * m.inverseMeanArea / (scale * scale) * rest *
            integral(m.volume, volume / rest - 1.0);
  return energy;
}

void Membrane::addHemocellBending(const std::vector<Vec3>& x, std::vector<Vec3>& force) const {
  for (std::size_t e = 0; e < hinges_.all.size(); ++e) {
    const Hinge& hinge = hinges_.all[e];
    const Vec3 normals = crossOfEdges(x, mesh_.triangles[hinge.rightTriangle]).normalized() +
                         crossOfEdges(x, mesh_.triangles[hinge.leftTriangle]).normalized();
    const double angle = hinge.sense * (angleAt(x, e) - hinge.angle);
    const Vec3 bending = 0.5 * bendForce_ * hemocellLaw(MembraneLimits::angle, angle) * normals;
    for (const int v : edges_[e]) force[v] += bending;
    for (const int v : {hinge.right, hinge.left}) force[v] -= bending;
  }
  for (int v = 0; v < (hinges_.all.empty() ? int(x.size()) : 0); ++v) {
    const auto [normal, deviation] = patchAt(x, v);
    const Vec3 bending =
        bendForce_ * hemocellLaw(MembraneLimits::bend, (deviation - deviation_[v]) / meanEdge_) * normal;
    force[v] += bending;
    for (int k = ringBegin_[v]; k < ringBegin_[v + 1]; ++k)
      force[ring_[k]] -= bending / double(ringBegin_[v + 1] - ringBegin_[v]);
  }
}

std::vector<Vec3> hemocellForces(const Membrane& m, const std::vector<Vec3>& x) {
  std::vector<Vec3> force(x.size(), Vec3::Zero());
  const double strain = signedVolume({x, m.mesh_.triangles}) / m.volume_ - 1.0;
  // The law of the volume lacks the linear term of the others.
  const double outward = -m.volumeForce_ * strain / std::abs(MembraneLimits::volume - strain * strain) *
                         double(m.mesh_.triangles.size()) / m.area_;
  for (std::size_t t = 0; t < m.mesh_.triangles.size(); ++t) {
    const Triangle& corner = m.mesh_.triangles[t];
    const Vec3 across = crossOfEdges(x, corner);
    const double pull = m.areaForce_ / m.constants_.spacing *
                        hemocellLaw(MembraneLimits::area, 0.5 * across.norm() / m.triangleArea_[t] - 1.0);
    const Vec3 centroid = (x[corner[0]] + x[corner[1]] + x[corner[2]]) / 3.0;
    for (const int v : corner) force[v] += pull * (centroid - x[v]) + 0.5 * outward * across;
  }
  m.addHemocellBending(x, force);
  for (const Membrane::Spring& spring : m.springs_.all) {
    const auto& [a, b] = spring.end;
    const double length = (x[b] - x[a]).norm();
    const Vec3 pull = spring.force * spring.strain(length) / length * (x[b] - x[a]);
    force[a] += pull;
    force[b] -= pull;
  }
  for (std::size_t e = 0; e < m.edges_.size(); ++e) {
    const auto& [a, b] = m.edges_[e];
    const Vec3 along = x[b] - x[a];
    const double length = along.norm();
    const Vec3 pull =
        m.linkForce_ * hemocellLaw(MembraneLimits::link, length / m.length_[e] - 1.0) / length * along;
    force[a] += pull;
    force[b] -= pull;
  }
  return force;
}

void Deformation::enlarge(const Deformation& other) {
  for (double Deformation::*const value : {&Deformation::force, &Deformation::volume, &Deformation::area,
                                           &Deformation::triangle, &Deformation::edge})
    if (std::abs(other.*value) > std::abs(this->*value)) this->*value = other.*value;
}

Deformation deformationOf(const Membrane& m, const std::vector<Vec3>& x) {
  Deformation d;
  for (const Vec3& f : hemocellForces(m, x)) d.force = std::max(d.force, f.norm());
  const TriangleMesh now{x, m.mesh().triangles};
  d.volume = signedVolume(now) / m.volume() - 1.0;
  d.area = surfaceArea(now) / m.area() - 1.0;
  const auto enlarge = [](double& most, double change) {
    if (std::abs(change) > std::abs(most)) most = change;
  };
  const std::vector<Vec3>& rest = m.mesh().vertices;
  for (const Triangle& t : m.mesh().triangles)
    enlarge(d.triangle, crossOfEdges(x, t).norm() / crossOfEdges(rest, t).norm() - 1.0);
  for (const auto& [a, b] : m.edges())
    enlarge(d.edge, (x[b] - x[a]).norm() / (rest[b] - rest[a]).norm() - 1.0);
  return d;
}

}  // namespace packmesh
