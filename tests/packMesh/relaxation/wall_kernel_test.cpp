// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/contact_kernels.h"

#include "packMesh/relaxation/contact_solver.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"
#include "tests/support/walls.h"

using namespace packmesh;
using test::NamedContainer;

namespace {

Box regionOf(const Container& container) {
  return container.bounds().grownBy(9.0);
}

/// Anywhere a cell can be where the wall is near.
Body randomBody(const NamedContainer& c, double reach, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const Box box = c.container->bounds().grownBy(0.4 * reach);
  Body body;
  for (int attempt = 0; attempt < 10000; ++attempt) {
    body.position = box.lo + box.size().cwiseProduct(Vec3(unit(random), unit(random), unit(random)));
    const double distance = c.wall().distance(body.position).distance;
    if (distance < 1.2 * reach && distance > -reach) break;
  }
  body.rotation = test::randomRotation(random);
  body.orientation = Quaternion(body.rotation);
  body.scale = random() % 3 == 0 ? 0.7 : 1.0;
  return body;
}

/// @param mask clusters that are looked at, and afterwards those that are near
WallSums look(const SampleView& samples, const WallFrame& frame, double clearance, double margin,
              ClusterMask& mask) {
  WallSums sums;
  std::memset(static_cast<void*>(&sums), 0, sizeof sums);
  wallKernel(chosenInstructionSet())(samples, frame, float(clearance), float(margin), mask, sums);
  return sums;
}
WallSums look(const SampleView& samples, const WallFrame& frame, double clearance) {
  ClusterMask mask = allClusters;
  return look(samples, frame, clearance, 0.0, mask);
}

Vec3 pointOf(const SampleView& samples, int i) {
  return Vec3(samples.x[i], samples.y[i], samples.z[i]);
}

/// So large that every point counts as touching, whereby the sums tell its distance.
constexpr double everything = 40.0;

double weightOf(const WallSums& sums) {
  double weight = 0.0;
  for (int k = 0; k < sums.contacts; ++k) weight += sums.contact[k].weight;
  return weight;
}

/// What the kernel says of single points, against distance(p).
template <class Distance>
double worstError(const NamedContainer& c, const WallField& field, bool deep, std::mt19937& random,
                  Distance&& expected) {
  double worst = 0.0;
  for (int n = 0; n < 200; ++n) {
    Body body = randomBody(c, 4.0, random);
    body.scale = 1.0;
    const SamplePoints one = test::oneCluster({Vec3(4.0 * test::randomDirection(random))});
    const Vec3 p = body.position + body.rotation * pointOf(viewOf(one), 0);
    const WallSums found = look(viewOf(one), field.frameOf(body, 4.0, deep), everything);
    REQUIRE(found.contacts >= 1);  // several where the gradient vanishes
    if (const auto distance = expected(p))
      worst = std::max(worst, std::abs(everything - found.contact[0].deepest - *distance));
  }
  return worst;
}

}  // namespace

TEST_CASE("Wall distances of sixteen points at once equal those of single points",
          "[relaxation][kernel][wall]") {
  std::mt19937 random(2);
  for (const NamedContainer& c : test::allContainers()) {
    CAPTURE(c.name);
    const Box region = regionOf(*c.container);
    const WallField field(c.wall(), region);
    if (c.wall().closedForm()) {
      const auto exact = [&](const Vec3& p) { return std::optional<double>(c.wall().distance(p).distance); };
      REQUIRE(worstError(c, field, false, random, exact) < 2e-5);
      continue;
    }
    const double spacing = c.wall().samplingSpacing();
    const SampledDistance fine(c.wall(), region, spacing), coarse(c.wall(), region, 1.0);
    REQUIRE(worstError(c, field, false, random,
                       [&](const Vec3& p) { return std::optional<double>(fine.sample(p).distance); }) < 2e-5);
    REQUIRE(worstError(c, field, true, random, [&](const Vec3& p) {
              return std::optional<double>(coarse.sample(p).distance);
            }) < 5e-5);
    // And that is the distance itself, where it matters: corners err by a quarter of the spacing.
    const auto near = [&](const Vec3& p) {
      const double distance = c.wall().distance(p).distance;
      return std::abs(distance) < 1.0 ? std::optional<double>(distance) : std::nullopt;
    };
    REQUIRE(worstError(c, field, false, random, near) < 0.3 * spacing);

    // Different points in the lanes.
    for (int n = 0; n < 50; ++n) {
      Body body = randomBody(c, 4.0, random);
      body.scale = 1.0;
      std::vector<Vec3> points;
      for (int k = 0; k < 16; ++k) points.push_back(2.0 * test::randomDirection(random));
      const SamplePoints all = test::oneCluster(points);
      double weight = 0.0;
      for (int k = 0; k < 16; ++k)
        weight += everything - fine.sample(body.position + body.rotation * pointOf(viewOf(all), k)).distance;
      const WallSums found = look(viewOf(all), field.frameOf(body, 4.0, false), everything);
      REQUIRE(weightOf(found) == Approx(weight).margin(2e-3));
    }
  }
}

