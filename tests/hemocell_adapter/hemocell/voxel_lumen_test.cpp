// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/voxel_lumen.h"

#include <cmath>
#include <random>

#include "packMesh/core/error.h"
#include "packMesh/problem/physics.h"
#include "tests/packMesh/sample_meshes.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"

using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

/// Fluid nodes at random, with one plane along x that is its own.
std::shared_ptr<const Lattice> randomLattice(const std::array<int, 3>& nodes, double dx, int seed) {
  std::mt19937 random(seed);
  auto lattice = std::make_shared<Lattice>(nodes, dx);
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j)
      for (int i = 0; i < nodes[0]; ++i) lattice->setFluid(i, j, k, random() % 3 != 0);
  return lattice;
}

using Axes = std::array<bool, 3>;
constexpr Axes none = {false, false, false};
constexpr Axes someAxes[] = {none, {true, false, false}, {false, true, true}, {true, true, true}};

/// Whether the cube of the node at p is fluid; the lattice may repeat.
bool inFluid(const Lattice& lattice, const Vec3& p, const Axes& periodic) {
  std::array<int, 3> at;
  for (int k = 0; k < 3; ++k) {
    const int n = lattice.nodes()[k];
    at[k] = static_cast<int>(std::floor(p[k] / lattice.dx() + 0.5));
    if (periodic[k]) at[k] = ((at[k] % n) + n) % n;
    if (at[k] < 0 || at[k] >= n) return false;
  }
  return lattice.fluid(at[0], at[1], at[2]);
}

/// Whether a box meets or lies in what is not fluid, cube by cube.
bool meetsSolid(const Lattice& lattice, const Box& box, const Axes& periodic) {
  const double dx = lattice.dx();
  std::array<int, 3> lo, hi;
  for (int k = 0; k < 3; ++k) {  // closed cubes that the closed box meets
    lo[k] = static_cast<int>(std::ceil(box.lo[k] / dx - 0.5));
    hi[k] = static_cast<int>(std::floor(box.hi[k] / dx + 0.5));
  }
  for (int k = lo[2]; k <= hi[2]; ++k)
    for (int j = lo[1]; j <= hi[1]; ++j)
      for (int i = lo[0]; i <= hi[0]; ++i)
        if (!inFluid(lattice, dx * Vec3(i, j, k), periodic)) return true;
  return false;
}

}  // namespace

TEST_CASE("Soft cells keep to the smoothed wall of fluid nodes, as long as no clearance is demanded",
          "[lattice][soft]") {
  auto lattice = std::make_shared<Lattice>(std::array<int, 3>{20, 19, 19}, 0.25);
  for (int k = 0; k < 19; ++k)
    for (int j = 0; j < 19; ++j)
      if ((j - 9) * (j - 9) + (k - 9) * (k - 9) > 64) lattice->setFluid(0, 19, j, k, false);
  Physics physics;
  physics.container = makeVoxelLumen(lattice, {true, false, false});
  physics.smoothWalls = true;
  physics.add("RBC", test::redCellShape(), 1);
  const Wall& wall = *physics.container->wall();
  const WallGap gap = *wallGapOf(physics, 0);
  CHECK(physics.smoothReachOf(0) == Approx(0.35 * 0.25));
  double narrowest = 9.0, widest = 0.0;  // radius at which the gap is 0
  for (double angle = 0.0; angle < 2.0 * M_PI; angle += 0.01) {
    const Vec3 out(0.0, std::cos(angle), std::sin(angle));
    double lo = 1.0, hi = 2.2;
    while (hi - lo > 1e-6) {
      const double r = 0.5 * (lo + hi);
      (gap(Vec3(1.3, 2.25, 2.25) + r * out).distance > 0.0 ? lo : hi) = r;
    }
    narrowest = std::min(narrowest, lo);
    widest = std::max(widest, lo);
    const Vec3 p = Vec3(4.9, 2.25, 2.25) + lo * out;
    CHECK(wall.distance(p).distance > 0.0);
    CHECK(gap(p).distance == Approx(gap(p + 3.0 * physics.container->period()).distance).margin(1e-9));
  }
  CHECK(narrowest > 1.7);  // the steps are at 1.85 to 2.13 µm
  CHECK(widest < 1.95);
  physics.wallClearance = 0.1;
  CHECK(physics.smoothReachOf(0) == 0.0);
  const Vec3 near(1.3, 2.25, 4.0);
  CHECK((*wallGapOf(physics, 0))(near).distance < wall.distance(near).distance - 0.1);
}

TEST_CASE("The surface of fluid nodes is closed and contains their volume", "[lattice][vessel]") {
  for (const Axes& periodic : someAxes)
    for (const std::array<int, 3> nodes : {std::array<int, 3>{1, 1, 1}, {9, 5, 6}, {70, 4, 3}, {2, 7, 1}}) {
      const auto lattice = randomLattice(nodes, 0.5, nodes[0]);
      const TriangleMesh surface = voxelSurface(*lattice, periodic);
      CAPTURE(nodes[0], periodic[0], periodic[1], periodic[2]);
      if (periodic == none) {
        CHECK(signedVolume(surface) == Approx(lattice->fluidVolume()));
        CHECK(isFilledByParity(surface));
      }
      std::size_t faces = 0;
      for (int k = -1; k <= nodes[2]; ++k)
        for (int j = -1; j <= nodes[1]; ++j)
          for (int i = -1; i <= nodes[0]; ++i)
            for (int axis = 0; axis < 3; ++axis) {
              const Vec3 p = 0.5 * Vec3(i, j, k), q = p + 0.5 * Vec3::Unit(axis);
              const std::array<int, 3> at = {i, j, k};
              bool image = false;
              for (int a = 0; a < 3; ++a) image = image || (periodic[a] && (at[a] < 0 || at[a] == nodes[a]));
              if (image) continue;
              faces += inFluid(*lattice, p, periodic) != inFluid(*lattice, q, periodic);
            }
      CHECK(surface.triangles.size() == 2 * faces);
    }
}

