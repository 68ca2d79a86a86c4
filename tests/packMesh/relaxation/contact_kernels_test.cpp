// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/contact_kernels.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/relaxation/contact_solver.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"

using namespace packmesh;
using test::NamedShape;

namespace {

struct Configuration {
  RelativeFrame frame;
  float clearance;
};

/// A sampled cell somewhere around the surface of another: deep inside, touching, apart.
Configuration randomConfiguration(const Shape& sampled, const Shape& surface, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Configuration c;
  const double ratio = random() % 4 == 0 ? std::exp2(2.0 * unit(random) - 1.0) : 1.0;
  const Mat3 m = ratio * test::randomRotation(random);
  const double furthest = surface.radius() + ratio * sampled.radius();
  const Vec3 t = (0.1 + unit(random)) * furthest * test::randomDirection(random);
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) c.frame.m[3 * r + k] = float(m(r, k));
    c.frame.t[r] = float(t[r]);
  }
  c.frame.scale = float(ratio);
  c.clearance = random() % 3 == 0 ? 0.25f : 0.02f;
  return c;
}

/// @param mask clusters that are looked at, and afterwards those that are near
ContactSums run(const SampleView& samples, const Configuration& c, const FieldView& field, float margin,
                ClusterMask& mask) {
  ContactSums sums{};
  contactKernel(chosenInstructionSet())(samples, c.frame, field, c.clearance, margin, mask, sums);
  return sums;
}
ContactSums run(const SampleView& samples, const Configuration& c, const FieldView& field) {
  ClusterMask mask = allClusters;
  return run(samples, c, field, 0.0f, mask);
}

Vec3 pointOf(const SampleView& s, int i, const RelativeFrame& f) {
  const double x = s.x[i], y = s.y[i], z = s.z[i];
  Vec3 q;
  for (int r = 0; r < 3; ++r) q[r] = f.m[3 * r] * x + f.m[3 * r + 1] * y + f.m[3 * r + 2] * z + f.t[r];
  return q;
}

/// Distance and unit normal as the kernel defines them, in double precision.
struct Field {
  double distance;
  Vec3 normal;
  double steepness;  ///< |gradient| of the function whose direction is the normal
};

Field closedForm(const FieldView& f, const Vec3& q) {
  const double s = f.a * q.x() * q.x() + f.c * q.z() * q.z(), inner = std::min(s, 1.0), beyond = s - inner;
  double value = 0.0, slope = 0.0;
  for (int k = 5; k >= 0; --k) value = value * inner + f.p[k];
  for (int k = 5; k >= 1; --k) slope = slope * inner + k * f.p[k];
  value += (slope + f.bend * beyond) * beyond;
  slope += 2.0 * f.bend * beyond;
  const double level = q.y() * q.y() - value;
  const Vec3 gradient(-2.0 * slope * f.a * q.x(), 2.0 * q.y(), -2.0 * slope * f.c * q.z());
  const double half = 0.5 * gradient.norm();
  const double curved = level < 0.0 ? f.curvature * level : level;
  const double distance = level / std::max(1e-6, half + std::sqrt(std::max(0.0, half * half - curved)));
  return {distance, gradient.normalized(), gradient.norm()};
}

Field onGrid(const DistanceGrid& grid, const Vec3& q) {
  const Vec3 gradient = grid.sample(q).gradient;
  return {grid.distance(q), gradient.normalized(), grid.spacing * gradient.norm()};
}

/// Distance to the surface itself, not to what the kernel takes for it. Positive outside.
class TrueDistance {
 public:
  explicit TrueDistance(const Shape& shape) {
    if (const auto* p = std::get_if<ProfileSurface>(&shape.field())) {
      // The profile as a fine mesh of revolution, or of an ellipsoid.
      TriangleMesh mesh = test::icosphere(5);
      for (Vec3& v : mesh.vertices) {
        const double s = std::min(1.0, v.x() * v.x() + v.z() * v.z());
        double y2 = 0.0;
        for (int k = 5; k >= 0; --k) y2 = y2 * s + p->p[k];
        v = Vec3(v.x() / std::sqrt(p->a), std::copysign(std::sqrt(std::max(0.0, y2)), v.y()),
                 v.z() / std::sqrt(p->c));
      }
      surface_ = std::make_unique<ClosestPoint>(mesh);
    } else {
      surface_ = std::make_unique<ClosestPoint>(shape.mesh());
    }
  }
  double operator()(const Vec3& p) const { return surface_->signedDistance(p); }

 private:
  std::unique_ptr<ClosestPoint> surface_;
};

