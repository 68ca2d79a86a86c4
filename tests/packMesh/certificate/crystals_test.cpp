// SPDX-License-Identifier: AGPL-3.0-or-later
#include <nlohmann/json.hpp>

#include "packMesh/mesh/mesh_intersection.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

struct Crystal {
  Mat3 lattice;  ///< columns: lattice vectors [µm]
  std::vector<Placement> cells;
  double stated;  ///< volume fraction
};

Vec3 vectorOf(const nlohmann::json& j) {
  return Vec3(j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>());
}

Crystal read(int cells) {
  std::ifstream in(test::sourceFolder + std::string("/config/crystals/red_cells_") + std::to_string(cells) +
                   ".json");
  const nlohmann::json file = nlohmann::json::parse(in);
  Crystal crystal;
  crystal.stated = file.at("volumeFraction");
  for (int k = 0; k < 3; ++k) crystal.lattice.col(k) = vectorOf(file.at("latticeVectors").at(k));
  for (std::size_t i = 0; i < file.at("positions").size(); ++i) {
    const nlohmann::json& q = file.at("rotations").at(i);
    Pose pose;
    pose.orientation = Quaternion(q.at(3).get<double>(), q.at(0).get<double>(), q.at(1).get<double>(),
                                  q.at(2).get<double>());
    pose.position = vectorOf(file.at("positions").at(i));
    crystal.cells.push_back(pose.placement());
  }
  return crystal;
}

double fractionOf(const Crystal& crystal) {
  return double(crystal.cells.size()) * test::redCellShape()->volume() /
         std::abs(crystal.lattice.determinant());
}

/// Pairs of cells of the infinite crystal that could meet, the first of them in the unit cell; and how many
/// of these do meet.
struct Pairs {
  int near = 0, meeting = 0;
};
Pairs examine(const Crystal& crystal) {
  const Shape& shape = *test::redCellShape();
  const double reach = 2.0 * shape.reach();
  const Mat3 inverse = crystal.lattice.inverse();
  Pairs pairs;
  for (std::size_t i = 0; i < crystal.cells.size(); ++i)
    for (std::size_t j = i; j < crystal.cells.size(); ++j) {
      const Vec3 between = crystal.cells[i].translation - crystal.cells[j].translation;
      const Vec3 inPeriods = inverse * between;
      int lo[3], hi[3];
      for (int k = 0; k < 3; ++k) {
        const double range = inverse.row(k).norm() * reach;
        lo[k] = int(std::floor(inPeriods[k] - range));
        hi[k] = int(std::ceil(inPeriods[k] + range));
      }
      for (int a = lo[0]; a <= hi[0]; ++a)
        for (int b = lo[1]; b <= hi[1]; ++b)
          for (int c = lo[2]; c <= hi[2]; ++c) {
            const Vec3 shift = crystal.lattice * Vec3(a, b, c);
            if (i == j && a == 0 && b == 0 && c == 0) continue;
            if ((between - shift).norm() > reach) continue;
            Placement image = crystal.cells[j];
            image.translation += shift;
            ++pairs.near;
            pairs.meeting += relate(shape.hierarchy(), crystal.cells[i], shape.hierarchy(), image).relation !=
                             MeshRelation::apart;
          }
    }
  return pairs;
}

}  // namespace

TEST_CASE("crystals of red cells are denser than columns and free of overlap", "[crystals]") {
  constexpr double columns = 0.6676;
  const int cells = GENERATE(1, 2);
  const Crystal crystal = read(cells);
  REQUIRE(crystal.cells.size() == std::size_t(cells));
  CHECK(fractionOf(crystal) == Approx(crystal.stated).margin(1e-5));
  CHECK(fractionOf(crystal) > columns + 0.04);
  const Pairs pairs = examine(crystal);
  CHECK(pairs.near >= 12 * cells);
  CHECK(pairs.meeting == 0);
}

TEST_CASE("crystals of red cells cannot be compressed by a thousandth", "[crystals]") {
  Crystal crystal = read(GENERATE(1, 2));
  crystal.lattice *= 0.999;
  for (Placement& cell : crystal.cells) cell.translation *= 0.999;
  CHECK(examine(crystal).meeting > 0);
}
