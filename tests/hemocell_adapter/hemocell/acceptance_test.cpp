// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/acceptance.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <random>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

namespace {

bool allows(const Acceptance& acceptance, const Vec3& p) {
  return !acceptance.violation({p});
}

std::vector<bool> keptCells(const Acceptance& acceptance, const TriangleMesh& mesh,
                            const std::vector<PosLine>& lines) {
  std::vector<bool> kept;
  for (const PosLine& line : lines)
    kept.push_back(!acceptance.violation(placed(mesh, placementOf(line)).vertices));
  return kept;
}

long count(const std::vector<bool>& flags) {
  return std::count(flags.begin(), flags.end(), true);
}

/// A wall that is a plane z = 3, lumen above.
class Floor : public Wall {
 public:
  WallDistance distance(const Vec3& p) const override { return {p.z() - 3.0, Vec3::UnitZ()}; }
  double slack() const override { return 0.125; }
  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    WallVerdict verdict;
    const double gap = boundingBox(placed(cell.hierarchy.mesh(), cell.placement)).lo.z() - 3.0;
    if (gap < 0.0)
      verdict.violation = "meets the wall";
    else if (gap < gapOfInterest)
      verdict.gap = gap;
    return verdict;
  }
};

}  // namespace

TEST_CASE("HemoCell keeps vertices above -0.5 and up to n - 0.5 on every axis", "[acceptance]") {
  const Acceptance acceptance(std::make_shared<Lattice>(std::array<int, 3>{8, 6, 4}, 0.5), 0);
  const Vec3 inside(1.5, 1.5, 1.0);
  const double n[] = {8, 6, 4};
  for (int k = 0; k < 3; ++k) {
    const auto at = [&](double u) {
      Vec3 p = inside;
      p[k] = 0.5 * u;
      return allows(acceptance, p);
    };
    CHECK(!at(-0.5));
    CHECK(at(std::nextafter(-0.5, 1.0)));
    CHECK(at(-0.0));
    CHECK(at(n[k] - 0.5));
    CHECK(!at(std::nextafter(n[k] - 0.5, 100.0)));
    CHECK(!at(-1e300));
    CHECK(!at(std::nan("")));
  }
  CHECK(acceptance.violation({inside, {1.5, 1.5, 2.0}}) == std::string("a vertex lies outside the lattice"));
  CHECK(!acceptance.violation({inside}));
}

TEST_CASE("The node of a vertex is trunc(p + 0.5)", "[acceptance]") {
  auto lattice = std::make_shared<Lattice>(std::array<int, 3>{8, 8, 8}, 0.5);
  lattice->setFluid(3, 4, 4, false);
  lattice->setFluid(0, 0, 0, false);
  const Acceptance acceptance(lattice, 0);
  CHECK(allows(acceptance, {0.5 * std::nextafter(2.5, 0.0), 2, 2}));
  CHECK(!allows(acceptance, {0.5 * 2.5, 2, 2}));
  CHECK(!allows(acceptance, {0.5 * std::nextafter(3.5, 0.0), 2, 2}));
  CHECK(allows(acceptance, {0.5 * 3.5, 2, 2}));
  CHECK(!allows(acceptance, {-0.2, -0.2, -0.2}));  // node 0, not -1
  CHECK(allows(acceptance, {0.26, -0.2, -0.2}));
  CHECK(acceptance.violation({{2, 2, 1}, {1.5, 2, 2}}) == std::string("a vertex lies on a wall node"));
}

