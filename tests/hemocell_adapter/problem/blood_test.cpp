// SPDX-License-Identifier: AGPL-3.0-or-later
// Cells that are added to flowing blood.
#include "hemocell_adapter/problem/blood.h"

#include <cmath>

#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

TEST_CASE("Cells that are added to blood in a pipe are as far from its wall as others, turned with it",
          "[blood]") {
  const Problem problem = planned({"--cylinder", "x", "8", "30", "--ends", "periodic", "--rbc", "2"});
  const Vec3 middle = problem.lumen.container->bounds().center();
  std::vector<Cell> there(2);
  there[1].id = 1;
  there[1].shape = 3;
  there[0].pose.position = middle + Vec3(-11, 5, 0);
  there[0].pose.orientation = Quaternion::around(Vec3(1, 2, 3).normalized(), 0.7);
  there[1].pose.position = middle + Vec3(5, 0, -2);
  const auto radial = [&](const Pose& pose) {
    Vec3 from = pose.position - middle;
    from.x() = 0.0;
    return from;
  };
  std::vector<int> like(2, 0);
  double lowest = 30.0, highest = 0.0;
  for (const Cell& cell : addLike(there, 200, problem, 0)) {
    const Pose& first = there[cell.id].pose;
    ++like[cell.id];
    CHECK(cell.shape == there[cell.id].shape);
    CHECK(radial(cell.pose).norm() == Approx(radial(first).norm()).margin(0.25));
    lowest = std::min(lowest, cell.pose.position.x());
    highest = std::max(highest, cell.pose.position.x());
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
      const Vec3 before = first.orientation * axis, now = cell.pose.orientation * axis;
      CHECK(now.x() == Approx(before.x()).margin(1e-9));
      CHECK(now.dot(radial(cell.pose).normalized()) ==
            Approx(before.dot(radial(first).normalized())).margin(1e-9));
    }
  }
  CHECK(like[0] + like[1] == 200);
  CHECK(std::abs(like[0] - like[1]) < 60);
  CHECK(lowest < 2.0);
  CHECK(highest > 28.0);
}

TEST_CASE("Without a wall nothing says where cells of blood are added", "[blood]") {
  const Problem problem = planned({"20", "30", "10", "--ends", "periodic", "--rbc", "2"});
  CHECK(addLike(std::vector<Cell>(3), 10, problem, 0).empty());
}
