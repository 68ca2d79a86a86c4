// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/densest_known.h"

#include <fmt/format.h>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// Cells of one kind of shape, and the densest packing of them.
struct DensestKnown {
  const char* cells;
  double fraction;
  const char* source;
  bool (*includes)(const CellSpecies&);
};

bool isModel(const CellSpecies& s, Construction construction) {
  return s.kind == CellSpecies::Template::model && s.model.construction == construction;
}

constexpr DensestKnown known[] = {
    {"red cells", 0.748, "a crystal of two cells per period",
     [](const CellSpecies& s) { return isModel(s, Construction::rbcFromSphere); }},
    {"ellipsoids", 0.7707, "Donev et al., Phys. Rev. Lett. 92, 255506 (2004)", [](const CellSpecies& s) {
       return s.kind == CellSpecies::Template::ellipsoid || isModel(s, Construction::ellipsoidFromSphere) ||
              isModel(s, Construction::wbcSphere);
     }}};

/// With this many cells, no lumen can be filled more densely than a periodic box.
constexpr std::int64_t many = 100;

/// Whether copies of the lumen fill space, so that each packing of it is one of a periodic box.
bool fillsSpace(const Container& lumen) {
  constexpr double rounding = 1e-9;
  return lumen.period().minCoeff() > 0.0 || lumen.volume() > (1.0 - rounding) * lumen.bounds().size().prod();
}

}  // namespace

void refuseBeyondKnown(const Problem& problem) {
  const Container& lumen = *problem.lumen.container;
  for (const DensestKnown& kind : known) {
    double volume = 0.0;
    std::int64_t cells = 0;
    for (const CellSpecies& species : problem.species) {
      if (!kind.includes(species)) continue;
      volume += double(species.count) * species.shape->volume();
      cells += species.count;
    }
    const double fraction = volume / lumen.volume();
    if (fraction > kind.fraction && (fillsSpace(lumen) || cells >= many))
      throw InputError(
          fmt::format("the requested {} fill {:.4f} of the lumen; no packing of {} beyond {:.4g} is "
                      "known ({}). Reduce the number; --best-effort packs as many as possible",
                      kind.cells, fraction, kind.cells, kind.fraction, kind.source));
  }
}

}  // namespace packmesh::hemocell
