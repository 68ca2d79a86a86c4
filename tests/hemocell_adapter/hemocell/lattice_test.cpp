// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/lattice.h"

#include <chrono>
#include <cstdio>
#include <random>

#include "packMesh/core/error.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

TriangleMesh cuboid(const Vec3& lo, const Vec3& hi) {
  TriangleMesh mesh;
  for (int v = 0; v < 8; ++v)
    mesh.vertices.emplace_back(v & 1 ? hi.x() : lo.x(), v & 2 ? hi.y() : lo.y(), v & 4 ? hi.z() : lo.z());
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

double secondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

TEST_CASE("A lattice stores a flag per node", "[lattice]") {
  Lattice lattice({130, 3, 2}, 0.5);
  CHECK(lattice.fluidNodes() == 780);
  CHECK(lattice.fluidVolume() == 780 * 0.125);
  std::mt19937 random(1);
  std::vector<bool> flags(780, true);
  for (int n = 0; n < 2000; ++n) {
    const int i = random() % 130, j = random() % 3, k = random() % 2;
    const bool fluid = random() % 2;
    lattice.setFluid(i, j, k, fluid);
    flags[i + 130 * (j + 3 * k)] = fluid;
  }
  lattice.setFluid(60, 200, 1, 1, false);
  for (int i = 60; i < 130; ++i) flags[i + 130 * (1 + 3)] = false;
  lattice.setFluid(-5, 64, 2, 0, true);
  for (int i = 0; i <= 64; ++i) flags[i + 130 * 2] = true;
  int wrong = 0, fluid = 0;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 130; ++i) {
        wrong += lattice.fluid(i, j, k) != flags[i + 130 * (j + 3 * k)];
        fluid += lattice.fluid(i, j, k);
      }
  CHECK(wrong == 0);
  CHECK(lattice.fluidNodes() == fluid);
  CHECK(lattice.keptRegion().lo == Vec3(-0.25, -0.25, -0.25));
  CHECK(lattice.keptRegion().hi == Vec3(64.75, 1.25, 0.75));
}

TEST_CASE("An invalid lattice is rejected", "[lattice]") {
  CHECK_THROWS_WITH(Lattice({0, 1, 1}, 0.5), Contains("at least one"));
  CHECK_THROWS_WITH(Lattice({1 << 11, 1 << 11, 1 << 10}, 0.5), Contains("2^31"));
  CHECK_THROWS_AS(Lattice({1, 1, 1}, 0.0), InputError);
  CHECK_THROWS_AS(Lattice({1, 1, 1}, std::nan("")), InputError);
}

