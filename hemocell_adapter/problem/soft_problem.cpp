// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/soft_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/problem/make_species.h"
#include "hemocell_adapter/problem/parts.h"

namespace packmesh::hemocell {

std::vector<SoftSpecies> softSpeciesOf(const Problem& problem, const PartsToPack& packed) {
  std::vector<SoftSpecies> soft;
  for (const Part& part : packed.parts) {
    const CellSpecies& species = problem.species[part.species];
    soft.push_back({membraneOf(problem, species), species.rigid});
  }
  return soft;
}

namespace {

/// The species with these cells, which are all there; fixed ones stay.
std::vector<SpeciesPlan> softPlans(const Problem& problem, const PartsToPack& packed,
                                   const std::vector<Cell>& cells) {
  std::vector<SpeciesPlan> plans(problem.species.begin(), problem.species.end());
  for (std::size_t s = 0; s < plans.size(); ++s) {
    SpeciesPlan& species = plans[s];
    species.start.clear();
    for (PresentCell& cell : species.fixed) {
      if (cell.shape < 0) continue;
      cell.vertices = problem.shapes[cell.shape]->mesh().vertices;
      cell.shape = -1;
    }
    species.ownTriangles = problem.species[s].shape->mesh().triangles;
    species.blood = {};
    species.startFrom = "packing soft cells";
    species.stock = 0;
  }
  for (const Cell& cell : cells) {
    std::vector<PresentCell>& start = plans[packed.parts[cell.species].species].start;
    // The angles of a line stand for a rotation up to rounding, which the vertices make up for.
    const PosLine line = posLineOf(cell.pose);
    const Mat3 turned = placementOf(line).linear.transpose() * cell.pose.orientation.toRotationMatrix();
    start.emplace_back(line);
    for (const Vec3& v : cell.vertices) start.back().vertices.push_back(turned * v);
  }
  return plans;
}

/// Deviations that packing undeformed cells tolerates, and that are not worth telling [µm; rad].
constexpr double littleOutside = 0.01, littleTurned = 1e-3;

}  // namespace

std::optional<std::string> strayWarning(const Problem& problem, const PartsToPack& packed,
                                        const std::vector<Cell>& cells) {
  std::int64_t outside = 0, turned = 0;
  for (const Cell& cell : cells) {
    const Freedom& freedom = packed.parts[cell.species].cells.freedom;
    if (freedom.region && freedom.region->distance(cell.pose.position).distance < -littleOutside) ++outside;
    if (freedom.cone && freedom.cone->angle(cell.pose.orientation) > freedom.cone->spread + littleTurned)
      ++turned;
  }
  std::string text;
  if (outside > 0)
    text = fmt::format("{} of {} cells have their centres outside of their {}", outside, cells.size(),
                       problem.layout.profile ? "layers of the profile" : "regions");
  if (turned > 0)
    text += fmt::format("{}{} of {} cells are turned beyond their spread", text.empty() ? "" : ", ", turned,
                        cells.size());
  if (text.empty()) return {};
  return text + ": soft cells are kept to these only until they grow";
}

const SoftStatistics& statisticsOfSoft(const PackingResult& packed) {
  return dynamic_cast<const SoftStatistics&>(
      *(packed.deformed ? packed.deformed->engine : packed.statistics.engine));
}

std::string failureOf(const SoftStatistics& packed, const SoftLimits& limits) {
  const std::string after = fmt::format(" after {} iterations", packed.done);
  if (packed.scale == 0.0) return "the small undeformed cells from which soft ones grow could not be packed";
  if (packed.scale < 1.0)
    return fmt::format("the cells had grown to {:.2f} of their size", packed.scale) + after;
  if (packed.meetsWall) return "edges of a membrane met the steps of the wall" + after;
  if (!(packed.most.force <= limits.force))
    return fmt::format("the largest force on a vertex was {:.2f} pN", packed.most.force) + after +
           fmt::format(", and {:.6g} pN are allowed ({})", limits.force, named("max-force"));
  if (packed.succeeded) return "some cells failed the exact test" + after;
  if (limits.allow(packed.most)) return "the cells have their full size, but had not come to rest" + after;
  const bool ofVolume = !(std::abs(packed.most.volume) <= limits.volume);
  return fmt::format("the {} of a cell changed by {:.2f} %", ofVolume ? "volume" : "area",
                     100.0 * (ofVolume ? packed.most.volume : packed.most.area)) +
         after +
         fmt::format(", and {:.6g} % are allowed ({})", 100.0 * (ofVolume ? limits.volume : limits.area),
                     named(ofVolume ? "max-volume-change" : "max-area-change"));
}

SoftLimits softLimitsOf(const Request& request) {
  SoftLimits limits;
  limits.force = request.maxForce;
  limits.volume = request.maxVolumeChange;
  limits.area = request.maxAreaChange;
  limits.aim = std::min(limits.aim, 0.9 * limits.force);
  return limits;
}

std::shared_ptr<const Engine> softEngine(const Problem& problem, const PartsToPack& packed,
                                         std::function<Physics(const std::vector<Cell>&)> written) {
  auto engine = std::make_shared<SoftEngine>();
  engine->species = softSpeciesOf(problem, packed);
  engine->limits = softLimitsOf(problem.request);
  engine->written = std::move(written);
  return engine;
}

Problem problemOfSoftCells(const Problem& problem, const PartsToPack& packed,
                           const std::vector<Cell>& cells) {
  return withOtherCells(problem, softPlans(problem, packed, cells), packed.clearances);
}

}  // namespace packmesh::hemocell
