// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/small_cells.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/packing/pack.h"
#include "packMesh/packing/problem_digest.h"

namespace packmesh {
namespace {

/// Share of the lumen that small undeformed cells may fill: packing them takes milliseconds per cell. And the
/// one up to which it is tried whether deformation is needed at all.
constexpr double easyFraction = 0.52, possibleFraction = 0.58;
/// They are made smaller by this factor until they can be packed, and not smaller than `smallestStart`.
constexpr double smaller = 0.85, smallestStart = 0.25;
/// Sweeps for that at full size, where the result may need no deformation, and for smaller cells: where these
/// need more, still smaller ones are sooner packed and grown.
constexpr std::int64_t sweepsForResult = 3000, sweepsForStart = 100;
/// Gap that they begin with, as a share of the range of the barrier; and distance from walls of cubes, as a
/// share of the reach of the smoothed wall: it usually suffices, or Wall::smoothedBelow does.
constexpr double startGap = 0.35, usualStart = 1.3;
/// Share of the mean gap that is possible at a hematocrit which the range of barriers may have: in the
/// corners between cells gaps are wider.
constexpr double shareOfMeanGap = 0.8;
/// Where cells fill less of the lumen, contacts are so few that it takes longest to list them.
constexpr double sparse = 0.5;
/// The least range, as a share of the usual one.
constexpr double leastRange = 0.2;
constexpr int seedBits = 62;  // that nobody uses, so that attempts of one seed are not those of others

/// Of what is not in the physics.
std::string digestOf(const std::vector<SoftSpecies>& softness) {
  Digest digest;
  for (const SoftSpecies& one : softness) {
    const MembraneConstants& m = one.membrane;
    for (const double constant : {m.link, m.bend, m.volume, m.area, m.thermalEnergy, m.spacing})
      digest.add(constant);
    if (m.model != MembraneModel::highOrder) {
      digest.add(int(m.model));
      for (const auto& end : m.innerLinks)
        for (const int v : end) digest.add(v);
      for (const MembraneConstants::Core& core : {m.cytoskeleton, m.core})
        for (const double constant : {core.force, core.radius}) digest.add(constant);
    }
    digest.add(one.rigid);
  }
  return digest.text();
}

/// Ranges of barriers for which there is room.
SoftSettings settingsOf(const Physics& physics, double volume, double area) {
  SoftSettings settings;
  // A uniform gap g around membranes of this area leaves room for a fraction of V / (V + A g / 2).
  const double meanGap = 2.0 * (physics.container->volume() - volume) / area;
  const double part = std::clamp(shareOfMeanGap * meanGap / settings.range, leastRange, 1.0);
  settings.range *= part;
  settings.edgeRange *= part;
  settings.wallRange *= part;
  settings.clearance = physics.clearance;
  if (volume / physics.container->volume() < sparse) settings.skin *= 2.0;
  for (std::size_t s = 0; s < physics.species.size(); ++s)
    if (const double reach = physics.smoothReachOf(int(s)); reach > 0.0)
      settings.wallRange = std::min(settings.wallRange, reach);
  return settings;
}

/// The physics of small cells.
Physics physicsAt(const SoftModel& model, int attempt, double scale, double ofSmoothed) {
  // Those of full size are a result, if there are any.
  const double gap = scale == 1.0 ? 0.0 : startGap * model.settings.range * scale;
  Physics small = scaledPhysics(model.physics, model.grows, scale, gap, ofSmoothed);
  small.seed += std::uint64_t(attempt) << seedBits;
  return small;
}

/// Whether cells at less than their size keep to the smoothed walls of their species.
bool areWithinWalls(const SoftModel& model, const SmallCells& small) {
  std::atomic<bool> within = true;
  model.problem.execution.threads.forEach(std::int64_t(small.placed.size()), [&](std::int64_t i, int) {
    const BodyState& cell = small.placed[i];
    if (small.scale == 1.0 || !model.isSoft(cell) || model.physics.smoothReachOf(cell.species) == 0.0) return;
    for (const Vec3& v : small.vertices(cell))
      if (model.walls[model.wallOf[cell.species]](v).distance <= 0.0) within = false;
  });
  return within;
}

std::optional<SmallCells> packedAt(const SoftModel& model, const RunControl& control, int attempt,
                                   double scale, double ofSmoothed) {
  const Execution& execution = model.problem.execution;
  PackingProblem small{physicsAt(model, attempt, scale, ofSmoothed), nullptr, execution};
  if (execution.progress)
    small.execution.progress = [&, scale](Progress progress) {
      progress.scale *= scale;
      execution.progress(progress);
    };
  Limits& limits = small.execution.limits;
  limits.fewerCells = limits.someCloser = false;
  limits.maxSweeps = std::min(scale == 1.0 ? sweepsForResult : sweepsForStart, limits.maxSweeps);
  if (control.limited())
    limits.maxSeconds = std::max(Limits::leastSeconds, limits.maxSeconds - control.elapsed());
  PackingResult packed;
  try {
    packed = pack(small);
  } catch (const InputError&) {  // too large for the lumen
    if (scale * smaller <= smallestStart) throw;
    return {};
  }
  if (packed.outcome != Outcome::certified) return {};
  const Communicator& ranks = execution.communicator;
  std::int64_t id = ranks.sumBefore({std::int64_t(packed.cells.size())}).front();
  std::vector<BodyState> own;
  for (std::size_t i = 0; i < packed.cells.size(); ++i)
    own.push_back(stateOf(id++, packed.cells[i].species, packed.cells[i].shape, packed.poses[i]));
  return SmallCells{attempt, scale, std::move(small.physics), ranks.gatherAll(own)};
}

/// Packs undeformed cells at a scale. @return nothing if that is not easy
std::optional<SmallCells> packedAt(const SoftModel& model, const RunControl& control, int attempt,
                                   double scale) {
  for (const double ofSmoothed : {usualStart, Wall::smoothedBelow}) {
    std::optional<SmallCells> packed = packedAt(model, control, attempt, scale, ofSmoothed);
    if (!packed || areWithinWalls(model, *packed)) return packed;
  }
  return {};
}

}  // namespace

SoftModel::SoftModel(const PackingProblem& of, const std::vector<SoftSpecies>& species)
    : problem(of), physics(of.physics), membranesDigest(digestOf(species)) {
  double volume = 0.0, area = 0.0;
  const double lumen = physics.container->volume();
  for (std::size_t s = 0; s < physics.species.size(); ++s) {
    const Species& one = physics.species[s];
    const Shape& shape = *physics.shapes[one.shape];
    const Shape& undeformed = shape.undeformed() ? *shape.undeformed() : shape;
    membranes.push_back(std::make_shared<const Membrane>(undeformed.mesh(), species[s].membrane));
    grows.push_back(!one.freedom.fixed && !species[s].rigid);
    const double ofSpecies = double(one.count) * membranes.back()->volume();
    volume += ofSpecies;
    if (one.freedom.fixed) fixed += ofSpecies / lumen;
    if (grows.back()) growing += ofSpecies;
    area += double(one.count) * membranes.back()->area();
  }
  filled = volume / lumen;
  growing /= lumen;
  settings = settingsOf(physics, volume, area);
  for (int s = 0; s < int(physics.species.size()); ++s) {
    const auto gap = wallGapOf(physics, s);
    wallOf.push_back(gap ? int(walls.size()) : -1);
    if (gap) walls.push_back(*gap);
  }
}

SoftCell SoftModel::cell(const BodyState& placed, std::vector<Vec3> vertices, double scale) const {
  const int s = placed.species;
  return {membranes[s], std::move(vertices), grows[s] ? scale : 1.0, !grows[s], grows[s] ? wallOf[s] : -1};
}

std::vector<Vec3> SmallCells::vertices(const BodyState& cell) const {
  return placedVertices(physics.shapeOf(cell).mesh(), cell.pose().placement());
}

std::optional<SmallCells> packSmallCells(const SoftModel& model, RunControl& control, int attempt,
                                         double scaleBefore) {
  if (model.growing == 0.0) return {};
  // Of the lumen that is left by cells that do not grow.
  const double left = std::max(0.0, 1.0 - (model.filled - model.growing));
  double scale =
      attempt == 0 ? std::min(smaller, std::cbrt(easyFraction * left / model.growing)) : scaleBefore;
  for (; scale > smallestStart && !control.stopped(); scale *= smaller)
    if (auto packed = packedAt(model, control, attempt, scale)) return packed;
  return {};
}

SmallCells smallCellsOf(const SoftModel& model, int attempt, double scale, std::vector<BodyState> placed) {
  SmallCells small{attempt, scale, physicsAt(model, attempt, scale, usualStart), std::move(placed)};
  for (BodyState& cell : small.placed) {
    cell.scale = 1.0;  // of the small shapes
    if (model.isSoft(cell)) cell.shape = small.physics.species[cell.species].shape;
  }
  return small;
}

bool canPackUndeformed(const PackingProblem& problem, const std::vector<SoftSpecies>& species) {
  const SoftModel model(problem, species);
  const RunControl control(problem);
  return model.filled - model.fixed <= possibleFraction * (1.0 - model.fixed) &&
         packedAt(model, control, 0, 1.0).has_value();
}

}  // namespace packmesh