const ContactViews& modelOf(const NamedShape& shape) {
  return shape.shape->views();
}

}  // namespace

TEST_CASE("Contacts are the sums over all sample points, with or without culling", "[relaxation][kernel]") {
  std::mt19937 random(2);
  for (const NamedShape& sampled : test::allShapes())
    for (const NamedShape& surface : test::allShapes()) {
      CAPTURE(sampled.name, surface.name);
      const ContactViews &a = modelOf(sampled), &b = modelOf(surface);
      const auto* grid = std::get_if<DistanceGrid>(&surface.shape->field());
      for (int n = 0; n < 60; ++n) {
        const Configuration c = randomConfiguration(*sampled.shape, *surface.shape, random);
        const ContactSums sums = run(a.samples, c, b.field);

        // Floats of a few µm err by some 1e-6; distances by as much over the slope of the field.
        constexpr double rounding = 3e-5;
        double weight = 0.0, deepest = 0.0, weightError = 0.0, normalError = 0.0, gradient = 0.0,
               steepest = 0.0;
        Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
        for (int i = 0; i < a.samples.clusters * SamplePoints::width; ++i) {
          const Vec3 q = pointOf(a.samples, i, c.frame);
          const Field at = grid ? onGrid(*grid, q) : closedForm(b.field, q);
          const double depth = c.clearance - at.distance;
          if (depth > -rounding) weightError += rounding;
          if (depth <= 0.0) continue;
          weight += depth;
          point += depth * q;
          normal += depth * at.steepness * at.normal;
          gradient += depth * at.steepness;
          steepest = std::max(steepest, at.steepness);
          // The gradient of an interpolant jumps from cell to cell of the grid.
          normalError += depth * (grid ? 0.02 : 1e-4);
          deepest = std::max(deepest, depth);
        }
        CAPTURE(n, weight, sums.weight, sums.nearest);
        const double reach = surface.shape->radius() + 1.0;
        REQUIRE(std::abs(sums.weight - weight) <= weightError);
        REQUIRE(std::abs(sums.deepest - deepest) <= rounding);
        for (int k = 0; k < 3; ++k) {
          REQUIRE(std::abs(sums.point[k] - point[k]) <= reach * weightError);
          REQUIRE(std::abs(sums.normal[k] - normal[k]) <= steepest * weightError + normalError);
        }
        REQUIRE(std::abs(sums.gradient - gradient) <= steepest * weightError + normalError);
      }
    }
}

TEST_CASE("Penetrations are measured to the surface itself", "[relaxation][kernel]") {
  std::mt19937 random(3);
  for (const NamedShape& surface : test::allShapes()) {
    CAPTURE(surface.name);
    const TrueDistance distance(*surface.shape);
    const ContactViews& model = modelOf(surface);
    const auto* grid = std::get_if<DistanceGrid>(&surface.shape->field());
    // One sample point at a time, near the surface and beyond.
    std::uniform_real_distribution<double> offset(-0.1, 1.6);
    const TriangleMesh& mesh = surface.shape->mesh();
    for (int n = 0; n < 4000; ++n) {
      const Vec3 q =
          mesh.vertices[random() % mesh.vertices.size()] + offset(random) * test::randomDirection(random);
      Configuration c{{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}, 1.0f}, n % 2 == 0 ? 0.02f : 0.25f};
      const ContactSums sums = run(viewOf(test::oneCluster({q})), c, model.field);
      const double expected = distance(q), found = c.clearance - sums.deepest;
      CAPTURE(q, expected, sums.weight, sums.nearest);
      // Closed forms are made for small distances, grids for all. Rims are the worst, and there they
      // had better be too small.
      const double tooLarge = grid ? grid->interpolationError() : n % 2 == 0 ? 0.004 : 0.04;
      const double tooSmall = grid ? grid->interpolationError() : n % 2 == 0 ? 0.004 : 0.10;
      if (expected < c.clearance - tooLarge) REQUIRE(sums.weight > 0.0f);
      if (expected > c.clearance + tooSmall) REQUIRE(sums.weight == 0.0f);
      if (sums.weight > 0.0f && expected > -0.05) {
        REQUIRE(found < expected + tooLarge);
        REQUIRE(found > expected - tooSmall);
      }
    }
  }
}

