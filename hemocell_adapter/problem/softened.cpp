// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/softened.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/problem/parts.h"

namespace packmesh::hemocell {
namespace {

/// HemoCell deletes cells with a vertex on a solid node: a vertex this far from the wall is on none [dx].
const double wallRoom = std::sqrt(0.5);
/// Iterations with that room; in capillaries that leave no room for it, cells may be nearer to the wall.
constexpr std::int64_t iterationsWithRoom = 4000;

std::vector<MembraneConstants> membranesOf(const Problem& problem, const PackedParts& packed) {
  std::vector<MembraneConstants> membranes;
  for (const Part& part : packed.parts) {
    const CellSpecies& species = problem.species[part.species];
    membranes.push_back(species.kind == SpeciesPlan::Template::model ? species.model.membrane
                                                                     : defaultMembrane(species.name));
    membranes.back().spacing = problem.request.dx;
  }
  return membranes;
}

/// The species with these cells, which are all there; fixed ones stay.
std::vector<SpeciesPlan> softPlans(const Problem& problem, const PackedParts& packed,
                                   const std::vector<SoftlyPackedCell>& cells) {
  std::vector<SpeciesPlan> plans(problem.species.begin(), problem.species.end());
  for (std::size_t s = 0; s < plans.size(); ++s) {
    SpeciesPlan& species = plans[s];
    species.start.clear();
    species.ownTriangles = problem.species[s].shape->mesh().triangles;
    species.blood = {};
    species.startFrom = "packing soft cells";
    species.ratio.reset();
    species.stock = 0;
  }
  for (const SoftlyPackedCell& cell : cells) {
    std::vector<PresentCell>& start = plans[packed.parts[cell.species].species].start;
    // The angles of a line stand for a rotation up to rounding, which the vertices make up for.
    const PosLine line = posLineOf(cell.pose);
    const Mat3 turned = placementOf(line).linear.transpose() * cell.pose.orientation.toRotationMatrix();
    start.emplace_back(line);
    for (const Vec3& v : cell.vertices) start.back().vertices.push_back(turned * v);
  }
  for (SpeciesPlan& species : plans)
    species.statedCount = std::int64_t(species.fixed.size() + species.start.size());
  return plans;
}

}  // namespace

std::vector<std::string> deformationLines(const std::vector<SoftlyPackedCell>& cells) {
  std::vector<double> forces;
  Deformation most;
  const auto enlarge = [](double& largest, double change) {
    if (std::abs(change) > std::abs(largest)) largest = change;
  };
  for (const SoftlyPackedCell& cell : cells) {
    const Deformation& d = cell.deformation;
    forces.push_back(d.force);
    enlarge(most.volume, d.volume);
    enlarge(most.area, d.area);
    enlarge(most.triangle, d.triangle);
    enlarge(most.edge, d.edge);
  }
  std::sort(forces.begin(), forces.end());
  return {
      fmt::format("Soft cells: {} deformed; largest force on a vertex {:.2f} pN (median of cells {:.2f} pN)",
                  cells.size(), forces.back(), forces[forces.size() / 2]),
      fmt::format("Largest changes: volume {:+.2f} %, area {:+.2f} %, triangle {:+.1f} %, edge {:+.1f} %",
                  100.0 * most.volume, 100.0 * most.area, 100.0 * most.triangle, 100.0 * most.edge)};
}

std::optional<Problem> softened(const Problem& problem, const std::function<bool()>& interrupted,
                                const std::function<void(const Progress&)>& progress,
                                std::vector<std::string>& lines) {
  std::vector<Clearances> levels = {problem.demanded};
  if (problem.request.choosesWallClearance() && problem.lumen.solidWalls && problem.lumen.container->wall()) {
    levels.insert(levels.begin(), problem.demanded);
    levels.front().wall = std::max(problem.demanded.wall, wallRoom * problem.request.dx);
  }
  for (std::size_t n = 0; n < levels.size(); ++n) {
    const PackedParts packed = partsAt(problem, problem.layout, levels[n]);
    SoftLimits limits;
    limits.force = problem.request.maxForce;
    limits.aim = std::min(limits.aim, 0.9 * limits.force);
    if (n + 1 < levels.size()) limits.iterations = iterationsWithRoom;
    const SoftPacking soft = packSoft(packingProblemOf(problem, packed, interrupted, progress),
                                      membranesOf(problem, packed), limits);
    if (soft.outcome == Outcome::interrupted) return {};
    if (soft.outcome != Outcome::certified) continue;
    if (soft.cells.empty()) return problem;
    lines = deformationLines(soft.cells);
    CompletedRequest there{problem.request, problem.simulation, {}, {}};
    there.request.regions.clear();
    there.request.inColumns = false;
    there.request.profile.reset();
    there.request.dischargeHematocrit.reset();
    there.request.hematocrit.reset();
    there.preInlet = problem.preInlet;
    return problemWithCells(there, softPlans(problem, packed, soft.cells), levels[n], problem.ranks);
  }
  return {};
}

}  // namespace packmesh::hemocell
