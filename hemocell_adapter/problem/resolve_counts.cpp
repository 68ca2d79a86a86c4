// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/resolve_counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/problem/counts.h"
#include "hemocell_adapter/problem/forecast.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// Refuses a cell that cannot be in the lumen in any orientation: a ball inside it is wider than the lumen
/// along an axis, or it is longer than the diagonal.
void refuseTooLarge(const Problem& problem, const CellSpecies& species) {
  const Container& container = *problem.lumen.container;
  const Vec3 cell = boundingBox(species.shape->mesh()).size();
  const Vec3 room = container.bounds().size();
  constexpr double surely = 0.98;  // depths inside meshes are interpolated
  const double ball = 2.0 * surely * species.shape->halfThickness();
  bool fits = true, endless = false;
  for (int k = 0; k < 3; ++k) {
    const bool periodic = container.period()[k] > 0.0;
    endless = endless || periodic;
    fits = fits && (periodic || ball < room[k]);
  }
  if (fits && (endless || cell.maxCoeff() < room.norm())) return;
  throw InputError(fmt::format(
      "cell '{}' is {:.4g} x {:.4g} x {:.4g} µm, larger than the lumen ({:.4g} x {:.4g} x {:.4g} µm)",
      species.name, cell[0], cell[1], cell[2], room[0], room[1], room[2]));
}

/// Refuses a kind of cell of which HemoCell would delete every one, wherever it is.
void refuseWithoutNode(const CellSpecies& species) {
  if (!species.acceptance || species.acceptance->allowedNodes().hasFluidNodes()) return;
  throw InputError(
      fmt::format("cell '{}': no node of the lattice is further than {} µm from all solid nodes, "
                  "so HemoCell would delete every such cell",
                  species.name, species.minimumDistanceFromSolid));
}

/// Refuses more cells of a kind than any known packing has, ordered ones included. Ellipsoids fill at most
/// this part of space (Donev, Stillinger, Chaikin, Torquato: Phys. Rev. Lett. 92, 255506, 2004), red cells
/// less (docs/explanation/speed.md, crystals); meshes of other shapes may fill more. A few cells may fit a
/// lumen with walls exactly.
void refuseBeyondKnown(const CellSpecies& species, const Container& lumen) {
  constexpr double densestKnown = 0.7707, rounding = 1e-9;
  constexpr std::int64_t many = 100;
  const double part = double(species.count) * species.meanVolume / lumen.volume();
  using Template = CellSpecies::Template;
  const bool byFormula =
      species.kind == Template::ellipsoid ||
      (species.kind == Template::model && species.model.construction != Construction::meshFromStl);
  const bool fillsSpace =
      lumen.period().minCoeff() > 0.0 || lumen.volume() > (1.0 - rounding) * lumen.bounds().size().prod();
  if (part > densestKnown && byFormula && (fillsSpace || species.count >= many))
    throw InfeasibleError(fmt::format(
        "the requested cells '{}' fill {:.4f} of the lumen; no packing of such cells beyond {:.4f} is "
        "known. Reduce the number; " +
            named("best-effort") + " packs as many as possible",
        species.name, part, densestKnown));
}

}  // namespace

void guessVolumes(Problem& problem) {
  for (CellSpecies& species : problem.species) {
    double sum = 0.0;
    std::size_t cells = 0;
    const auto add = [&](int shape) {
      sum += shape < 0 ? species.shape->volume() : problem.shapes[shape]->volume();
      ++cells;
    };
    for (const auto* const present : {&species.fixed, &species.start, &species.blood.crowded})
      for (const PresentCell& cell : *present) add(cell.shape);
    if (cells == 0)
      for (const int shape : species.blood.shapes) add(shape);
    if (cells == 0) continue;
    species.meanVolume = sum / double(cells);
    if (!(species.redCell && problem.request.redCellVolume)) species.countedVolume = species.meanVolume;
  }
}

std::vector<std::int64_t> numbersOfCells(const Problem& problem) {
  double reference = problem.referenceVolume();
  if (problem.request.packCellsConventions && problem.request.boxSize)
    reference = problem.request.boxSize->prod();
  std::optional<double> hematocrit = problem.request.hematocrit;
  if (!problem.lumen.regions.empty()) {
    *hematocrit = 0.0;
    for (const LumenRegion& region : problem.lumen.regions) *hematocrit += region.share * region.hematocrit;
  }
  return countCells(problem.species, hematocrit, reference);
}

void examineNumbers(Problem& problem) {
  double volume = 0.0;
  std::set<const Acceptance*> examined;
  for (const CellSpecies& species : problem.species) {
    volume += double(species.count) * species.meanVolume;
    if (species.mostCells() == 0) continue;
    refuseTooLarge(problem, species);
    if (examined.insert(species.acceptance.get()).second) refuseWithoutNode(species);
  }
  const double lumen = problem.lumen.container->volume();
  if (volume >= lumen) {
    throw InfeasibleError(fmt::format(
        "the requested cells have a volume of {:.6g} µm³, the lumen only {:.6g} µm³", volume, lumen));
  }
  if (!problem.request.bestEffort)
    for (const CellSpecies& species : problem.species) refuseBeyondKnown(species, *problem.lumen.container);
  if (volume > Forecast::possible * lumen && !problem.request.inColumns) {
    problem.notices.push_back(
        fmt::format("the requested cells fill {:.4f} of the lumen: above {:.2f} no random packing of red "
                    "cells is known; " +
                        named("max-time") + " and " + named("best-effort") + " limit the run time{}",
                    volume / lumen, Forecast::possible, columnsInstead(problem)));
  }
}

}  // namespace packmesh::hemocell