TEST_CASE("Without a contact, no sample point is closer than the bound given by the kernel",
          "[relaxation][kernel]") {
  std::mt19937 random(4);
  int checked = 0;
  for (const NamedShape& surface : test::allShapes()) {
    const TrueDistance distance(*surface.shape);
    const auto* grid = std::get_if<DistanceGrid>(&surface.shape->field());
    const double error = grid ? grid->interpolationError() : 2e-3;
    for (const NamedShape& sampled : test::allShapes()) {
      CAPTURE(sampled.name, surface.name);
      const ContactViews &a = modelOf(sampled), &b = modelOf(surface);
      for (int n = 0; n < 10; ++n) {
        const Configuration c = randomConfiguration(*sampled.shape, *surface.shape, random);
        const ContactSums sums = run(a.samples, c, b.field);
        if (sums.weight > 0.0f) continue;
        double nearest = std::numeric_limits<double>::infinity();
        for (int i = 0; i < a.samples.clusters * SamplePoints::width; ++i)
          nearest = std::min(nearest, distance(pointOf(a.samples, i, c.frame)));
        ++checked;
        CAPTURE(n, c.clearance, nearest);
        REQUIRE(sums.nearest <= nearest + error);
        REQUIRE(sums.nearest >= 0.5f * c.clearance);
      }
    }
  }
  REQUIRE(checked > 200);
}

TEST_CASE("Clusters outside the mask have no contact before the cells have moved by the margin",
          "[relaxation][kernel]") {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int touching = 0, spared = 0;
  for (const NamedShape& sampled : test::allShapes())
    for (const NamedShape& surface : test::allShapes()) {
      CAPTURE(sampled.name, surface.name);
      const ContactViews &a = modelOf(sampled), &b = modelOf(surface);
      // Sampled distances err, so that a point may come nearer by more than it moves.
      const auto* grid = std::get_if<DistanceGrid>(&surface.shape->field());
      for (int n = 0; n < 40; ++n) {
        Configuration c = randomConfiguration(*sampled.shape, *surface.shape, random);
        const float margin = n % 2 == 0 ? 0.1f : 0.02f;
        ClusterMask mask = allClusters;
        run(a.samples, c, b.field, margin, mask);
        spared += __builtin_popcountll(mask) < std::min(64, a.samples.clusters) / 2;
        // Moved by less than the margin, turned by as much.
        const Vec3 step = 0.5 * margin * test::randomDirection(random);
        const double angle = 0.45 * margin / (c.frame.scale * sampled.shape->radius());
        const Mat3 turn = Quaternion::around(test::randomDirection(random), angle).toRotationMatrix();
        Mat3 m;
        for (int r = 0; r < 3; ++r)
          for (int k = 0; k < 3; ++k) m(r, k) = c.frame.m[3 * r + k];
        m = turn * m;
        for (int r = 0; r < 3; ++r) {
          for (int k = 0; k < 3; ++k) c.frame.m[3 * r + k] = float(m(r, k));
          c.frame.t[r] += float(step[r]);
        }
        const ContactSums all = run(a.samples, c, b.field);
        const ContactSums some = run(a.samples, c, b.field, 0.0f, mask);
        CAPTURE(n, margin, all.deepest);
        if (grid) {
          REQUIRE(std::abs(some.deepest - all.deepest) < 0.25 * margin);
        } else {
          REQUIRE(some.weight == Approx(all.weight).margin(1e-4));
          REQUIRE(some.deepest == all.deepest);
        }
        touching += all.weight > 0.0f;
      }
    }
  REQUIRE(touching > 300);
  REQUIRE(spared > 300);
}

TEST_CASE("The padding of clusters has no effect", "[relaxation][kernel]") {
  std::mt19937 random(5);
  const NamedShape surface{"red cell", test::redCellShape()};
  const ContactViews& b = modelOf(surface);
  SamplePoints samples = surface.shape->samples();
  REQUIRE(samples.clusters % SamplePoints::width != 0);
  for (int n = 0; n < 300; ++n) {
    const Configuration c = randomConfiguration(*surface.shape, *surface.shape, random);
    const ContactSums expected = run(b.samples, c, b.field);
    for (std::size_t k = samples.clusters; k < samples.centerX.size(); ++k) {
      samples.centerX[k] = samples.centerY[k] = samples.centerZ[k] = 0.0f;
      samples.radius[k] = n % 2 == 0 ? 1e3f : -1e3f;
    }
    const ContactSums found = run(viewOf(samples), c, b.field);
    CAPTURE(n);
    if (expected.weight > 0.0f) REQUIRE(std::memcmp(&found, &expected, sizeof found) == 0);
    // Nothing is culled away by what is not there, and a bound may only become more careful.
    REQUIRE(found.weight == expected.weight);
    REQUIRE(found.nearest <= expected.nearest);
  }
}
