// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/barrier_relaxation.h"

#include <algorithm>

#include "packMesh/certificate/certify.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/relaxation/relaxation.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

/// Number of repair rounds, and sweeps in each.
constexpr int repairRounds = 8;
constexpr std::int64_t repairSweeps = 100;

RelaxationInput inputOf(const GrowthScene& scene) {
  RelaxationInput input;
  input.shapes = scene.shapes;
  input.walls = scene.walls;
  input.freedoms = scene.freedoms;
  input.bounds = scene.container->bounds();
  input.period = scene.container->period();
  input.clearance = scene.clearance + tolerance::relaxationMargin;
  input.wallClearance = scene.wallClearance + tolerance::relaxationMargin;
  input.rotate = scene.rotate;
  return input;
}

/// The cell without what relaxation has cached about its surroundings.
Body bare(const Body& body) {
  Body out = makeBody(body.id, body.species, body.pose());
  out.stepTaken = body.stepTaken;
  return out;
}

std::vector<Body> bare(std::vector<Body> bodies) {
  for (Body& body : bodies) body = bare(body);
  return bodies;
}

/// Violations of the cells in their current state, by id.
Certificate faultsOf(Relaxation& relaxation, const GrowthScene& scene) {
  relaxation.dropLists();  // afterwards every rank has the cells around its own
  std::vector<PlacedCell> cells;
  std::vector<bool> own;
  std::vector<std::int64_t> ids;
  for (const Body& body : relaxation.cellsAround()) {
    cells.push_back({body.species, scene.placement(body.pose())});
    own.push_back(relaxation.owns(body));
    ids.push_back(body.id);
  }
  CertificateInput input = scene.certificateInput();
  input.cells = &cells;
  input.own = &own;
  return ofAllRanks(certify(input, scene.clearance), ids, scene.communicator);
}

}  // namespace

bool relaxAtScale(const GrowthScene& scene, double scale, int sweeps, const std::function<bool()>& stop,
                  GrowingCells& cells) {
  std::vector<Body> bodies = bare(cells.own());
  for (Body& body : bodies)
    if (!scene.isFixed(body)) body.scale = std::max(body.scale, scale);
  Relaxation relaxation(inputOf(scene), std::move(bodies), scene.communicator);
  ScheduleLimits limits;
  limits.stop = stop;
  limits.maxSweeps = sweeps;
  if (!relax(relaxation, tolerance::relaxationTolerance, limits)) return false;
  for (int round = 0; round < repairRounds; ++round) {
    const Certificate faults = faultsOf(relaxation, scene);
    if (faults.clean()) {
      cells.replace(bare(relaxation.cells()));
      return true;
    }
    for (const OverlappingPair& pair : faults.overlapping)
      relaxation.demandClearance(pair.first, pair.second, tolerance::repairClearance);
    for (const MisplacedCell& cell : faults.misplaced)
      relaxation.demandWallClearance(cell.cell, tolerance::repairClearance);
    limits.maxSweeps = relaxation.sweeps() + repairSweeps;
    if (!settle(relaxation, tolerance::relaxationTolerance, repairSweeps, limits)) return false;
  }
  return false;
}

}  // namespace packmesh
