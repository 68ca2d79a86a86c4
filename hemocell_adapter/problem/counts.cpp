// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

std::int64_t rounded(double cells, const std::string& name) {
  if (!(cells <= specs::largestCount)) {
    throw InputError(fmt::format("{:.3g} cells of '{}' are too many; at most {:.0f} can be packed", cells,
                                 name, specs::largestCount));
  }
  return std::llround(cells);
}

/// The red cells of a request.
struct RedCells {
  const CellSpecies* filler = nullptr;         ///< determined by the hematocrit
  double countedVolume = 0.0, counted = 0.0;   ///< of those with a count [µm³]; cells
  double ratioVolume = 0.0, ratioShare = 0.0;  ///< of those with a ratio: per red cell of any species
};

RedCells redCellsOf(const std::vector<CellSpecies>& species) {
  RedCells red;
  for (const CellSpecies& s : species) {
    if (!s.sharesHematocrit) continue;
    const auto counted = double(s.statedCount.value_or(0) + s.ofRegions);
    red.countedVolume += counted * s.countedVolume;
    red.counted += counted;
    if (s.statedCount) {
      continue;
    } else if (s.ratio) {
      red.ratioVolume += *s.ratio * s.countedVolume;
      red.ratioShare += *s.ratio;
    } else if (red.filler) {
      throw InputError(
          fmt::format("the hematocrit cannot determine both '{}' and '{}': give one a count or a ratio",
                      red.filler->name, s.name));
    } else {
      red.filler = &s;
    }
  }
  if (red.ratioShare >= 1.0)
    throw InputError(fmt::format(
        "the ratios of red cells add up to {:.15g}: each is a share of all red cells, so together "
        "they must be below 1",
        red.ratioShare));
  return red;
}

/// Number of red cells of all species, before rounding.
double redCellNumber(const RedCells& red, std::optional<double> hematocrit, double lumenVolume) {
  const double others = 1.0 - red.ratioShare;
  if (!red.filler || !hematocrit) return red.counted / others;
  // T red cells in all: h V = counted + T · ratioVolume + (T · others - counted cells) · v, solved for T.
  const double v = red.filler->countedVolume;
  const double all =
      (*hematocrit * lumenVolume - red.countedVolume + red.counted * v) / (red.ratioVolume + others * v);
  if (all * others < red.counted)
    throw InputError(fmt::format("the red cells with counts{} alone exceed the hematocrit {:.15g}",
                                 red.ratioShare > 0.0 ? ", with the corresponding ones with ratios," : "",
                                 *hematocrit));
  return all;
}

/// The volume of a red cell of the species that a hematocrit determines, else of the first one; 0: there are
/// none [µm³].
double fillingVolume(const std::vector<CellSpecies>& species) {
  const CellSpecies* first = nullptr;
  for (const CellSpecies& s : species) {
    if (!s.sharesHematocrit) continue;
    if (!s.statedCount && !s.ratio) return s.countedVolume;
    if (!first) first = &s;
  }
  return first ? first->countedVolume : 0.0;
}

/// How the number of a species is determined, in the order of evaluation.
enum class By { count, ratioOfRedCells, hematocrit, ratioToRedCells };

By decidedBy(const CellSpecies& s) {
  if (s.statedCount) return By::count;
  if (s.ratio) return s.sharesHematocrit ? By::ratioOfRedCells : By::ratioToRedCells;
  return By::hematocrit;
}

/// Refuses a cell that cannot be in the lumen in any orientation: a ball inside it is wider than the lumen
/// along an axis, or it is longer than the diagonal.
void refuseTooLarge(const Scene& scene, const CellSpecies& species) {
  const Container& container = *scene.lumen.container;
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
      "cell '{}' is {:.4g} x {:.4g} x {:.4g} µm, larger than the lumen ({:.4g} x {:.4g} x {:.4g} µm){}",
      species.name, cell[0], cell[1], cell[2], room[0], room[1], room[2], deformedInstead(scene)));
}

