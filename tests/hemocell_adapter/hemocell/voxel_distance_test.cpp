// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/voxel_distance.h"

#include <chrono>
#include <cstdio>
#include <random>

#include "hemocell_adapter/hemocell/acceptance.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

/// Signed distance by looking at every cube [nodes]; points inside the lattice.
double bruteForce(const Lattice& lattice, const Vec3& u) {
  const std::array<int, 3> nodes = lattice.nodes();
  double to[2] = {1e30, 1e30};
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j)
      for (int i = 0; i < nodes[0]; ++i) {
        const Vec3 away = ((u - Vec3(i, j, k)).cwiseAbs().array() - 0.5).max(0.0);
        double& best = to[lattice.fluid(i, j, k)];
        best = std::min(best, away.norm());
      }
  if (to[1] > 0.0) return -to[1];
  for (int axis = 0; axis < 3; ++axis) to[0] = std::min({to[0], u[axis] + 0.5, nodes[axis] - 0.5 - u[axis]});
  return to[0];
}

Lattice randomBlobs(std::array<int, 3> nodes, unsigned seed, int blobs) {
  Lattice lattice(nodes, 0.5);
  std::mt19937 random(seed);
  for (int b = 0; b < blobs; ++b) {
    const Vec3 center(random() % nodes[0], random() % nodes[1], random() % nodes[2]);
    const double radius = 0.5 + random() % 5;
    for (int k = 0; k < nodes[2]; ++k)
      for (int j = 0; j < nodes[1]; ++j)
        for (int i = 0; i < nodes[0]; ++i)
          if ((Vec3(i, j, k) - center).norm() < radius) lattice.setFluid(i, j, k, false);
  }
  return lattice;
}

}  // namespace

TEST_CASE("The transform equals the distance to all cubes at every sample", "[voxels]") {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Lattice lattice = randomBlobs({17, 11, 8}, seed, 3);
    for (int step : {1, 2, 4}) {
      const std::array<int, 3> samples = {16 / step + 1, 8 / step + 1, 8 / step + 1};
      const std::vector<float> transform = voxelTransform(lattice, step, samples);
      double worst = 0.0;
      std::size_t index = 0;
      for (int k = 0; k < samples[2]; ++k)
        for (int j = 0; j < samples[1]; ++j)
          for (int i = 0; i < samples[0]; ++i, ++index) {
            const Vec3 u = Vec3(step * i, step * j, step * k).array() - 0.5;
            worst = std::max(worst, std::abs(transform[index] - bruteForce(lattice, u)));
          }
      CHECK(worst < 1e-5);
    }
  }
}

TEST_CASE("The smoothed distance is a lower bound that grows no faster than the distance", "[voxels]") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto anywhere = [&](const Vec3& size) {
    return Vec3(Vec3(uniform(random), uniform(random), uniform(random)).cwiseProduct(size).array() - 0.5);
  };
  double steepest = 0.0, corner = 0.0;  // where it is 0: the distance [reach]
  for (unsigned seed = 0; seed < 12; ++seed) {
    const std::array<int, 3> nodes = {14, 12, 10};
    Lattice lattice = randomBlobs(nodes, 40 + seed, 2 + int(seed % 4));
    for (int n = 0; n < (seed < 6 ? 0 : 200); ++n)  // single nodes
      lattice.setFluid(int(random() % 14), int(random() % 12), int(random() % 10), seed % 2 == 0);
    const VoxelDistance field(lattice);
    double beyond = 0.0, worstSlope = 0.0;
    for (int n = 0; n < 4000; ++n) {
      const Vec3 u = anywhere({14, 12, 10});
      const WallDistance found = field.smoothed(0.5 * u);
      const double expected = 0.5 * bruteForce(lattice, u);
      beyond = std::max(beyond, found.distance - std::max(expected, 0.0));
      if (found.distance <= 0.0) corner = std::max(corner, expected / field.smoothReach());
      CHECK(found.distance <= field.smoothReach());
      if (found.gradient.isZero()) CHECK((found.distance == field.smoothReach() || expected < 0.0));
      if (found.distance < -0.2 || found.distance > 0.999 * field.smoothReach()) continue;
      const double step = 1e-6;
      Vec3 slope;
      for (int k = 0; k < 3; ++k)
        slope[k] = (field.smoothed(0.5 * u + step * Vec3::Unit(k)).distance -
                    field.smoothed(0.5 * u - step * Vec3::Unit(k)).distance) /
                   (2.0 * step);
      worstSlope = std::max(worstSlope, (slope.normalized() - found.gradient).norm());
      steepest = std::max(steepest, slope.norm());
    }
    CHECK(beyond < 1e-12);
    CHECK(worstSlope < 1e-4);
  }
  CHECK(corner < Wall::smoothedBelow);
  CHECK(steepest < 1.0 + 1e-6);
  CHECK(steepest > 0.8);
}

