// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/shared_cells.h"

#include "packMesh/container/primitives.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/parallel/blocks.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

/// Points at random, the same on all ranks.
std::vector<PlacedCell> scattered(int count, const Box& box) {
  std::mt19937_64 random(7);
  std::vector<PlacedCell> cells;
  for (int i = 0; i < count; ++i) {
    PlacedCell cell{0, 0, {}};
    cell.placement.linear = Mat3::Identity();
    for (int k = 0; k < 3; ++k)
      cell.placement.translation[k] = box.lo[k] + box.size()[k] * double(random() % 10000) / 10000.0;
    cells.push_back(cell);
  }
  return cells;
}

double distance(const Vec3& a, const Vec3& b, const Vec3& period) {
  return nearestImage(a - b, period).norm();
}

}  // namespace

TEST_CASE("Every rank gets a part of the cells, and all that are near them", "[mpi][certificate][long]") {
  const Communicator ranks = Communicator::world();
  const bool periodic = GENERATE(true, false);
  const Box bounds{Vec3(-5, 0, 3), Vec3(55, 30, 43)};
  Physics physics;
  physics.add("ball", test::sphereShape(1.0), 0);
  physics.container = makeBox(bounds, {periodic, periodic, periodic});
  constexpr double gap = 0.5;
  const int count = GENERATE(0, 1, 12000);  // the last are sent in several messages
  const std::vector<PlacedCell> all = scattered(count, bounds);
  const auto [first, end] = IdShares(count, ranks).own();
  const std::vector<PlacedCell> own(all.begin() + first, all.begin() + end);
  const SharedCells here = sharedInSpace(own, physics, gap, ranks);

  REQUIRE(here.own.size() == here.cells.size());
  REQUIRE(here.numbers.size() == here.cells.size());
  REQUIRE(here.origins.size() == here.cells.size());
  CHECK(std::is_sorted(here.numbers.begin(), here.numbers.end()));
  CHECK(std::adjacent_find(here.numbers.begin(), here.numbers.end()) == here.numbers.end());
  std::vector<std::int64_t> owners(count, 0);
  std::vector<bool> known(count, false);
  for (std::size_t i = 0; i < here.cells.size(); ++i) {
    const std::int64_t number = here.numbers[i];
    known[number] = true;
    if (here.own[i]) ++owners[number];
    const auto [begin, stop] = IdShares(count, ranks).of(here.origins[i].rank);
    REQUIRE(number == begin + here.origins[i].index);
    REQUIRE(number < stop);
    REQUIRE(here.cells[i].placement.translation == all[number].placement.translation);
  }
  std::int64_t missing = 0;
  for (int i = 0; i < count; ++i)
    for (int j = 0; owners[i] > 0 && j < count; ++j)
      missing += !known[j] && distance(all[i].placement.translation, all[j].placement.translation,
                                       physics.container->period()) < 2.0 * physics.shapes[0]->radius() + gap;
  CHECK(missing == 0);
  const auto ownHere = std::int64_t(std::count(here.own.begin(), here.own.end(), true));
  if (count > 1) CHECK(ownHere * ranks.size() < 1.1 * count);
  if (count > 1 && ranks.size() == 2) CHECK(here.cells.size() < 0.75 * count);
  ranks.sum(owners);
  CHECK(std::all_of(owners.begin(), owners.end(), [](std::int64_t n) { return n == 1; }));
}