TEST_CASE("Contacts with the wall are the sums over all sample points", "[relaxation][kernel][wall]") {
  std::mt19937 random(3);
  int touching = 0, several = 0;
  for (const NamedContainer& c : test::allContainers()) {
    const Box region = regionOf(*c.container);
    const WallField field(c.wall(), region);
    for (const test::NamedShape& shape : test::allShapes()) {
      CAPTURE(c.name, shape.name);
      const ContactViews& model = shape.shape->views();
      for (int n = 0; n < 12; ++n) {
        const Body body = randomBody(c, shape.shape->radius(), random);
        const double clearance = n % 2 == 0 ? 0.02 : 0.3;
        const WallFrame frame = field.frameOf(body, shape.shape->radius() * body.scale, false);
        const WallSums sums = look(model.samples, frame, clearance);
        double weight = 0.0, deepest = 0.0, found = 0.0;
        Vec3 point = Vec3::Zero(), foundPoint = Vec3::Zero();
        for (int i = 0; i < 16 * model.samples.clusters; ++i) {
          const Vec3 at = pointOf(model.samples, i), arm = body.scale * (body.rotation * at);
          // The kernel itself, a point at a time: what it says of points is tested above.
          const WallSums single = look(viewOf(test::oneCluster({at})), frame, everything);
          const double depth = clearance - (everything - single.contact[0].deepest);
          if (depth <= 0.0) continue;
          weight += depth;
          point += depth * arm;
          deepest = std::max(deepest, depth);
        }
        double foundDeepest = 0.0;
        for (int k = 0; k < sums.contacts; ++k) {
          found += sums.contact[k].weight;
          foundPoint += Vec3(sums.contact[k].point[0], sums.contact[k].point[1], sums.contact[k].point[2]);
          foundDeepest = std::max<double>(foundDeepest, sums.contact[k].deepest);
        }
        CAPTURE(n, sums.contacts, weight, found);
        const double rounding = 1e-5 * (100.0 + weight);
        REQUIRE(std::abs(found - weight) < rounding);
        REQUIRE((foundPoint - point).norm() < shape.shape->radius() * rounding);
        REQUIRE(foundDeepest == Approx(deepest).margin(1e-4));
        touching += weight > 0.0;
        several += sums.contacts > 1;
      }
    }
  }
  REQUIRE(touching > 200);
  REQUIRE(several > 20);
}

TEST_CASE("Without a contact, no sample point is closer to the wall than the bound given by the kernel",
          "[relaxation][kernel][wall]") {
  std::mt19937 random(4);
  int checked = 0;
  for (const NamedContainer& c : test::allContainers()) {
    const WallField field(c.wall(), regionOf(*c.container));
    // The field may be too large by what its interpolation errs by.
    const double error = c.wall().closedForm() ? 1e-4 : 0.3 * c.wall().samplingSpacing() + c.wall().slack();
    for (const test::NamedShape& shape : test::allShapes()) {
      CAPTURE(c.name, shape.name);
      const ContactViews& model = shape.shape->views();
      for (int n = 0; n < 25; ++n) {
        const Body body = randomBody(c, shape.shape->radius(), random);
        const WallFrame frame = field.frameOf(body, shape.shape->radius() * body.scale, false);
        const WallSums sums = look(model.samples, frame, 0.02);
        if (sums.contacts > 0) continue;
        double nearest = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 16 * model.samples.clusters; ++i)
          nearest = std::min(
              nearest, c.wall()
                           .distance(body.position + body.scale * (body.rotation * pointOf(model.samples, i)))
                           .distance);
        ++checked;
        CAPTURE(n, nearest, sums.nearest);
        REQUIRE(sums.nearest >= 0.02f);
        REQUIRE(sums.nearest <= nearest + error);
      }
    }
  }
  REQUIRE(checked > 200);
}