TEST_CASE("A minimum distance from solid keeps a cube of nodes free", "[acceptance]") {
  auto lattice = std::make_shared<Lattice>(std::array<int, 3>{16, 16, 16}, 0.5);
  lattice->setFluid(8, 8, 8, false);
  const Acceptance one(lattice, 1);  // ±2 nodes
  for (int i = 0; i < 16; ++i) {
    CHECK(allows(one, {0.5 * i, 4, 4}) == (std::abs(i - 8) > 2));
    CHECK(allows(one, 0.5 * Vec3(i, i, i)) == (std::abs(i - 8) > 2));  // a cube, not a ball
    CHECK(allows(one, {0.5 * i, 5.5, 4}));
  }
  CHECK(one.violation({{3, 4, 4}}) == std::string("closer than 1 µm to a solid node"));
  CHECK(one.violation({{4, 4, 4}}) == std::string("a vertex lies on a wall node"));
  CHECK(allows(one, {-0.2, 4, 4}));  // what lies outside the lattice does not count
  // int(d/dx): 0.4 µm nodes, 1 µm is 2 nodes; 0.1 µm, 10.
  for (const auto& [dx, nodes] :
       {std::pair(0.4, 2), std::pair(0.1, 10), std::pair(1.0, 1), std::pair(3.0, 0)}) {
    auto fine = std::make_shared<Lattice>(std::array<int, 3>{32, 3, 3}, dx);
    fine->setFluid(16, 1, 1, false);
    const Acceptance acceptance(fine, 1);
    CHECK(!allows(acceptance, {dx * (16 + nodes), dx, dx}));
    CHECK(allows(acceptance, {dx * (17 + nodes), dx, dx}));
  }
}

TEST_CASE("Acceptance in a tube agrees with a plain test of every vertex", "[acceptance]") {
  // The tube of an independent description: 32 half planes, moved out by 1e-3 nodes along vertex normals.
  const VesselOnLattice vessel = placeVessel(prismAlongX(32, 5.0, 12.0), 0.5, 1, 40);
  auto lattice = std::make_shared<Lattice>(vessel.lattice);
  REQUIRE(lattice->nodes() == std::array<int, 3>{51, 43, 43});
  bool solid[43][43];  // [k][j]; open ends: every section is the same
  for (int k = 0; k < 43; ++k)
    for (int j = 0; j < 43; ++j) {
      const double apothem = 20.0 * std::cos(M_PI / 32) + 7e-4;
      solid[k][j] = false;
      for (int c = 0; c < 32; ++c) {
        const double angle = 2.0 * M_PI * (c + 0.5) / 32;
        solid[k][j] = solid[k][j] || (j - 21) * std::cos(angle) + (k - 21) * std::sin(angle) > apothem;
      }
    }
  const TriangleMesh mesh = buildTemplate(*defaultModel("RBC"), 0.5);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<PosLine> lines(300);
  for (PosLine& line : lines) {
    line.position =
        Vec3(25.5, 21.0, 21.0).cwiseProduct(Vec3(uniform(random), uniform(random), uniform(random)));
    line.angles = 360.0 * Vec3(uniform(random), uniform(random), uniform(random)) - Vec3::Constant(180.0);
  }
  long kept[3];
  for (int distance = 0; distance <= 2; ++distance) {
    std::vector<bool> expected;
    for (const PosLine& line : lines) {
      bool keep = true;
      const Placement placement = placementOf(line);
      for (const Vec3& v : mesh.vertices) {
        const Vec3 u = placement(v) / 0.5;
        for (int k = 0; k < 3; ++k) keep = keep && u[k] > -0.5 && u[k] <= lattice->nodes()[k] - 0.5;
        if (!keep) break;
        int node[3];
        for (int k = 0; k < 3; ++k) node[k] = static_cast<int>(std::floor(u[k] + 0.5));
        const int reach = 2 * distance;
        for (int j = std::max(0, node[1] - reach); j <= std::min(42, node[1] + reach); ++j)
          for (int k = std::max(0, node[2] - reach); k <= std::min(42, node[2] + reach); ++k)
            keep = keep && !solid[k][j];
        if (!keep) break;
      }
      expected.push_back(keep);
    }
    CHECK((keptCells(Acceptance(lattice, distance), mesh, lines) == expected));
    kept[distance] = count(expected);
  }
  CHECK(kept[0] == 53);
  CHECK(kept[1] < 53);
  CHECK(kept[2] < kept[1]);
}