/// Refuses a kind of cell of which HemoCell would delete every one, wherever it is.
void refuseWithoutNode(const CellSpecies& species) {
  if (!species.acceptance || species.acceptance->allowedNodes().hasFluidNodes()) return;
  throw InputError(
      fmt::format("cell '{}': no node of the lattice is further than {} µm from all solid nodes, "
                  "so HemoCell would delete every such cell",
                  species.name, species.minimumDistanceFromSolid));
}

/// Refuses more cells of a kind to be packed than any known packing has, ordered ones included. Ellipsoids
/// fill at most this part of space (Donev, Stillinger, Chaikin, Torquato: Phys. Rev. Lett. 92, 255506, 2004),
/// red cells less (docs/explanation/speed.md, crystals); meshes of other shapes may fill more. A few cells
/// may fit a lumen with walls exactly.
void refuseBeyondKnown(const Scene& scene, const CellSpecies& species) {
  const Container& lumen = *scene.lumen.container;
  constexpr double densestKnown = 0.7707, rounding = 1e-9;
  constexpr std::int64_t many = 100;
  const double part = double(species.toPack()) * species.shape->volume() / lumen.volume();
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
            named("best-effort") + " packs as many as possible{}",
        species.name, part, densestKnown, deformedInstead(scene)));
}

}  // namespace

std::vector<std::int64_t> numbersOfCells(const std::vector<CellSpecies>& species,
                                         std::optional<double> hematocrit, double lumenVolume) {
  const double expected = redCellNumber(redCellsOf(species), hematocrit, lumenVolume);
  double redVolume = 0.0;
  std::int64_t redCells = 0;
  for (const CellSpecies& s : species)
    if (s.sharesHematocrit) redVolume += double(s.ofRegions) * s.countedVolume, redCells += s.ofRegions;
  const auto numberOf = [&](const CellSpecies& s, By by) -> std::int64_t {
    switch (by) {
      case By::count:
        return *s.statedCount;
      case By::ratioOfRedCells:
        return rounded(expected * *s.ratio, s.name);
      case By::hematocrit:
        if (!hematocrit) return 0;
        return rounded(std::max(0.0, (*hematocrit * lumenVolume - redVolume) / s.countedVolume), s.name);
      case By::ratioToRedCells:
        return rounded(double(redCells) * *s.ratio, s.name);
    }
    return 0;
  };
  std::vector<std::int64_t> counts(species.size(), 0);
  for (const By by : {By::count, By::ratioOfRedCells, By::hematocrit, By::ratioToRedCells})
    for (std::size_t i = 0; i < species.size(); ++i) {
      if (decidedBy(species[i]) != by) continue;
      counts[i] = numberOf(species[i], by);
      if (!species[i].sharesHematocrit) continue;
      redVolume += double(counts[i]) * species[i].countedVolume;
      redCells += counts[i];
    }
  std::int64_t total = 0;
  for (std::size_t i = 0; i < species.size(); ++i) {
    counts[i] += species[i].ofRegions;
    total += counts[i];
  }
  if (total == 0) {
    throw InputError(
        hematocrit ? fmt::format("nothing to pack: hematocrit {:.15g} of {:.6g} µm³ is less than half a cell",
                                 *hematocrit, lumenVolume)
                   : std::string("nothing to pack: every count is 0"));
  }
  if (double(total) > specs::largestCount) {
    throw InputError(
        fmt::format("{} cells are too many; at most {:.0f} can be packed", total, specs::largestCount));
  }
  return counts;
}