TEST_CASE("Clusters outside the mask have no wall contact before the cell has moved by the margin",
          "[relaxation][kernel][wall]") {
  std::mt19937 random(5);
  int touching = 0, spared = 0;
  for (const NamedContainer& c : test::allContainers()) {
    const WallField field(c.wall(), regionOf(*c.container));
    for (const test::NamedShape& shape : test::allShapes()) {
      CAPTURE(c.name, shape.name);
      const ContactViews& model = shape.shape->views();
      for (int n = 0; n < 15; ++n) {
        Body body = randomBody(c, shape.shape->radius(), random);
        const double reach = shape.shape->radius() * body.scale, margin = n % 2 == 0 ? 0.1 : 0.02;
        ClusterMask mask = allClusters;
        look(model.samples, field.frameOf(body, reach, false), 0.02, margin, mask);
        spared += __builtin_popcountll(mask) < std::min(64, model.samples.clusters) / 2;
        body.position += 0.5 * margin * test::randomDirection(random);
        body.rotation =
            Quaternion::around(test::randomDirection(random), 0.45 * margin / reach).toRotationMatrix() *
            body.rotation;
        const WallFrame frame = field.frameOf(body, reach, false);
        const WallSums all = look(model.samples, frame, 0.02);
        const WallSums some = look(model.samples, frame, 0.02, 0.0, mask);
        CAPTURE(n, margin);
        // Interpolated distances change by a little more than points move.
        const double error = c.wall().closedForm() ? 1e-5 : 0.5 * margin;
        for (int k = 0; k < std::min(all.contacts, some.contacts); ++k)
          REQUIRE(std::abs(all.contact[k].deepest - some.contact[k].deepest) < error);
        if (c.wall().closedForm()) REQUIRE(all.contacts == some.contacts);
        touching += all.contacts > 0;
      }
    }
  }
  REQUIRE(touching > 300);
  REQUIRE(spared > 300);
}

TEST_CASE("A cell between two walls has a contact with each", "[relaxation][kernel][wall]") {
  const auto sphere = test::sphereShape(2.0);
  const ContactViews& model = sphere->views();
  const auto slit = makeBox(Box{Vec3::Zero(), Vec3(20.0, 20.0, 3.8)}, {true, true, false});
  const auto room = makeBox(Box{Vec3::Zero(), Vec3(20.0, 20.0, 20.0)}, {false, false, false});
  const auto seen = [&](const Container& container, const Vec3& at) {
    Body body;
    body.position = at;
    const WallField field(*container.wall(), container.bounds());
    return look(model.samples, field.frameOf(body, 2.0, false), 0.0);
  };
  const WallSums between = seen(*slit, Vec3(10.0, 10.0, 1.9));
  REQUIRE(between.contacts == 2);
  for (int k = 0; k < 2; ++k) REQUIRE(between.contact[k].deepest == Approx(0.1).margin(0.01));
  REQUIRE(between.contact[0].normal[2] * between.contact[1].normal[2] < 0.0f);
  REQUIRE(seen(*slit, Vec3(10.0, 10.0, 1.7)).contacts == 1);
  // In a corner of three walls.
  const WallSums corner = seen(*room, Vec3(1.8, 1.85, 18.1));
  REQUIRE(corner.contacts == 3);
  double depths[3];
  for (int k = 0; k < 3; ++k) depths[k] = corner.contact[k].deepest;
  std::sort(depths, depths + 3);
  REQUIRE(depths[0] == Approx(0.1).margin(0.02));
  REQUIRE(depths[2] == Approx(0.2).margin(0.02));
  REQUIRE(seen(*room, Vec3(10.0, 10.0, 10.0)).contacts == 0);
}
