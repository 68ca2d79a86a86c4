// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/packing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "hemocell_adapter/problem/make_species.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct Quantity {
  const char* column;
  double Deformation::*value;
};
constexpr std::array<Quantity, 5> quantities = {{{"force", &Deformation::force},
                                                 {"volume_change", &Deformation::volume},
                                                 {"area_change", &Deformation::area},
                                                 {"triangle_change", &Deformation::triangle},
                                                 {"edge_change", &Deformation::edge}}};

/// nullptr for meshes that are too large.
std::unique_ptr<const Membrane> membraneFor(const Problem& problem, const CellSpecies& species) {
  try {
    return std::make_unique<Membrane>(species.shape->mesh(), membraneOf(problem, species));
  } catch (const InputError&) {
    return nullptr;
  }
}

/// Of each cell; copies of a cell have the same shape.
std::vector<Deformation> deformationOfEach(const Problem& problem, const std::vector<PlacedCell>& cells) {
  std::vector<std::unique_ptr<const Membrane>> membranes(problem.species.size());
  std::vector<int> speciesOf(problem.shapes.size(), -1);
  for (const PlacedCell& cell : cells) {
    if (!problem.isDeformed(cell)) continue;
    if (!membranes[cell.species])
      membranes[cell.species] = membraneFor(problem, problem.species[cell.species]);
    speciesOf[cell.shape] = cell.species;
  }
  std::vector<Deformation> ofShape(problem.shapes.size());
  problem.team.forEach(std::int64_t(ofShape.size()), [&](std::int64_t shape, int) {
    if (speciesOf[shape] < 0) return;
    const Membrane* const membrane = membranes[speciesOf[shape]].get();
    ofShape[shape] = membrane ? deformationOf(*membrane, problem.shapes[shape]->mesh().vertices)
                              : Deformation{unknown, unknown, unknown, unknown, unknown};
  });
  std::vector<Deformation> all;
  for (const PlacedCell& cell : cells)
    all.push_back(problem.isDeformed(cell) ? ofShape[cell.shape] : Deformation{});
  return all;
}

}  // namespace

namespace {

DeformedCells summaryOf(std::vector<Deformation> all) {
  DeformedCells made;
  made.cells = std::int64_t(all.size());
  for (const Deformation& one : all) made.most.enlarge(one);
  for (const Quantity& quantity : quantities) {
    const auto middle = all.begin() + std::ptrdiff_t(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end(), [&](const Deformation& a, const Deformation& b) {
      return a.*quantity.value < b.*quantity.value;
    });
    made.median.*quantity.value = *middle.*quantity.value;
  }
  return made;
}

}  // namespace

std::optional<Deformations> deformationsOf(const Packing& packing) {
  const Problem& problem = *packing.problem;
  if (!problem.hasDeformed()) return {};
  const std::vector<Deformation> each = deformationOfEach(problem, packing.cells);
  std::vector<Deformation> all;
  std::vector<std::pair<std::string, DeformedCells>> species;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    std::vector<Deformation> own;
    for (std::size_t i = 0; i < each.size(); ++i)
      if (packing.cells[i].species == int(s) && problem.isDeformed(packing.cells[i]) &&
          !std::isnan(each[i].force))
        own.push_back(each[i]);
    own = problem.ranks.gatherAll(own);
    if (own.empty()) continue;
    all.insert(all.end(), own.begin(), own.end());
    species.emplace_back(problem.species[s].name, summaryOf(std::move(own)));
  }
  if (all.empty()) return {};
  return Deformations{summaryOf(std::move(all)), std::move(species)};
}

CellColumn angleColumn(const std::vector<BodyState>& cells, const ReadLines& read) {
  CellColumn angles{"angles", 3, {}};
  for (const BodyState& cell : cells) {
    const PosLine line = read.lineOf(cell.pose());
    angles.values.insert(angles.values.end(), line.angles.data(), line.angles.data() + 3);
  }
  return angles;
}

std::vector<CellColumn> deformationColumns(const Problem& problem, const std::vector<PlacedCell>& cells) {
  std::vector<CellColumn> columns;
  if (!problem.hasDeformed()) return columns;
  const std::vector<Deformation> each = deformationOfEach(problem, cells);
  for (const Quantity& quantity : quantities) {
    columns.push_back({quantity.column, 1, {}});
    for (const Deformation& one : each) columns.back().values.push_back(one.*quantity.value);
  }
  return columns;
}

std::vector<CellColumn> deformationColumns(const Problem& problem, const PartsToPack& packed,
                                           const std::vector<BodyState>& cells) {
  std::vector<PlacedCell> placed;
  if (problem.hasDeformed())
    for (const BodyState& cell : cells) {
      const int species = packed.parts[cell.species].species;
      placed.push_back({species, cell.shape, {}});
    }
  return deformationColumns(problem, placed);
}

}  // namespace packmesh::hemocell