TEST_CASE("The smoothed distance is that to a plane, where nodes on one side of it are solid", "[voxels]") {
  Lattice lattice({12, 12, 12}, 0.25);
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 12; ++j) lattice.setFluid(0, 3, j, k, false);
  const VoxelDistance field(lattice);
  for (double u = 3.6; u < 4.5; u += 0.11) {
    const WallDistance at = field.smoothed(0.25 * Vec3(u, 5.3, 5.8));
    CHECK(at.distance == Approx(0.25 * (u - 4.15)).margin(1e-12));
    CHECK((at.gradient - Vec3::UnitX()).norm() < 1e-12);
  }
  CHECK(field.smoothed(0.25 * Vec3(4.5, 5.3, 5.8)).distance == field.smoothReach());
  CHECK(field.smoothReach() == Approx(0.25 * 0.35));
}

TEST_CASE("The distance to voxels has the exact sign everywhere and is exact up to its slack", "[voxels]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (unsigned seed = 0; seed < 6; ++seed) {
    const std::array<int, 3> nodes = {24, 20, 16};
    const Lattice lattice = randomBlobs(nodes, 10 + seed, 2 + seed);
    const VoxelDistance field(lattice);
    const double slack = field.slack() / 0.5;
    double worstNear = 0.0, mean = 0.0, worstOver = 0.0, worstUnit = 0.0;
    int wrongSign = 0, near = 0;
    for (int n = 0; n < 1000; ++n) {
      const Vec3 u(nodes[0] * uniform(random) - 0.5, nodes[1] * uniform(random) - 0.5,
                   nodes[2] * uniform(random) - 0.5);
      const double expected = bruteForce(lattice, u);
      const WallDistance found = field.at(0.5 * u);
      const double distance = found.distance / 0.5;
      worstUnit = std::max(worstUnit, std::abs(found.gradient.norm() - 1.0));
      if (std::abs(expected) > 1e-9) wrongSign += (expected > 0.0) != (distance > 0.0);
      if (expected > 0.0) worstOver = std::max(worstOver, distance - expected);
      if (std::abs(expected) < VoxelDistance::fineReach - slack) {
        worstNear = std::max(worstNear, std::abs(distance - expected));
        mean += std::abs(distance - expected);
        ++near;
      }
    }
    CHECK(wrongSign == 0);
    CHECK(worstNear < 0.26);  // too small at a crease, by up to a quarter of a node
    CHECK(mean / near < 0.03);
    CHECK(worstOver < slack);
    CHECK(worstUnit < 1e-12);
  }
}