TEST_CASE("Acceptance reproduces HemoCell's counts for the shipped pipe flow", "[.][pipeflow]") {
  const char* folder = std::getenv("PACKMESH_HEMOCELL_PIPEFLOW");
  if (!folder) {
    std::cerr << "not run: PACKMESH_HEMOCELL_PIPEFLOW does not name HemoCell's examples/pipeflow\n";
    return;
  }
  const std::string path = std::string(folder) + "/";
  TriangleMesh stl = readMesh(path + "tube.stl");
  for (const std::string& repair : repairClosed(stl, "tube.stl")) std::printf("%s\n", repair.c_str());
  const VesselOnLattice vessel = placeVessel(stl, 0.5, 1, 50);
  const auto lattice = std::make_shared<Lattice>(vessel.lattice);
  const std::array<int, 3> nodes = lattice->nodes();
  std::printf("%d x %d x %d nodes, %lld fluid, period %g µm\n", nodes[0], nodes[1], nodes[2],
              static_cast<long long>(lattice->fluidNodes()), vessel.period);
  CHECK(nodes[0] == 103);
  CHECK(vessel.period == 51.5);
  const Box box = boundingBox(vessel.surface);
  CHECK((box.center().tail<2>() - Vec2(13, 13)).norm() < 1e-3);
  CHECK(std::abs(box.size().y() - 25.0) < 1e-3);
  for (const std::string name : {"RBC", "PLT"}) {
    const TriangleMesh mesh = buildTemplate(readCellXml(path + name + ".xml", name), 0.5);
    const std::vector<PosLine> lines = readPos(path + name + ".pos");
    for (int distance : {0, 1}) {
      const long kept = count(keptCells(Acceptance(lattice, distance), mesh, lines));
      std::printf("%s, minimum distance %d: %ld of %zu kept\n", name.c_str(), distance, kept, lines.size());
      if (distance == 0) CHECK(kept == (name == "RBC" ? 36 : 6));
      if (distance == 1 && name == "RBC") CHECK(kept == 26);
    }
  }
}

TEST_CASE("The accepted wall is the nearer of the true wall and the voxels", "[acceptance]") {
  auto lattice = std::make_shared<Lattice>(std::array<int, 3>{40, 40, 40}, 0.5);
  const Floor floor;
  const auto wall = makeAcceptedWall(&floor, lattice, 0, 0.02);
  CHECK(wall->slack() == 0.125);
  CHECK(wall->distance({10, 10, 3.5}).distance == 0.5);
  CHECK(wall->distance({10, 10, 3.5}).gradient == Vec3::UnitZ());
  CHECK(wall->distance({0.25, 10, 10}).distance == Approx(0.5 + 0.02));
  CHECK(wall->distance({0.0, 10, 10}).distance == Approx(0.25 + 0.02));
  CHECK(wall->distance({0.0, 10, 10}).gradient == Vec3::UnitX());
  CHECK(wall->distance({-1.25, 10, 10}).distance == Approx(-1.0 + 0.02));

  TriangleMesh cell{{{5, 5, 5}, {6, 5, 5}, {5, 6, 5}}, {{0, 1, 2}}};
  CHECK(!wall->violation(cell));
  cell.vertices[0].z() = 2.0;
  CHECK(wall->violation(cell) == std::string("meets the wall"));
  cell.vertices[0] = {-1, 5, 5};
  CHECK(wall->violation(cell) == std::string("a vertex lies outside the lattice"));
  CHECK(makeAcceptedWall(nullptr, lattice, 0, 0.0)->slack() == Approx(0.065));
}

