// SPDX-License-Identifier: AGPL-3.0-or-later
// The template meshes of HemoCell 2.7, vertex by vertex. Initial polyhedra, order of subdivision and maps are
// those of HemoCell (and of the Palabos sphere it starts from); they matter because all later results for a
// placed cell refer to these vertices.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/inflation.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_file.h"

namespace packmesh::hemocell {
namespace {

/// HemoCell's rotation of templates: the symmetry axis of a cell built along z becomes y.
Vec3 turned(const Vec3& p) {
  return {-p.y(), -p.z(), p.x()};
}

TriangleMesh icosahedron() {
  constexpr double t = 0.8506508084, o = 0.5257311121;
  return {{{t, o, 0},
           {-t, o, 0},
           {-t, -o, 0},
           {t, -o, 0},  // 0-3
           {o, 0, t},
           {o, 0, -t},
           {-o, 0, -t},
           {-o, 0, t},  // 4-7
           {0, t, o},
           {0, -t, o},
           {0, -t, -o},
           {0, t, -o}},  // 8-11
          {{6, 5, 10}, {6, 11, 5}, {7, 9, 4},  {7, 4, 8},  {2, 1, 6},  {2, 7, 1},  {0, 3, 5},
           {0, 4, 3},  {10, 9, 2}, {10, 3, 9}, {11, 1, 8}, {11, 8, 0}, {10, 2, 6}, {9, 7, 2},
           {6, 1, 11}, {7, 8, 1},  {5, 3, 10}, {4, 9, 3},  {5, 11, 0}, {4, 0, 8}}};
}

TriangleMesh octahedron() {
  return {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
          {{4, 0, 2}, {4, 2, 1}, {4, 1, 3}, {4, 3, 0}, {5, 2, 0}, {5, 1, 2}, {5, 3, 1}, {5, 0, 3}}};
}

/// Divides every triangle into four on the unit sphere: the central one in place, the corner ones appended.
void subdivide(TriangleMesh& mesh) {
  std::map<std::pair<int, int>, int> midpoints;
  const auto midpoint = [&](int a, int b) {
    const auto [entry, isNew] =
        midpoints.try_emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.size()));
    if (isNew) mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
    return entry->second;
  };
  const std::size_t count = mesh.triangles.size();
  for (std::size_t i = 0; i < count; ++i) {
    const auto [a, b, c] = mesh.triangles[i];
    const int d = midpoint(a, b), e = midpoint(b, c), f = midpoint(c, a);
    mesh.triangles[i] = {d, e, f};
    mesh.triangles.push_back({a, d, f});
    mesh.triangles.push_back({d, b, e});
    mesh.triangles.push_back({f, e, c});
  }
}

/// Numbers the vertices in the order of their first use by triangles.
void numberByFirstAppearance(TriangleMesh& mesh) {
  std::vector<int> number(mesh.vertices.size(), -1);
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  for (Triangle& t : mesh.triangles)
    for (int& v : t) {
      if (number[v] < 0) {
        number[v] = static_cast<int>(vertices.size());
        vertices.push_back(mesh.vertices[v]);
      }
      v = number[v];
    }
  mesh.vertices = std::move(vertices);
}

TriangleMesh unitSphere(TriangleMesh mesh, int minNumTriangles) {
  while (static_cast<int>(mesh.triangles.size()) < minNumTriangles) subdivide(mesh);
  numberByFirstAppearance(mesh);
  return mesh;
}

/// HemoCell's red cell: the unit sphere flattened along z.
Vec3 biconcave(const Vec3& p, double radius) {
  const double r2 = std::min(p.x() * p.x() + p.y() * p.y(), 1.0);
  const double height = std::sqrt(1.0 - r2) * (biconcaveC0 + biconcaveC2 * r2 + biconcaveC4 * r2 * r2);
  return radius * Vec3(p.x(), p.y(), std::copysign(height, p.z()));
}

/// HemoCell's platelet: an oblate ellipsoid, thin along z.
Vec3 oblate(const Vec3& p, double radius, double aspectRatio) {
  const double r2 = std::min(p.x() * p.x() + p.y() * p.y(), 1.0);
  return radius * Vec3(p.x(), p.y(), std::copysign(aspectRatio * std::sqrt(1.0 - r2), p.z()));
}

/// The STL, scaled so that its largest extent is twice the radius.
TriangleMesh scaledStl(const CellModel& model) {
  TriangleMesh mesh = meshFrom(model.stlFile);
  const double extent = boundingBox(mesh).size().maxCoeff();
  if (!(extent > 0.0) || !std::isfinite(extent))
    throw MeshError(model.stlFile.string() + ": the mesh of " + model.name + " has no extent");
  const double scale = 2.0 * model.radius / extent;
  for (Vec3& v : mesh.vertices) v *= scale;
  return mesh;
}

TriangleMesh inflatedAndCentred(TriangleMesh mesh, double dx) {
  if (dx > 0.0) inflate(mesh, inflation * dx);
  const Vec3 center = boundingBox(mesh).center();
  for (Vec3& v : mesh.vertices) v -= center;
  return mesh;
}

}  // namespace

TriangleMesh buildTemplate(const CellModel& model, double dx) {
  TriangleMesh mesh;
  switch (model.construction) {
    case Construction::rbcFromSphere:
      mesh = unitSphere(icosahedron(), model.minNumTriangles);
      for (Vec3& v : mesh.vertices) v = turned(biconcave(turned(v), model.radius));
      break;
    case Construction::ellipsoidFromSphere:
      mesh = unitSphere(octahedron(), model.minNumTriangles);
      for (Vec3& v : mesh.vertices) v = turned(oblate(turned(v), model.radius, model.aspectRatio));
      break;
    case Construction::wbcSphere:
      mesh = unitSphere(icosahedron(), model.minNumTriangles);
      for (Vec3& v : mesh.vertices) v *= model.radius;
      break;
    case Construction::meshFromStl:
      return meshFromStl(scaledStl(model), dx);
  }
  return inflatedAndCentred(std::move(mesh), dx);
}

TriangleMesh meshFromStl(TriangleMesh mesh, double dx) {
  for (Vec3& v : mesh.vertices) v = turned(v);
  return inflatedAndCentred(std::move(mesh), dx);
}

}  // namespace packmesh::hemocell