TEST_CASE("The distance to voxels is continuous, and its gradient agrees with finite differences",
          "[voxels]") {
  const std::array<int, 3> nodes = {24, 20, 16};
  const Lattice lattice = randomBlobs(nodes, 3, 3);
  const VoxelDistance field(lattice);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double h = 1e-6;
  int checked = 0, off = 0;
  double steepest = 0.0;
  for (int n = 0; n < 40000; ++n) {
    const Vec3 center = 0.25 * Vec3(nodes[0] - 1, nodes[1] - 1, nodes[2] - 1);
    const Vec3 p = center + 0.32 * Vec3(nodes[0] * uniform(random), nodes[1] * uniform(random),
                                        nodes[2] * uniform(random));
    const WallDistance here = field.at(p);
    Vec3 forward, backward;
    for (int k = 0; k < 3; ++k) {
      forward[k] = (field.at(p + h * Vec3::Unit(k)).distance - here.distance) / h;
      backward[k] = (here.distance - field.at(p - h * Vec3::Unit(k)).distance) / h;
    }
    steepest = std::max({steepest, forward.cwiseAbs().maxCoeff(), backward.cwiseAbs().maxCoeff()});
    if ((forward - backward).norm() > 1e-4 || forward.norm() < 0.1) continue;  // at a crease or a summit
    ++checked;
    off += (forward.normalized() - here.gradient).norm() > 1e-3;
  }
  CHECK(checked > 30000);
  CHECK(off == 0);
  CHECK(steepest < 4.0);  // a jump would be steep
}

TEST_CASE("The gradient of the accepted wall leads from any point to where HemoCell keeps vertices",
          "[voxels]") {
  const VesselOnLattice vessel = placeVessel(prismAlongX(32, 5.0, 12.0), 0.5, 1, 40);
  const auto lattice = std::make_shared<Lattice>(vessel.lattice);
  for (int minimumDistance : {0, 1}) {
    const Acceptance acceptance(lattice, minimumDistance);
    const double clearance = 0.02;
    const auto wall = makeAcceptedWall(nullptr, lattice, minimumDistance, clearance);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(-6.0, 27.5);
    int refused = 0, lost = 0;
    for (int n = 0; n < 20000; ++n) {
      Vec3 p(uniform(random) * 1.2, uniform(random), uniform(random));
      WallDistance at = wall->distance(p);
      if (at.distance > clearance) refused += acceptance.violation({p}).has_value();
      if (at.distance < clearance - 1e-12) CHECK(acceptance.violation({p}).has_value());
      for (int step = 0; step < 60 && at.distance < clearance + 1e-6; ++step) {
        p += (clearance + 1e-3 - at.distance) * at.gradient;
        at = wall->distance(p);
      }
      lost += acceptance.violation({p}).has_value();
    }
    CHECK(refused == 0);
    CHECK(lost == 0);
  }
}

TEST_CASE("A lattice without fluid nodes has a finite distance", "[voxels]") {
  Lattice lattice({4, 4, 4}, 0.5);
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j) lattice.setFluid(0, 3, j, k, false);
  const WallDistance at = VoxelDistance(lattice).at({1, 1, 1});
  CHECK(at.distance < -2.0);
  CHECK(std::isfinite(at.distance));
  CHECK(at.gradient.allFinite());
}

TEST_CASE("Time of the distance to voxels", "[.][timing]") {
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto since = [&](std::chrono::steady_clock::time_point t) {
    return std::chrono::duration<double>(now() - t).count();
  };
  for (int refDirN : {50, 500}) {
    const VesselOnLattice vessel = placeVessel(prismAlongX(32, 5.0, 20.0), 0.5, 1, refDirN);
    auto start = now();
    const VoxelDistance field(vessel.lattice);
    std::printf("refDirN %d: transform %.3f s\n", refDirN, since(start));
    std::mt19937 random(1);
    const double radius = 0.25 * refDirN, center = radius + 0.5;
    for (double depth : {0.1, 0.5, 0.9, 3.0, -1.0}) {
      std::vector<Vec3> points(200000);
      for (Vec3& p : points) {
        const double angle = random() * 1.0, r = radius - depth;
        p = {0.1 * (random() % 400) + 5.0, center + r * std::cos(angle), center + r * std::sin(angle)};
      }
      double sum = 0.0;
      start = now();
      for (const Vec3& p : points) sum += field.at(p).distance;
      std::printf("  %.1f µm from the wall: %.0f ns a point (mean %.3f)\n", depth,
                  1e9 * since(start) / points.size(), sum / points.size());
    }
  }
}
