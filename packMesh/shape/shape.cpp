// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "packMesh/core/box.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/field/distance_grid.h"
#include "packMesh/shape/field_view.h"

namespace packmesh {
namespace {

/// Mean of the support function over the sphere (directions on a spiral): the effective size for culling.
double meanSupport(const SupportBound& bound) {
  constexpr int directions = 200;
  constexpr double goldenAngle = 2.399963229728653;
  double sum = 0.0;
  for (int i = 0; i < directions; ++i) {
    const double y = (2.0 * i + 1.0) / directions - 1.0, r = std::sqrt(1.0 - y * y), angle = goldenAngle * i;
    sum += bound.support({r * std::cos(angle), y, r * std::sin(angle)});
  }
  return sum / directions;
}

}  // namespace

SupportBound boundSupport(const TriangleMesh& mesh, int rings) {
  // Keeps quotients finite for flat meshes.
  Vec3 extent = Vec3::Constant(1e-12);
  double largestRho = 1e-12;
  for (const Vec3& v : mesh.vertices) {
    extent = extent.cwiseMax(v.cwiseAbs());
    largestRho = std::max(largestRho, std::hypot(v.x(), v.z()));
  }

  SupportBound best;
  double bestSize = std::numeric_limits<double>::infinity();
  for (int step = 0; step < rings; ++step) {
    poll();
    SupportBound bound;
    bound.ring = largestRho * step / rings;
    const double tube = largestRho - bound.ring;
    bound.semiAxes = step == 0 ? extent : Vec3(tube, extent.y(), tube);
    // Enlarge the ellipsoid until every vertex lies in the Minkowski sum: v is in it if and only if v minus
    // its nearest point of the disc is in the ellipsoid.
    double blowUp = 1e-12;
    for (const Vec3& v : mesh.vertices) {
      const double rho = std::hypot(v.x(), v.z());
      const double keep = rho > bound.ring ? (rho - bound.ring) / rho : 0.0;
      blowUp = std::max(blowUp, Vec3(keep * v.x(), v.y(), keep * v.z()).cwiseQuotient(bound.semiAxes).norm());
    }
    bound.semiAxes *= blowUp * (1.0 + 1e-12);  // covers rounding
    const double size = meanSupport(bound);
    if (size < bestSize) {
      bestSize = size;
      best = bound;
    }
  }
  return best;
}

namespace {

int divisions(const Vec3& a, const Vec3& b, double spacing) {
  return std::max(1, static_cast<int>(std::ceil((b - a).norm() / spacing)));
}

/// Pre: closed and consistently oriented, so that each edge is traversed once in either direction
std::vector<Vec3> pointsOn(const TriangleMesh& mesh, double spacing) {
  std::vector<Vec3> points = mesh.vertices;
  for (const Triangle& t : mesh.triangles) {
    int most = 1;
    for (int k = 0; k < 3; ++k) {
      const int a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
      const int n = divisions(mesh.vertices[a], mesh.vertices[b], spacing);
      most = std::max(most, n);
      if (t[k] != a) continue;
      for (int i = 1; i < n; ++i)
        points.push_back(mesh.vertices[a] + (mesh.vertices[b] - mesh.vertices[a]) * (double(i) / n));
    }
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    for (int i = 1; i < most; ++i)
      for (int j = 1; i + j < most; ++j)
        points.push_back(a + (b - a) * (double(i) / most) + (c - a) * (double(j) / most));
  }
  return points;
}

/// Divides [first, last) along its longest axis into the fewest clusters that can hold it, with sizes that
/// differ by at most one point, so that padding gives no point much more weight than others.
void cluster(std::vector<Vec3>::iterator first, std::vector<Vec3>::iterator last, SamplePoints& out) {
  const auto count = last - first;
  poll();
  if (count <= SamplePoints::width) {
    for (int k = 0; k < SamplePoints::width; ++k) {
      const Vec3& p = first[k % count];
      out.x.push_back(static_cast<float>(p.x()));
      out.y.push_back(static_cast<float>(p.y()));
      out.z.push_back(static_cast<float>(p.z()));
    }
    Box box;
    for (auto p = first; p != last; ++p) box.add(*p);
    const Vec3 center = box.center().cast<float>().cast<double>();
    double radius = 0.0;
    for (auto p = first; p != last; ++p)
      radius = std::max(radius, (p->cast<float>().cast<double>() - center).norm());
    out.centerX.push_back(static_cast<float>(center.x()));
    out.centerY.push_back(static_cast<float>(center.y()));
    out.centerZ.push_back(static_cast<float>(center.z()));
    out.radius.push_back(static_cast<float>(radius * (1.0 + 1e-6)));  // covers rounding to float
    ++out.clusters;
    return;
  }
  Box box;
  for (auto p = first; p != last; ++p) box.add(*p);
  int axis = 0;
  box.size().maxCoeff(&axis);
  const auto clusters = (count + SamplePoints::width - 1) / SamplePoints::width;
  const auto middle = first + count * (clusters / 2) / clusters;
  const auto before = [axis](const Vec3& p, const Vec3& q) {
    return std::make_tuple(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) <
           std::make_tuple(q[axis], q[(axis + 1) % 3], q[(axis + 2) % 3]);
  };
  std::sort(first, last, before);
  cluster(first, middle, out);
  cluster(middle, last, out);
}

SamplePoints clustered(std::vector<Vec3> points) {
  SamplePoints out;
  if (points.empty()) return out;
  cluster(points.begin(), points.end(), out);
  while (out.centerX.size() % SamplePoints::width != 0) {
    out.centerX.push_back(out.centerX.back());
    out.centerY.push_back(out.centerY.back());
    out.centerZ.push_back(out.centerZ.back());
    out.radius.push_back(out.radius.back());
  }
  return out;
}

}  // namespace

SamplePoints sampleSurface(const TriangleMesh& mesh, double spacing) {
  return clustered(pointsOn(mesh, spacing));
}

namespace {

/// Farthest-point sampling (Gonzalez 1985): the next point is always that furthest from all chosen ones. A
/// tree over the points limits the work to the surroundings of the chosen point.
class FarthestPoints {
 public:
  explicit FarthestPoints(const std::vector<Vec3>& points)
      : points_(points),
        squared_(points.size(), std::numeric_limits<double>::infinity()),
        order_(points.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    while (leaves_ * leafSize < points.size()) leaves_ *= 2;
    nodes_.resize(2 * leaves_);
    build(1, 0, points.size());
  }