TEST_CASE("Erosion searches a cube for solid nodes and ignores nonexistent nodes", "[lattice]") {
  std::mt19937 random(2);
  for (const std::array<int, 3> nodes : {std::array<int, 3>{9, 7, 5}, {70, 4, 3}, {1, 1, 6}, {129, 2, 2}}) {
    Lattice lattice(nodes, 1.0);
    for (int k = 0; k < nodes[2]; ++k)
      for (int j = 0; j < nodes[1]; ++j)
        for (int i = 0; i < nodes[0]; ++i) lattice.setFluid(i, j, k, random() % 40 != 0);
    for (int radius : {0, 1, 2, 3, 66}) {
      const Lattice eroded = lattice.eroded(radius);
      int wrong = 0;
      for (int k = 0; k < nodes[2]; ++k)
        for (int j = 0; j < nodes[1]; ++j)
          for (int i = 0; i < nodes[0]; ++i) {
            bool expected = true;
            for (int c = std::max(0, k - radius); c <= std::min(nodes[2] - 1, k + radius); ++c)
              for (int b = std::max(0, j - radius); b <= std::min(nodes[1] - 1, j + radius); ++b)
                for (int a = std::max(0, i - radius); a <= std::min(nodes[0] - 1, i + radius); ++a)
                  expected = expected && lattice.fluid(a, b, c);
            wrong += eroded.fluid(i, j, k) != expected;
          }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("The range of the fluid nodes and the images around a lattice are those of its nodes",
          "[lattice]") {
  for (const std::array<int, 3> nodes : {std::array<int, 3>{130, 5, 4}, {64, 3, 3}, {7, 3, 6}}) {
    Lattice lattice(nodes, 0.5);
    for (int k = 0; k < nodes[2]; ++k)
      for (int j = 0; j < nodes[1]; ++j) lattice.setFluid(0, nodes[0] - 1, j, k, false);
    CHECK_FALSE(lattice.fluidRange());
    CHECK_FALSE(lattice.hasFluidNodes());
    lattice.setFluid(nodes[0] - 3, 1, 2, true);
    lattice.setFluid(nodes[0] - 2, 2, 1, true);
    CHECK(lattice.fluidRange() ==
          std::array<std::array<int, 3>, 2>{{{nodes[0] - 3, 1, 1}, {nodes[0] - 2, 2, 2}}});
    const std::array<int, 3> margin = {66, 0, 7};
    const Lattice repeated = lattice.repeated(margin);
    int wrong = 0;
    for (int k = 0; k < repeated.nodes()[2]; ++k)
      for (int j = 0; j < repeated.nodes()[1]; ++j)
        for (int i = 0; i < repeated.nodes()[0]; ++i)
          wrong += repeated.fluid(i, j, k) !=
                   lattice.fluid((i - 66 + 10 * nodes[0]) % nodes[0], j, (k - 7 + 10 * nodes[2]) % nodes[2]);
    CHECK(wrong == 0);
    CHECK(repeated.nodes() == std::array<int, 3>{nodes[0] + 132, nodes[1], nodes[2] + 14});
  }
}

TEST_CASE("A vessel's size and position depend on refDirN and dx, not on the unit of its file", "[lattice]") {
  for (double unit : {1.0, 1e-3, 250.0}) {
    const VesselOnLattice vessel = placeVessel(prismAlongX(32, 5.0 * unit, 20.0 * unit), 0.5, 1, 50);
    CHECK(vessel.lattice.nodes() == std::array<int, 3>{103, 53, 53});
    CHECK(vessel.period == 51.5);
    const Box box = boundingBox(vessel.surface);
    CHECK((box.lo - Vec3(0.5, 0.5, 0.5)).norm() < 1e-12);
    CHECK((box.hi - Vec3(50.5, 25.5, 25.5)).norm() < 1e-12);
  }
  CHECK(placeVessel(cuboid({0, 0, 0}, {2, 1, 1}), 0.25, 0, 20).lattice.nodes() ==
        std::array<int, 3>{23, 13, 13});
  CHECK_THROWS_WITH(placeVessel(prismAlongX(8, 1, 1), 0.5, 3, 50), Contains("<refDir> 3"));
  CHECK_THROWS_WITH(placeVessel(prismAlongX(8, 1, 1), 0.5, 1, 0), Contains("<refDirN> 0"));
  CHECK_THROWS_WITH(placeVessel(prismAlongX(8, 1, 1e6), 0.5, 1, 5000), Contains("2^31"));
}

TEST_CASE("Nodes inside or on the inflated surface are fluid, and the ends are opened", "[lattice]") {
  // The faces lie in node planes: inflation makes the nodes in them fluid.
  const Lattice box = placeVessel(cuboid({0, 0, 0}, {10, 6, 4}), 1.0, 0, 10).lattice;
  REQUIRE(box.nodes() == std::array<int, 3>{13, 9, 7});
  int wrong = 0;
  for (int k = 0; k < 7; ++k)
    for (int j = 0; j < 9; ++j)
      for (int i = 0; i < 13; ++i) wrong += box.fluid(i, j, k) != (j >= 1 && j <= 7 && k >= 1 && k <= 5);
  CHECK(wrong == 0);

  // Inside out, the surface is deflated and loses them, but for the ends, which are copies.
  TriangleMesh insideOut = cuboid({0, 0, 0}, {10, 6, 4});
  flip(insideOut);
  const Lattice deflated = placeVessel(insideOut, 1.0, 0, 10).lattice;
  CHECK(!deflated.fluid(6, 1, 3));
  CHECK(deflated.fluid(6, 2, 3));
}

TEST_CASE("The end planes copy the planes next to them in ascending order", "[lattice]") {
  // A pyramid-like wedge: the section grows along x, so that each plane is its own.
  TriangleMesh wedge = cuboid({0, 0, 0}, {10, 20, 20});
  for (Vec3& v : wedge.vertices)
    if (v.x() == 0.0) v.y() *= 0.5;
  const Lattice lattice = placeVessel(wedge, 1.0, 0, 10).lattice;
  REQUIRE(lattice.nodes() == std::array<int, 3>{13, 23, 23});
  const auto height = [&](int i) {
    int count = 0;
    for (int j = 0; j < 23; ++j) count += lattice.fluid(i, j, 11);
    return count;
  };
  CHECK(height(2) == 12);  // y from 1 to 12
  CHECK(height(1) == 12);  // takes plane 2; its own had 11
  CHECK(height(0) == 11);  // takes the original plane 1
  CHECK(height(10) == 20);
  CHECK(height(11) == 20);  // takes plane 10; its own had 21
  CHECK(height(12) == 20);  // takes the new plane 11
}

TEST_CASE("Voxelisation agrees with the half planes of rotated prisms and with spheres", "[lattice]") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    TriangleMesh mesh = cuboid({-9, -6, -4}, {9, 6, 4});
    const Quaternion turn =
        trial == 0
            ? Quaternion::Identity()
            : Quaternion(uniform(random), uniform(random), uniform(random), uniform(random)).normalized();
    const Vec3 center =
        trial == 0 ? Vec3(12, 12, 12) : Vec3(Vec3::Constant(12.0) + Vec3(uniform(random), 0, 0));
    for (Vec3& v : mesh.vertices) v = turn * v + center;
    Lattice lattice({25, 25, 25}, 1.0);
    for (int k = 0; k < 25; ++k)
      for (int j = 0; j < 25; ++j) lattice.setFluid(0, 24, j, k, false);
    fillInside(lattice, mesh);
    int wrong = 0;
    for (int k = 0; k < 25; ++k)
      for (int j = 0; j < 25; ++j)
        for (int i = 0; i < 25; ++i) {
          const Vec3 p = (turn.inverse() * (Vec3(i, j, k) - center)).cwiseAbs();
          const double outside = (p - Vec3(9, 6, 4)).maxCoeff();
          if (std::abs(outside) > 1e-9) wrong += lattice.fluid(i, j, k) != (outside < 0.0);
        }
    CHECK(wrong == 0);
  }
}

TEST_CASE("Rays through vertices and along edges are handled correctly", "[lattice]") {
  // An octahedron with vertices and edges in node planes.
  TriangleMesh mesh{{{14, 7, 7}, {0, 7, 7}, {7, 14, 7}, {7, 0, 7}, {7, 7, 14}, {7, 7, 0}},
                    {{4, 0, 2}, {4, 2, 1}, {4, 1, 3}, {4, 3, 0}, {5, 2, 0}, {5, 1, 2}, {5, 3, 1}, {5, 0, 3}}};
  Lattice lattice({15, 15, 15}, 1.0);
  for (int k = 0; k < 15; ++k)
    for (int j = 0; j < 15; ++j) lattice.setFluid(0, 14, j, k, false);
  for (Vec3& v : mesh.vertices) v = Vec3(7, 7, 7) + 1.001 * (v - Vec3(7, 7, 7));
  fillInside(lattice, mesh);
  int wrong = 0;
  for (int k = 0; k < 15; ++k)
    for (int j = 0; j < 15; ++j)
      for (int i = 0; i < 15; ++i)
        wrong += lattice.fluid(i, j, k) != (std::abs(i - 7) + std::abs(j - 7) + std::abs(k - 7) <= 7);
  CHECK(wrong == 0);
}

TEST_CASE("Time to voxelise", "[.][timing]") {
  for (int refDirN : {50, 500}) {
    TriangleMesh tube = prismAlongX(64, 5.0, refDirN == 50 ? 20.0 : 20.0);
    const auto start = std::chrono::steady_clock::now();
    const VesselOnLattice vessel = placeVessel(tube, 0.5, 1, refDirN);
    std::printf("%d x %d x %d nodes: %.4f s, %lld fluid\n", vessel.lattice.nodes()[0],
                vessel.lattice.nodes()[1], vessel.lattice.nodes()[2], secondsSince(start),
                static_cast<long long>(vessel.lattice.fluidNodes()));
  }
}

TEST_CASE("What a surface encloses is counted as often as it does, in whatever sense it winds around it",
          "[lattice]") {
  // A prism whose section crosses itself: the smaller part winds the other way.
  TriangleMesh mesh;
  for (const double z : {1.0, 81.0})
    for (const auto& [x, y] :
         {std::pair(1.0, 1.0), std::pair(61.0, 61.0), std::pair(61.0, 1.0), std::pair(1.0, 25.0)})
      mesh.vertices.emplace_back(z, x, y);
  mesh.vertices.emplace_back(1.0, 18.0, 19.0);
  mesh.vertices.emplace_back(81.0, 18.0, 19.0);
  for (int a = 0; a < 4; ++a) {
    const int b = (a + 1) % 4;
    for (const Triangle& t : {Triangle{a, b, b + 4}, {a, b + 4, a + 4}, {8, b, a}, {9, a + 4, b + 4}})
      mesh.triangles.push_back(t);
  }
  // The sides cross at (18 1/7, 18 1/7): triangles of base 24 and 60.
  const double small = 0.5 * 24 * (1 + 120.0 / 7 - 1), large = 0.5 * 60 * (60 - 120.0 / 7);
  CHECK(std::abs(signedVolume(mesh)) == Approx(80 * (large - small)));
  CHECK(enclosedVolume(mesh) == Approx(80 * (large + small)).epsilon(0.01));
  TriangleMesh turned = mesh;
  for (Triangle& t : turned.triangles) std::swap(t[0], t[1]);
  CHECK(enclosedVolume(turned) == enclosedVolume(mesh));
}
