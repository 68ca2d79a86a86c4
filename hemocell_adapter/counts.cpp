// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/counts.h"

#include <fmt/format.h>

#include <cmath>

#include "hemocell_adapter/value_specs.h"
#include "packMesh/error.h"

namespace packmesh::hemocell {
namespace {

std::int64_t rounded(double cells, const std::string& name) {
  if (!(cells <= specs::largestCount)) {
    throw InputError(fmt::format("{:.3g} cells of '{}' are too many; at most {:.0f} can be packed", cells,
                                 name, specs::largestCount));
  }
  return std::llround(cells);
}

}  // namespace

std::vector<std::int64_t> countCells(const std::vector<CountedSpecies>& species,
                                     std::optional<double> hematocrit, double lumenVolume) {
  std::vector<std::int64_t> counts(species.size(), 0);
  const CountedSpecies* filler = nullptr;
  double fixedVolume = 0.0;  // of red cells with a count
  double fixedCells = 0.0;   // the same, in cells
  double ratioVolume = 0.0;  // of red cells that come with each red cell
  for (const CountedSpecies& s : species) {
    if (!s.redCell) continue;
    if (s.count) {
      fixedVolume += double(*s.count) * s.volume;
      fixedCells += double(*s.count);
    } else if (s.ratio) {
      ratioVolume += *s.ratio * s.volume;
    } else if (filler) {
      throw InputError(
          fmt::format("the hematocrit cannot decide both '{}' and '{}': give one a count or a ratio",
                      filler->name, s.name));
    } else {
      filler = &s;
    }
  }
  std::int64_t filled = 0;
  if (filler && hematocrit) {
    // h V = fixed + N v + (fixedCells + N) · ratioVolume, solved for N.
    const double wanted = *hematocrit * lumenVolume - fixedVolume - fixedCells * ratioVolume;
    if (wanted < 0) {
      throw InputError(
          fmt::format("the red cells with counts alone exceed the hematocrit {:.15g}", *hematocrit));
    }
    filled = rounded(wanted / (filler->volume + ratioVolume), filler->name);
  }
  const double redCells = fixedCells + double(filled);
  std::int64_t total = 0;
  for (std::size_t i = 0; i < species.size(); ++i) {
    const CountedSpecies& s = species[i];
    counts[i] = s.count ? *s.count : s.ratio ? rounded(redCells * *s.ratio, s.name) : filled;
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

}  // namespace packmesh::hemocell