  /// The first of the points furthest from all chosen ones.
  std::size_t furthest() const { return nodes_[1].furthest; }
  void choose(std::size_t point) { update(1, points_[point]); }

 private:
  static constexpr std::size_t leafSize = 8;
  struct Node {
    Box box;
    std::size_t begin = 0, end = 0;  ///< in order_
    std::size_t furthest = 0;        ///< point
    double squared = -1.0;  ///< its squared distance from the nearest chosen point [µm²]; no points: -1
  };

  void build(std::size_t n, std::size_t begin, std::size_t end) {
    Node& node = nodes_[n];
    node.begin = begin;
    node.end = end;
    for (std::size_t i = begin; i < end; ++i) node.box.add(points_[order_[i]]);
    if (n < leaves_) {
      int axis = 0;
      if (begin < end) node.box.size().maxCoeff(&axis);
      const std::size_t middle = begin + (end - begin) / 2;
      std::nth_element(
          order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](auto i, auto j) {
            return points_[i][axis] != points_[j][axis] ? points_[i][axis] < points_[j][axis] : i < j;
          });
      build(2 * n, begin, middle);
      build(2 * n + 1, middle, end);
    }
    summarise(n);
  }

  void summarise(std::size_t n) {
    Node& node = nodes_[n];
    node.squared = -1.0;
    const auto consider = [&](double squared, std::size_t point) {
      if (squared < node.squared || (squared == node.squared && point > node.furthest)) return;
      node.squared = squared;
      node.furthest = point;
    };
    if (n < leaves_)
      for (const std::size_t child : {2 * n, 2 * n + 1})
        consider(nodes_[child].squared, nodes_[child].furthest);
    else
      for (std::size_t i = node.begin; i < node.end; ++i) consider(squared_[order_[i]], order_[i]);
  }

