// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/regrown_cells.h"

#include <algorithm>
#include <set>

#include "packMesh/mesh/sphere_grid.h"
#include "packMesh/packing/growth_scene.h"
#include "packMesh/parallel/periodic_images.h"
#include "packMesh/relaxation/body_state.h"

namespace packmesh {
namespace {

/// Who is seen by the growing cells [multiples of the largest radius]: their neighbours, which may make way,
/// and the neighbours of these.
constexpr double sight = 8.0;

std::set<std::int64_t> failing(const Certificate& faults) {
  std::set<std::int64_t> ids;
  for (const OverlappingPair& pair : faults.overlapping) ids.insert({pair.first, pair.second});
  for (const MisplacedCell& cell : faults.misplaced) ids.insert(cell.cell);
  return ids;
}

/// The cells of all ranks around the failing ones, and these, sorted by id.
std::vector<BodyState> cellsAround(const std::set<std::int64_t>& ids, const PackingProblem& problem,
                                   const Relaxation& relaxation) {
  const Communicator& ranks = problem.communicator;
  const Box bounds = problem.container->bounds();
  const Vec3 period = problem.container->period();
  double reach = 0.0;
  for (const Species& species : problem.species) reach = std::max(reach, sight * species.shape->radius());

  const std::vector<Body> cells = relaxation.cells();
  std::vector<BodyState> own;
  for (const Body& body : cells)
    if (ids.count(body.id) != 0) own.push_back(stateOf(body));
  std::vector<Sphere> centres;
  for (const BodyState& state : ranks.gatherAll(own)) centres.push_back({bodyOf(state).position, 0.0});
  const SphereGrid grid(centres);

  std::vector<BodyState> near;
  for (const Body& body : cells) {
    bool seen = false;
    forEachImage(body.position, reach, bounds, period, [&](const ImageShift& shift) {
      grid.forEachNear({body.position + displacement(shift, period), 0.0}, reach, [&](int) { seen = true; });
    });
    if (seen) near.push_back(stateOf(body));
  }
  near = ranks.gatherAll(near);
  std::sort(near.begin(), near.end(), [](const BodyState& a, const BodyState& b) { return a.id < b.id; });
  return near;
}

}  // namespace

std::vector<MovedCell> regrownCells(const PackingProblem& problem, const Relaxation& relaxation,
                                    const Certificate& faults, const std::function<bool()>& stop,
                                    RegrowthSums& sums) {
  const std::vector<BodyState> cells = cellsAround(failing(faults), problem, relaxation);
  GrowthState state;
  for (const BodyState& cell : cells) state.push_back({cell.species, bodyOf(cell).pose()});
  const GrowthState before = state;
  const auto indexOf = [&](std::int64_t id) {
    const auto at =
        std::lower_bound(cells.begin(), cells.end(), id,
                         [](const BodyState& cell, std::int64_t wanted) { return cell.id < wanted; });
    return static_cast<std::int64_t>(at - cells.begin());
  };
  Certificate local = faults;
  for (OverlappingPair& pair : local.overlapping) {
    pair.first = indexOf(pair.first);
    pair.second = indexOf(pair.second);
  }
  for (MisplacedCell& cell : local.misplaced) cell.cell = indexOf(cell.cell);

  const GrowthScene scene = growthSceneOf(problem);
  TetrahedraSums tetrahedra;
  const BuilderFactory factory = [&](const GrowthScene& part) {
    return makeBuilder(problem.builder, part, tetrahedra);
  };
  if (!regrow(scene, problem.growth, factory, stop, local, state, sums)) return {};
  std::vector<MovedCell> moved;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Pose &a = before[i].pose, &b = state[i].pose;
    if (a.position != b.position || a.orientation.coeffs() != b.orientation.coeffs())
      moved.push_back({cells[i].id, a, b});
  }
  return moved;
}

}  // namespace packmesh
