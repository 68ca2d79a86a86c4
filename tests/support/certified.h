// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What holds for every packing.
#pragma once

#include "packMesh/certificate/certifier.h"
#include "packMesh/packing/pack.h"
#include "tests/support/catch.h"

namespace packmesh::test {

/// Certified anew, not as pack() says: all cells are of full size, in order, in the lumen, and as far apart
/// as they have to be.
inline void requireValid(const PackingProblem& problem, const PackingResult& result) {
  const Physics& physics = problem.physics;
  REQUIRE(result.poses.size() == result.cells.size());
  REQUIRE(result.certificate.clean());
  REQUIRE(result.certificate.cells == std::int64_t(result.cells.size()));
  REQUIRE(result.certificate.minimumGap > 0.0);
  REQUIRE(result.certificate.minimumGap >= physics.clearance);
  std::vector<const Shape*> shapes;
  for (const auto& shape : physics.shapes) shapes.push_back(shape.get());
  const std::vector<const Wall*> walls(physics.species.size(), physics.container->wall());
  CertificateInput input{
      shapes, walls, physics.container.get(), &result.cells, physics.clearance, physics.wallClearance};
  input.largestGap = result.certificate.gapsMeasuredUpTo;
  input.largestWallGap = result.certificate.wallGapsMeasuredUpTo;
  const Certificate again = certify(input);
  REQUIRE(again.clean());
  REQUIRE(again.minimumGap == result.certificate.minimumGap);
  REQUIRE(again.minimumWallGap == result.certificate.minimumWallGap);
  REQUIRE(again.minimumWallGap >= physics.wallClearance);
  double volume = 0.0;
  for (std::size_t i = 0; i < result.cells.size(); ++i) {
    const PlacedCell& cell = result.cells[i];
    const Placement& placement = cell.placement;
    REQUIRE((i == 0 || result.cells[i - 1].species <= cell.species));
    REQUIRE(physics.container->bounds().contains(placement.translation));
    REQUIRE((placement.linear * placement.linear.transpose() - Mat3::Identity()).norm() < 1e-12);
    REQUIRE(placement.linear.determinant() > 0.0);
    REQUIRE(result.poses[i].scale == 1.0);
    if (!physics.written) REQUIRE(result.poses[i].position == placement.translation);
    volume += shapes[cell.shape]->volume();
  }
  REQUIRE(result.certificate.cellVolume == Approx(volume));
}

/// Packs all cells of a problem.
inline PackingResult packAll(const PackingProblem& problem) {
  PackingResult result = pack(problem);
  REQUIRE(result.outcome == Outcome::certified);
  for (std::size_t s = 0; s < problem.physics.species.size(); ++s)
    REQUIRE(std::count_if(result.cells.begin(), result.cells.end(), [&](const PlacedCell& cell) {
              return cell.species == int(s);
            }) == problem.physics.species[s].count);
  requireValid(problem, result);
  return result;
}

}  // namespace packmesh::test
