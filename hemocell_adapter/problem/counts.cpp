// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
    if (s.statedCount) {
      red.countedVolume += double(*s.statedCount) * s.countedVolume;
      red.counted += double(*s.statedCount);
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

/// How the number of a species is determined, in the order of evaluation.
enum class By { count, ratioOfRedCells, hematocrit, ratioToRedCells };

By decidedBy(const CellSpecies& s) {
  if (s.statedCount) return By::count;
  if (s.ratio) return s.sharesHematocrit ? By::ratioOfRedCells : By::ratioToRedCells;
  return By::hematocrit;
}

}  // namespace

std::vector<std::int64_t> countCells(const std::vector<CellSpecies>& species,
                                     std::optional<double> hematocrit, double lumenVolume) {
  const double expected = redCellNumber(redCellsOf(species), hematocrit, lumenVolume);
  double redVolume = 0.0;
  std::int64_t redCells = 0;
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
  for (const std::int64_t count : counts) total += count;
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

}  // namespace packmesh::hemocell