  void update(std::size_t n, const Vec3& p) {
    constexpr double rounding = 1.0 + 1e-12;  // of a few operations
    const Node& node = nodes_[n];
    if (node.begin == node.end || node.box.squaredDistance(p) > rounding * node.squared) return;
    if (n < leaves_) {
      update(2 * n, p);
      update(2 * n + 1, p);
    } else {
      for (std::size_t i = node.begin; i < node.end; ++i) {
        double& squared = squared_[order_[i]];
        squared = std::min(squared, (points_[order_[i]] - p).squaredNorm());
      }
    }
    summarise(n);
  }

  const std::vector<Vec3>& points_;
  std::vector<double> squared_;  ///< distance of each point from the nearest chosen one [µm²]
  std::vector<std::size_t> order_;
  std::size_t leaves_ = 1;
  std::vector<Node> nodes_;  ///< a heap; the last `leaves_` are the leaves
};

}  // namespace

SamplePoints sampleCoarsely(const TriangleMesh& mesh) {
  const std::size_t wanted = std::min<std::size_t>(
      mesh.vertices.size(), std::max<std::size_t>(2 * SamplePoints::width, mesh.vertices.size() / 4));
  FarthestPoints vertices(mesh.vertices);
  std::vector<Vec3> chosen;
  std::size_t next = 0;
  while (chosen.size() < wanted) {
    pollAt(chosen.size());
    chosen.push_back(mesh.vertices[next]);
    vertices.choose(next);
    next = vertices.furthest();
  }
  return clustered(std::move(chosen));
}

std::vector<Vec3> spreadPoints(const TriangleMesh& mesh, int count) {
  const std::vector<Vec3>& all = mesh.vertices;
  std::vector<double> distance(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) distance[i] = all[i].squaredNorm();
  std::vector<Vec3> points;
  while (int(points.size()) < std::min<int>(count, int(all.size()))) {
    const auto next = std::max_element(distance.begin(), distance.end()) - distance.begin();
    points.push_back(all[next]);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double toNext = (all[i] - points.back()).squaredNorm();
      distance[i] = points.size() == 1 ? toNext : std::min(distance[i], toNext);
    }
  }
  return points;
}

SampleView viewOf(const SamplePoints& s) {
  int shift = 0;
  while (s.clusters > 64 << shift) ++shift;
  return {s.clusters,       shift,
          s.x.data(),       s.y.data(),
          s.z.data(),       s.centerX.data(),
          s.centerY.data(), s.centerZ.data(),
          s.radius.data()};
}