std::vector<std::int64_t> numbersOfCells(const Scene& scene, std::optional<double> hematocrit,
                                         const std::vector<LumenRegion>& regions) {
  double reference = scene.referenceVolume();
  if (scene.request.packCellsConventions && scene.request.boxSize) reference = scene.request.boxSize->prod();
  if (hematocrit && !regions.empty()) {
    double volume = 0.0;  // over the reference volume
    for (const LumenRegion& region : regions) {
      const double before = volume;
      volume += region.count ? double(*region.count) * fillingVolume(scene.species) / reference
                             : region.share * region.hematocrit.value_or(*hematocrit);
      double own = 0.0;
      for (const CellSpecies& species : scene.species)
        if (species.sharesHematocrit)
          own += double(region.ofSpecies(species.name)) * species.countedVolume / reference;
      if (!region.own)
        volume += own;
      else if (own > volume - before + 0.5 * fillingVolume(scene.species) / reference)
        throw InputError(fmt::format("{}: its own red cells are more than its {} allows",
                                     scene.request.regions[&region - regions.data()].body.where,
                                     region.count ? "count" : "hematocrit"));
    }
    hematocrit = volume;
  }
  return numbersOfCells(scene.species, hematocrit, reference);
}

MeanVolumes averagePresent(const Scene& scene) {
  MeanVolumes means;
  for (const CellSpecies& species : scene.species) {
    double sum = 0.0;
    std::size_t cells = 0;
    const auto add = [&](int shape) {
      sum += shape < 0 ? species.shape->volume() : scene.shapes[shape]->volume();
      ++cells;
    };
    for (const auto* const present : {&species.fixed, &species.start, &species.blood.crowded})
      for (const PresentCell& cell : *present) add(cell.shape);
    if (cells == 0)
      for (const int shape : species.blood.shapes) add(shape);
    means.push_back(cells == 0 ? std::nullopt : std::optional(sum / double(cells)));
  }
  return means;
}

MeanVolumes averagePlaced(const Scene& scene, const std::vector<Part>& parts) {
  std::vector<double> volumes(scene.species.size(), 0.0);
  for (const Part& part : parts)
    part.cells.forEachShape([&](int shape, std::int64_t cells) {
      volumes[part.species] += double(cells) * scene.shapes[shape]->volume();
    });
  MeanVolumes means;
  for (std::size_t s = 0; s < volumes.size(); ++s) {
    const std::int64_t count = scene.species[s].count;
    means.push_back(count == 0 ? std::nullopt : std::optional(volumes[s] / double(count)));
  }
  return means;
}

std::vector<CellSpecies> withMeanVolumes(std::vector<CellSpecies> species, const MeanVolumes& means,
                                         std::optional<double> redCellVolume) {
  for (std::size_t s = 0; s < species.size(); ++s) {
    if (!means[s]) continue;
    species[s].meanVolume = *means[s];
    if (!(species[s].redCell && redCellVolume)) species[s].countedVolume = species[s].meanVolume;
  }
  return species;
}

std::vector<CellSpecies> withCounts(std::vector<CellSpecies> species,
                                    const std::vector<std::int64_t>& counts) {
  for (std::size_t s = 0; s < species.size(); ++s) species[s].count = counts[s];
  return species;
}

void examineNumbers(const Scene& scene, Notices& notices) {
  double volume = 0.0, toPack = 0.0;
  std::set<const Acceptance*> examined;
  for (const CellSpecies& species : scene.species) {
    volume += double(species.count) * species.meanVolume;
    toPack += double(species.toPack()) * species.shape->volume();
    if (species.mostCells() == 0) continue;
    if (!scene.request.deforms()) refuseTooLarge(scene, species);
    if (examined.insert(species.acceptance.get()).second) refuseWithoutNode(species);
  }
  const double lumen = scene.lumen.container->volume();
  if (volume >= lumen) {
    throw InfeasibleError(fmt::format(
        "the requested cells have a volume of {:.6g} µm³, the lumen only {:.6g} µm³", volume, lumen));
  }
  if (scene.request.deforms()) return;
  if (!scene.request.bestEffort)
    for (const CellSpecies& species : scene.species) refuseBeyondKnown(scene, species);
  if (toPack > Forecast::possible * lumen && !scene.request.inColumns) {
    notices.warnings.push_back(
        fmt::format("the requested cells fill {:.4f} of the lumen: above {:.2f} no random packing of red "
                    "cells is known; " +
                        named("max-time") + " and " + named("best-effort") + " limit the run time{}",
                    toPack / lumen, Forecast::possible, denserInstead(scene)));
  }
}

}  // namespace packmesh::hemocell
