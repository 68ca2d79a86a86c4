// SPDX-License-Identifier: AGPL-3.0-or-later
// What is advised about a cell that is as long as the envelope. tests/hemocell_adapter/plugin/run.sh finds
// such cells.
#include <mpi.h>

#include "packMesh/hemocell_system.h"
#include "tests/support/catch.h"

using namespace packmesh::plugin;

TEST_CASE("Cells that a pre-inlet sends again under another number are counted", "[watch_cells]") {
  MPI_Comm self = MPI_COMM_SELF;
  Watch watched{};
  watched.ranks = &self;
  watched.dx = 0.5;
  watched.particleEnvelope = 20;
  watched.nodes = {200, 60, 60};
  watched.imageSteps = {1, 100, 10000};
  watched.types.resize(1);
  watched.types[0].vertices = {{{0.0, 0.0, 0.0}}, {{16.0, 0.0, 0.0}}};
  const auto part = [](std::int64_t image, double x, double y, std::int64_t vertices) {
    CellPart one{};
    one.id = 4;
    one.image = image;
    one.vertices = vertices;
    one.lo = one.hi = {{x, y, 10.0}};
    return one;
  };
  const Watched far =
      watch(watched, {part(-2, 150.0, 10.0, 2), part(-1, 90.0, 10.0, 2), part(0, 30.0, 10.0, 2)});
  CHECK(far.counts.at(0) == 3);
  CHECK(far.incomplete == 0);
  CHECK(far.tooLong.empty());
  // In a vessel that is periodic along y, one of them crosses that face.
  watched.periodic = {false, true, false};
  const Watched crossing =
      watch(watched, {part(-1, 90.0, 2.0, 1), part(0, 30.0, 10.0, 2), part(99, 95.0, 58.0, 1)});
  CHECK(crossing.counts.at(0) == 2);
  CHECK(crossing.incomplete == 0);
  CHECK(crossing.longest == 5.0);
}

TEST_CASE("The envelope that is advised is not longer than the lattice", "[watch_cells]") {
  MPI_Comm self = MPI_COMM_SELF;
  Watch watched;
  watched.ranks = &self;
  watched.dx = 0.5;
  watched.nodes = {40, 60, 60};
  watched.periodic = {true, true, true};
  watched.imageSteps = {1, 100, 10000};
  watched.divided = {false, false, false};
  watched.types.resize(1);
  watched.types[0].name = "RBC";
  watched.types[0].vertices = {{{0.0, 0.0, 0.0}}, {{16.0, 0.0, 0.0}}};
  const auto advice = [&](int envelope, std::array<double, 3> extent) {
    watched.particleEnvelope = envelope;
    CellPart cell{};
    cell.id = 4;
    cell.vertices = 2;
    cell.hi = extent;
    return watch(watched, {cell}).message;
  };
  CHECK(advice(20, {18.0, 1.0, 1.0}).empty());
  CHECK_THAT(advice(20, {20.0, 1.0, 1.0}), Contains("Set\n  <particleEnvelope> 40 </particleEnvelope>"));
  CHECK_THAT(advice(20, {1.0, 20.0, 1.0}), Contains("Set\n  <particleEnvelope> 44 </particleEnvelope>"));
  CHECK_THAT(advice(40, {39.5, 1.0, 1.0}),
             Contains("The lattice has 40 nodes along x") && !Contains("</particleEnvelope>"));
}