namespace {

/// Largest distance between samples on a cell's surface, as a fraction of its bounding radius and in µm: the
/// 642 vertices of HemoCell's red cell are just fine enough; its 66-vertex platelet is refined.
constexpr double sampleSpacingFraction = 0.3;
constexpr double largestSampleSpacing = 0.85;
/// Finest spacing, as a fraction of the bounding radius (about 10^5 samples). Blood cells do not need it; a
/// cell in the wrong unit of length would.
constexpr double finestSpacingFraction = 0.02;

/// Spacing of the distance grid of a general mesh, as a fraction of its bounding radius.
constexpr double gridSpacingFraction = 1.0 / 40.0;

/// The grid covers this many spacings around the mesh; as many inside its distances are exact.
constexpr double marginOfGrid = 8.0;

double halfThicknessOf(const std::variant<ProfileSurface, DistanceGrid>& field) {
  if (const auto* profile = std::get_if<ProfileSurface>(&field)) return profile->halfThickness();
  const DistanceGrid& grid = std::get<DistanceGrid>(field);
  const double deepest = -*std::min_element(grid.value.begin(), grid.value.end());
  return std::max(deepest, 0.5 * grid.spacing);  // thin parts fit between the nodes of a grid
}

double boundingRadius(const TriangleMesh& mesh) {
  double radius = 0.0;
  for (const Vec3& v : mesh.vertices) radius = std::max(radius, v.norm());
  return radius;
}

/// Spacing of the distance grid of a deformed cell, as a fraction of the edge of a cube of its volume:
/// coarser, since each cell has a grid of its own. The certificate finds what relaxation does not see.
constexpr double roughSpacingFraction = 1.0 / 13.0;

/// Rings that are tried for the convex bound of a deformed cell.
constexpr int fewRings = 5;

double reachOf(const Sphere& sphere) {
  return sphere.center.norm() + sphere.radius;
}

DistanceGrid gridOf(const MeshHierarchy& hierarchy, const Threads& threads) {
  const TriangleMesh& mesh = hierarchy.mesh();
  const double spacing = gridSpacingFraction * boundingRadius(mesh), margin = marginOfGrid * spacing;
  return sampleDistance(hierarchy, boundingBox(mesh).grownBy(margin), spacing, margin, threads);
}

std::variant<ProfileSurface, DistanceGrid> scaledBy(double factor,
                                                    std::variant<ProfileSurface, DistanceGrid> field) {
  if (const auto* profile = std::get_if<ProfileSurface>(&field)) return profile->scaledBy(factor);
  DistanceGrid& grid = std::get<DistanceGrid>(field);
  grid.origin *= factor;
  grid.spacing *= factor;
  for (float& value : grid.value) value *= float(factor);
  return field;
}

/// @param bound, box around the surface
FieldView viewOf(const std::variant<ProfileSurface, DistanceGrid>& field, const SupportBound& bound,
                 const Box& box) {
  FieldView view{};
  if (const auto* profile = std::get_if<ProfileSurface>(&field)) {
    view.onGrid = false;
    for (int k = 0; k < 6; ++k) view.p[k] = static_cast<float>(profile->p[k]);
    view.a = static_cast<float>(profile->a);
    view.c = static_cast<float>(profile->c);
    view.bend = static_cast<float>(profile->bendBeyondRim());
    view.curvature = static_cast<float>(profile->curvatureInside());
  } else {
    const auto& grid = std::get<DistanceGrid>(field);
    view.onGrid = true;
    view.value = grid.value.data();
    view.nodesPerLength = static_cast<float>(1.0 / grid.spacing);
    for (int k = 0; k < 3; ++k) {
      view.origin[k] = static_cast<float>(grid.origin[k]);
      view.nodes[k] = grid.nodes[k];
    }
  }
  view.ring = static_cast<float>(bound.ring);
  view.thickness = static_cast<float>(bound.semiAxes.maxCoeff());
  for (int k = 0; k < 3; ++k)
    view.extent[k] = static_cast<float>(std::max(std::abs(box.lo[k]), std::abs(box.hi[k])));
  return view;
}

}  // namespace

double ProfileSurface::slopeAtRim() const {
  double slope = 0.0;
  for (int k = 1; k < 6; ++k) slope += k * p[k];
  return slope;
}

double ProfileSurface::bendBeyondRim() const {
  const double rim2 = 1.0 / std::min(a, c);
  return std::min(0.0, -0.25 * (slopeAtRim() + rim2));
}

double ProfileSurface::curvatureInside() const {
  return std::max(1.0, -slopeAtRim() * std::max(a, c));
}

double ProfileSurface::halfThickness() const {
  constexpr int steps = 200;
  double highest = 0.0;
  for (int i = 0; i <= steps; ++i) {
    double height = 0.0;
    for (int k = 5; k >= 0; --k) height = height * i / steps + p[k];
    highest = std::max(highest, height);
  }
  return std::sqrt(highest / curvatureInside());
}

