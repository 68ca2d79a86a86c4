// SPDX-License-Identifier: AGPL-3.0-or-later
// Shapes from templates: closed forms around HemoCell's meshes, ellipsoids, other mesh files.
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/lattice.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"

namespace packmesh::hemocell {
namespace {

/// Number of triangles of an ellipsoid not defined by a HemoCell case: HemoCell's own value for cells of that
/// size.
constexpr int ellipsoidTriangles = 600;

double valueOf(const std::array<double, 6>& p, double s) {
  double value = 0.0;
  for (int k = 5; k >= 0; --k) value = value * s + p[k];
  return value;
}

double slopeOf(const std::array<double, 6>& p, double s) {
  double slope = 0.0;
  for (int k = 5; k >= 1; --k) slope = slope * s + k * p[k];
  return slope;
}

/// |grad(y² - P(s))| at v.
double steepness(const ProfileSurface& surface, const Vec3& v) {
  const double s = surface.a * (v.x() * v.x() + v.z() * v.z());
  return 2.0 * std::hypot(v.y(), slopeOf(surface.p, s) * std::sqrt(surface.a * s));
}

/// Fits y² = P(s) with P(1) = 0 to the vertices of an inflated red cell so that no vertex is outside.
///
/// Without inflation, P(s) = r²(1-s)(C0 + C2 s + C4 s²)² with s = (x² + z²)/r². The inflated surface is not a
/// polynomial, but a polynomial of the same degree agrees with it to a few 1e-5 µm. The smallest change of
/// coefficients is computed, so that a mesh with few vertices does not leave coefficients undetermined.
ProfileSurface fitProfile(const TriangleMesh& mesh) {
  double radius2 = 0.0;
  for (const Vec3& v : mesh.vertices) radius2 = std::max(radius2, v.x() * v.x() + v.z() * v.z());

  const std::array<double, 5> flat = {biconcaveC0 * biconcaveC0, 2.0 * biconcaveC0 * biconcaveC2,
                                      biconcaveC2 * biconcaveC2 + 2.0 * biconcaveC0 * biconcaveC4,
                                      2.0 * biconcaveC2 * biconcaveC4, biconcaveC4 * biconcaveC4};
  ProfileSurface surface;
  double margin = 0.0;  // distance outside the vertices at which the fit aims [µm]
  const Eigen::Index count = static_cast<Eigen::Index>(mesh.vertices.size());
  Eigen::Matrix<double, Eigen::Dynamic, 5> rows(count, 5);
  Eigen::VectorXd aims(count);
  constexpr int rounds = 4;
  for (int round = 0; round < rounds; ++round) {
    const double rim = std::sqrt(radius2) + margin;
    surface.a = surface.c = 1.0 / (rim * rim);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Vec3& v = mesh.vertices[i];
      const double s = surface.a * (v.x() * v.x() + v.z() * v.z());
      // Weighted so that residuals are distances; equal weights in the first round.
      const double steep = round == 0 ? 1.0 : steepness(surface, v);
      double power = (1.0 - s) / steep;
      aims[i] = v.y() * v.y() / steep + margin;
      for (int k = 0; k < 5; ++k, power *= s) {
        rows(i, k) = power;
        aims[i] -= rim * rim * flat[k] * power;
      }
    }
    Eigen::Matrix<double, 5, 1> q = rows.completeOrthogonalDecomposition().solve(aims);
    for (int k = 0; k < 5; ++k) q[k] += rim * rim * flat[k];
    surface.p = {q[0], q[1] - q[0], q[2] - q[1], q[3] - q[2], q[4] - q[3], -q[4]};
    double furthest = -1.0;
    for (const Vec3& v : mesh.vertices) {
      const double s = surface.a * (v.x() * v.x() + v.z() * v.z());
      furthest = std::max(furthest, (v.y() * v.y() - valueOf(surface.p, s)) / steepness(surface, v));
    }
    if (round > 0) margin = std::max(0.0, margin + furthest);
  }
  return surface;
}

/// The smallest multiple of the ellipsoid with these semi-axes that contains all vertices.
ProfileSurface ellipsoidAround(const TriangleMesh& mesh, const Vec3& semiAxes) {
  double scale2 = 0.0;
  for (const Vec3& v : mesh.vertices) scale2 = std::max(scale2, v.cwiseQuotient(semiAxes).squaredNorm());
  const Vec3 axes = std::sqrt(scale2) * semiAxes;
  return ellipsoidProfile(axes.x(), axes.y(), axes.z());
}

/// Repairs the mesh of a file; repairs and errors are reported in coordinates of the file.
/// @param holes if not null, receives those that are nearly flat, which are closed then
TriangleMesh repaired(TriangleMesh mesh, const std::filesystem::path& file,
                      std::vector<std::string>& warnings, std::vector<CappedOpening>* holes = nullptr) {
  const std::vector<std::string> repairs =
      repairClosed(mesh, file.string(), holes, tolerance::flatHoleFraction);
  warnings.insert(warnings.end(), repairs.begin(), repairs.end());
  if (holes && !holes->empty())
    warnings.push_back(fmt::format("{}: closed {} hole{} in the surface; HemoCell reads the file as it is",
                                   file.string(), holes->size(), holes->size() == 1 ? "" : "s"));
  return mesh;
}

/// HemoCell builds its template from the unrepaired file; the mesh used for packing is repaired afterwards.
std::shared_ptr<const Shape> shapeFromStl(TriangleMesh built, const std::string& name, const Threads& threads,
                                          std::vector<CappedOpening>* holes = nullptr) {
  repairClosed(built, name, holes, tolerance::flatHoleFraction);
  return std::make_shared<const Shape>(built, threads);
}

}  // namespace