TEST_CASE("A lumen of fluid nodes has the right distance and volume and exact wall tests",
          "[lattice][vessel]") {
  std::mt19937 random(7);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<>(lo, hi)(random); };
  for (const Axes& periodic : someAxes) {
    CAPTURE(periodic[0], periodic[1], periodic[2]);
    const auto lattice = randomLattice({8, 6, 7}, 0.5, 3);
    const auto lumen = makeVoxelLumen(lattice, periodic);
    CHECK(lumen->volume() == Approx(lattice->fluidVolume()));
    CHECK(lumen->period() == Vec3(periodic[0] ? 4.0 : 0.0, periodic[1] ? 3.0 : 0.0, periodic[2] ? 3.5 : 0.0));
    const Box bounds = lumen->bounds();
    CHECK(bounds.size().x() == Approx(4.0));
    int wrongSide = 0, tooFar = 0;
    for (int n = 0; n < 5000; ++n) {
      const Vec3 p(uniform(-5, 9), uniform(-1, 4), uniform(-1, 4));
      const double distance = lumen->wall()->distance(p).distance;
      wrongSide += (distance > 0.0) != inFluid(*lattice, p, periodic);
      const double r = distance - lumen->wall()->slack();
      if (r > 0.0) tooFar += meetsSolid(*lattice, Box{p, p}.grownBy(r / std::sqrt(3.0)), periodic);
    }
    CHECK(wrongSide == 0);
    CHECK(tooFar == 0);

    NodeBlock block;
    block.origin = Vec3(-4.25, -0.5, 0.25);
    block.spacing = 0.25;
    for (int& count : block.nodes) count = 9;
    std::vector<float> sampled(9 * 9 * 9);
    lumen->wall()->sample(block, sampled.data());
    double worst = 0.0;
    for (int k = 0, n = 0; k < 9; ++k)
      for (int j = 0; j < 9; ++j)
        for (int i = 0; i < 9; ++i, ++n)
          worst = std::max(worst,
                           std::abs(sampled[n] - lumen->wall()->distance(block.position(i, j, k)).distance));
    CHECK(worst < 1e-6);

    int violations = 0, wrong = 0;
    for (int n = 0; n < 3000; ++n) {
      Box box;
      for (int corner = 0; corner < 2; ++corner)
        box.add(Vec3(uniform(-4, 8), uniform(-1, 4), uniform(-1, 4)));
      box.hi = box.lo +
               (box.hi - box.lo).cwiseMin(Vec3(uniform(0.01, 0.8), uniform(0.01, 0.8), uniform(0.01, 0.8)));
      const bool refused = lumen->wall()->violation(sample::box(box.lo, box.hi)).has_value();
      wrong += refused != meetsSolid(*lattice, box, periodic);
      violations += refused;
    }
    CHECK(wrong == 0);
    CHECK(violations > 1000);
    CHECK(violations < 2990);
  }
}

TEST_CASE("The gap to the wall of fluid nodes is that to the nearest solid cube", "[lattice][vessel]") {
  auto lattice = std::make_shared<Lattice>(std::array<int, 3>{12, 12, 12}, 0.5);
  lattice->setFluid(6, 6, 6, false);  // its cube is [2.75, 3.25]³
  const auto lumen = makeVoxelLumen(lattice, none);
  const auto gap = [&](const Vec3& lo, const Vec3& hi) {
    const MeshHierarchy box(sample::box(lo, hi));
    const WallVerdict verdict = lumen->wall()->examine({box, Placement()}, 1.0);
    REQUIRE(!verdict.violation);
    return verdict.gap;
  };
  CHECK(gap({2.0, 2.9, 2.9}, {2.5, 3.1, 3.1}) == Approx(0.25));
  CHECK(gap({2.0, 2.0, 2.0}, {2.5, 2.5, 2.5}) == Approx(0.25 * std::sqrt(3.0)));
  CHECK(gap({0.0, 1.0, 1.0}, {0.5, 1.2, 1.2}) == Approx(0.25));  // the end of the lattice
  CHECK(lumen->wall()->violation(sample::box({2, 2, 2}, {4, 4, 4})) == "encloses part of the wall");
  CHECK(lumen->wall()->violation(sample::box({2.8, 2.8, 2.8}, {3.2, 3.2, 3.2})) == "is outside the lumen");
  CHECK(lumen->wall()->violation(sample::box({2, 2, 2}, {2.75, 3, 3})) == "meets the wall");
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 12; ++j) lattice->setFluid(0, 11, j, k, false);
  CHECK_THROWS_AS(makeVoxelLumen(lattice, none), InputError);
}