ProfileSurface ProfileSurface::scaledBy(double factor) const {
  ProfileSurface scaled = *this;
  for (double& coefficient : scaled.p) coefficient *= factor * factor;
  scaled.a /= factor * factor;
  scaled.c /= factor * factor;
  return scaled;
}

ProfileSurface ellipsoidProfile(double rx, double ry, double rz) {
  ProfileSurface surface;
  surface.p = {ry * ry, -ry * ry, 0.0, 0.0, 0.0, 0.0};
  surface.a = 1.0 / (rx * rx);
  surface.c = 1.0 / (rz * rz);
  return surface;
}

double Shape::sampleSpacing() const {
  return std::max(std::min(largestSampleSpacing, sampleSpacingFraction * radius_),
                  finestSpacingFraction * radius_);
}

Shape::Shape(MeshHierarchy&& hierarchy, Field field)
    : hierarchy_(std::move(hierarchy)),
      volume_(signedVolume(mesh())),
      radius_(boundingRadius(mesh())),
      halfThickness_(halfThicknessOf(field)),
      reach_(reachOf(boundingSphere(*hierarchy_, Placement()))),
      sphere_{hierarchy_->tree().center, hierarchy_->tree().radius},
      bound_(boundSupport(mesh())),
      contacts_(contactsWith(std::move(field))) {}

Shape::Shape(MeshHierarchy&& hierarchy, const Threads& threads)
    : Shape(std::move(hierarchy), Field(gridOf(hierarchy, threads))) {}

Shape::Shape(const TriangleMesh& mesh, const ProfileSurface& surface)
    : Shape(MeshHierarchy(mesh), Field(surface)) {}

Shape::Shape(const TriangleMesh& mesh, const Threads& threads) : Shape(MeshHierarchy(mesh), threads) {}

Shape::Shape(const Shape& other, double factor)
    : Shape(MeshHierarchy({scaledBy(factor, other.mesh().vertices), other.mesh().triangles}),
            scaledBy(factor, other.field())) {}

Shape::Shape(std::vector<Vec3> vertices, std::shared_ptr<const Shape> undeformed)
    : undeformed_(std::move(undeformed)),
      pending_(std::make_unique<Pending>()),
      halfThickness_(undeformed_->halfThickness()) {
  pending_->mesh =
      std::make_shared<const TriangleMesh>(TriangleMesh{std::move(vertices), undeformed_->mesh().triangles});
  pending_->hierarchy.emplace();
  volume_ = signedVolume(mesh());
  radius_ = boundingRadius(mesh());
  sphere_ = {boundingBox(mesh()).center(), 0.0};
  for (const Vec3& v : mesh().vertices)
    sphere_.radius = std::max(sphere_.radius, (v - sphere_.center).norm());
  reach_ = reachOf(sphere_) + tolerance::culling;
  bound_ = boundSupport(mesh(), fewRings);
}

/// Pre: the mesh and its bound are there
Shape::Contacts Shape::contactsWith(Field field) const {
  Contacts made{sampleSurface(mesh(), sampleSpacing()), sampleCoarsely(mesh()), std::move(field), {}};
  made.views = {viewOf(made.samples), viewOf(made.coarseSamples),
                viewOf(made.field, bound_, boundingBox(mesh()))};
  return made;
}

const MeshHierarchy& Shape::madeHierarchy() const {
  std::call_once(*pending_->hierarchy, [&] { hierarchy_.emplace(pending_->mesh, undeformed_->hierarchy()); });
  return *hierarchy_;
}

void Shape::forgetHierarchy() const {
  if (!pending_ || !hierarchy_) return;
  hierarchy_.reset();
  pending_->hierarchy.emplace();
}

const Shape::Contacts& Shape::madeContacts() const {
  std::call_once(pending_->contacts, [&] {
    const double spacing = roughSpacingFraction * std::cbrt(volume_);
    contacts_.emplace(contactsWith(sampleRoughly(mesh(), boundingBox(mesh()).grownBy(spacing), spacing)));
  });
  return *contacts_;
}

}  // namespace packmesh