std::optional<ProfileSurface> profileOf(const CellModel& model, const TriangleMesh& mesh) {
  switch (model.construction) {
    case Construction::rbcFromSphere:
      return fitProfile(mesh);
    case Construction::ellipsoidFromSphere:  // its vertices remain on the axes after inflation and centring
      return ellipsoidAround(mesh, 0.5 * boundingBox(mesh).size());
    case Construction::wbcSphere:
      return ellipsoidAround(mesh, Vec3::Ones());
    case Construction::meshFromStl:
      break;
  }
  return {};
}

std::shared_ptr<const Shape> makeShape(const CellModel& model, double dx, std::vector<std::string>* warnings,
                                       const Threads& threads) {
  if (model.construction == Construction::meshFromStl) {
    std::vector<std::string> ignored;
    repaired(meshFrom(model.stlFile), model.stlFile, warnings ? *warnings : ignored);
    return shapeFromStl(buildTemplate(model, dx), model.stlFile.string(), threads);
  }
  TriangleMesh mesh = buildTemplate(model, dx);
  const ProfileSurface surface = *profileOf(model, mesh);
  return std::make_shared<const Shape>(std::move(mesh), surface);
}

std::shared_ptr<const Shape> makeShapeOfBuilt(const TriangleMesh& mesh, const std::string& name, double dx,
                                              const Threads& threads) {
  const auto isBuilt = [&](const TriangleMesh& other) {
    constexpr double rounding = 1e-7;  // of constructions that agree, as buildTemplate() says [µm]
    bool same = mesh.vertices.size() == other.vertices.size() && mesh.triangles == other.triangles;
    for (std::size_t i = 0; same && i < mesh.vertices.size(); ++i)
      same = (mesh.vertices[i] - other.vertices[i]).cwiseAbs().maxCoeff() < rounding;
    return same;
  };
  for (const Construction construction : {Construction::rbcFromSphere, Construction::ellipsoidFromSphere,
                                          Construction::wbcSphere, Construction::meshFromStl}) {
    try {
      const CellModel model = readCellXml(name + ".xml", name, construction);
      if (isBuilt(buildTemplate(model, dx))) return makeShape(model, dx, nullptr, threads);
    } catch (const InputError&) {
      continue;  // its XML is not that of this construction
    }
  }
  TriangleMesh own = mesh;
  repairClosed(own, "the template of " + name);
  return std::make_shared<const Shape>(own, threads);
}

std::shared_ptr<const Shape> makeEllipsoid(double e1, double e2, double e3) {
  const Vec3 axes(e1, e2, e3);
  if (!axes.allFinite() || axes.minCoeff() <= 0.0)
    throw InputError(
        fmt::format("ellipsoid axes {} {} {}: expected three positive lengths in µm", e1, e2, e3));
  CellModel sphere;
  sphere.construction = Construction::wbcSphere;
  sphere.radius = 1.0;
  sphere.minNumTriangles = ellipsoidTriangles;
  TriangleMesh mesh = buildTemplate(sphere, 0.0);
  for (Vec3& v : mesh.vertices) v = 0.5 * axes.cwiseProduct(v.normalized());
  const ProfileSurface surface = ellipsoidAround(mesh, 0.5 * axes);
  return std::make_shared<const Shape>(std::move(mesh), surface);
}

std::shared_ptr<const Shape> makeShapeFromFile(const Source& file, double scale, MeshFrame frame, double dx,
                                               std::vector<std::string>& warnings, const Threads& threads) {
  if (!std::isfinite(scale) || scale <= 0.0)
    throw InputError(
        fmt::format("{}: scale {}: expected the file's unit of length in µm", file.string(), scale));
  TriangleMesh asRead = meshFrom(file, &warnings);
  std::vector<CappedOpening> holes;
  TriangleMesh mesh = repaired(asRead, file.file, warnings, &holes);
  const double extent = scale * boundingBox(mesh).size().maxCoeff();
  const std::string hint = unitHint(extent, scale, smallestCell, largestCell);
  if (!hint.empty())
    warnings.push_back(fmt::format("{}: with the factor {:.6g} the cell is {:.3g} µm long{}", file.string(),
                                   scale, extent, hint));
  if (extent > specs::largestLength)
    throw InputError(
        fmt::format("{}: with the factor {:.6g} the cell is {:.3g} µm long, at most {:.0f} µm are "
                    "possible; is the unit right?{}",
                    file.string(), scale, extent, specs::largestLength, hint));
  if (frame == MeshFrame::hemocell) {
    for (Vec3& v : asRead.vertices) v *= scale;
    try {
      return shapeFromStl(meshFromStl(std::move(asRead), dx), file.string(), threads, &holes);
    } catch (const MeshError& error) {  // inflation deforms so small a cell
      throw MeshError(error.what() + hint);
    }
  }
  const Vec3 center = boundingBox(mesh).center();
  for (Vec3& v : mesh.vertices) v = scale * (v - center);
  return std::make_shared<const Shape>(mesh, threads);
}

// The template meshes of HemoCell 2.7, vertex by vertex. Initial polyhedra, order of subdivision and maps are
// those of HemoCell (and of the Palabos sphere it starts from); they matter because all later results for a
// placed cell refer to these vertices.

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