TEST_CASE("The clearance applies to the true wall, and cells need only avoid the voxels", "[acceptance]") {
  auto lattice = std::make_shared<Lattice>(std::array<int, 3>{40, 40, 40}, 0.5);
  lattice->setFluid(20, 20, 30, false);
  const Floor floor;
  constexpr double clearance = 1.0;
  const auto shape = makeEllipsoid(2.0, 2.0, 2.0);
  const Box box = boundingBox(shape->mesh());
  const auto certificateAt = [&](const Wall* wall, const Vec3& p) {
    const auto accepted = makeAcceptedWall(wall, lattice, 0, clearance + 0.01);
    const std::vector<PlacedCell> cells = {{0, 0, {Mat3::Identity(), p}}};
    CertificateInput input;
    input.shapes = {shape.get()};
    input.walls = {accepted.get()};
    input.cells = &cells;
    input.requiredWallGap = clearance;
    return certify(input, 2.0);
  };
  const Vec3 low(10, 10, 3.0 - box.lo.z() + 1.25), tooLow(10, 10, 3.0 - box.lo.z() + 0.75);
  CHECK(certificateAt(&floor, low).clean());
  CHECK(certificateAt(&floor, low).minimumWallGap == Approx(1.25).margin(1e-12));
  REQUIRE(certificateAt(&floor, tooLow).misplaced.size() == 1);
  CHECK(certificateAt(&floor, tooLow).misplaced[0].gap == Approx(0.75).margin(1e-12));
  CHECK(certificateAt(&floor, tooLow).misplaced[0].reason ==
        "is 0.75 µm from the wall, less than the required 1 µm");

  // 0.1 µm beyond the face of the lattice, and as far into a solid voxel: nearer to the voxels than the
  // clearance is no fault, beyond them is, however large the clearance.
  for (const Wall* wall : {static_cast<const Wall*>(&floor), static_cast<const Wall*>(nullptr)})
    for (const double inside : {0.1, -0.1}) {
      CAPTURE(inside);
      const Certificate atFace = certificateAt(wall, {-0.25 - box.lo.x() + inside, 10, 12}),
                        atVoxel = certificateAt(wall, {10, 10, 14.75 - box.hi.z() - inside});
      REQUIRE(atFace.clean() == (inside > 0.0));
      REQUIRE(atVoxel.clean() == (inside > 0.0));
      if (inside > 0.0) continue;
      CHECK(atFace.misplaced[0].reason == "a vertex lies outside the lattice");
      CHECK(atVoxel.misplaced[0].reason == "a vertex lies on a wall node");
    }
}

TEST_CASE("The accepted wall gives the same distances for blocks of nodes as for single nodes",
          "[acceptance][long]") {
  const VesselOnLattice vessel = placeVessel(prismAlongX(32, 5.0, 12.0), 0.5, 1, 40);
  const auto lattice = std::make_shared<Lattice>(vessel.lattice);
  VesselEnds ends;
  ends.lo = -0.25;
  ends.hi = ends.lo + vessel.period;
  const auto tube = makeVessel(vessel.surface, ends, 0.5);
  const auto round = makeCylinder({12.5, 10.5, 10.5}, 0, 9.8, 60.0, false);
  std::mt19937 random(6);
  for (const Wall* trueWall : {static_cast<const Wall*>(nullptr), tube->wall(), round->wall()})
    for (const int distance : {0, 1}) {
      const auto wall = makeAcceptedWall(trueWall, lattice, distance, 0.02);
      CAPTURE(distance, trueWall == nullptr, trueWall == tube->wall());
      int compared = 0;
      for (int n = 0; n < 200; ++n) {
        NodeBlock block;
        block.spacing = n % 3 == 0 ? 1.0 : 0.25;
        for (int k = 0; k < 3; ++k) {
          block.origin[k] = 0.25 * static_cast<double>(random() % 96);
          if (n % 5 == 0) block.origin[k] += 0.1;  // between the samples of the voxels
          block.nodes[k] = n % 4 == 0 ? 1 + static_cast<int>(random() % 6) : 9;
        }
        std::vector<float> found(std::size_t(block.nodes[0]) * block.nodes[1] * block.nodes[2]);
        wall->sample(block, found.data());
        std::size_t index = 0;
        for (int k = 0; k < block.nodes[2]; ++k)
          for (int j = 0; j < block.nodes[1]; ++j)
            for (int i = 0; i < block.nodes[0]; ++i, ++index) {
              const double expected = wall->distance(block.position(i, j, k)).distance;
              CAPTURE(block.position(i, j, k), block.spacing, expected, found[index]);
              if (std::abs(expected) > 0.25) continue;
              ++compared;
              // The true wall is interpolated between every other node.
              REQUIRE(found[index] == Approx(expected).margin(trueWall == tube->wall() ? 0.03 : 1e-4));
            }
      }
      REQUIRE(compared > 300);
    }
}
