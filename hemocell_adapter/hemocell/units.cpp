// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace packmesh::hemocell {
namespace {

/// Range of lattice spacings of blood simulations [µm]: a red cell is 2.3 µm thick, so above the upper bound
/// it can contain no node.
constexpr double finestSpacing = 0.05, coarsestSpacing = 1.2;

struct Unit {
  const char* name;
  double micrometres;
};
constexpr Unit units[] = {{"m", 1e6}, {"mm", 1e3}, {"cm", 1e4}, {"µm", 1.0}, {"nm", 1e-3}};

/// Quality of the agreement of positions with a lumen after multiplication by a factor.
struct Fit {
  double inside = 0.0;  ///< fraction of positions in the lumen
  double spread = 0.0;  ///< extent of the positions / extent of the lumen, along its longest axis
  double leastSpread = 0.0, mostSpread = 0.0;  ///< the same, along the axes where it is least and most
  bool canBe = true;  ///< the volume of the cells fits into the box around the positions
};

Fit fitOf(const Container& container, const std::vector<Vec3>& positions, double volumes, double factor,
          const Communicator& ranks) {
  const Box bounds = container.bounds();
  Box box;
  std::int64_t inside = 0;
  for (const Vec3& p : positions) {
    const Vec3 q = factor * p;
    box.add(q);
    inside += bounds.contains(q) && (!container.wall() || container.wall()->distance(q).distance > 0.0);
  }
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = ranks.min(box.lo[k]);
    box.hi[k] = ranks.max(box.hi[k]);
  }
  Fit fit;
  fit.inside = double(ranks.sum(inside)) / double(ranks.sum(std::int64_t(positions.size())));
  int longest = 0;
  bounds.size().maxCoeff(&longest);
  fit.spread = box.size()[longest] / bounds.size()[longest];
  const Vec3 spreads = box.size().cwiseQuotient(bounds.size());
  fit.leastSpread = spreads.minCoeff();
  fit.mostSpread = spreads.maxCoeff();
  constexpr double radius = 4.0;  // [µm] of the largest cells: margin around their centres
  fit.canBe = volumes < box.grownBy(radius).volume();
  return fit;
}

}  // namespace

std::optional<std::string> spacingWarning(double dx, const std::string& where) {
  if (dx >= finestSpacing && dx <= coarsestSpacing) return {};
  constexpr double usual = 0.5;
  const double off = std::pow(10.0, std::round(std::log10(dx / usual)));
  return fmt::format("{}: a lattice spacing of {:.6g} µm; {}. HemoCell's cases have 0.5 µm (5e-7 m){}", where,
                     dx,
                     dx > usual ? "it does not resolve a red cell, which is 2.3 µm thick"
                                : "it is finer than any cell needs, and it scales the lumen",
                     off > 1.0 ? fmt::format(": is it {:.6g} times too large? It also scales the lumen", off)
                     : off < 1.0 ? fmt::format(": is it {:.6g} times too small?", 1.0 / off)
                                 : "");
}

std::string unitHint(double extent, double factor, double least, double most) {
  if (extent >= least && extent <= most) return "";
  std::string hint;
  for (const Unit& unit : units) {
    const double other = extent / factor * unit.micrometres;
    if (other >= least && other <= most)
      hint += fmt::format("{}if {} in {}, the factor is {:.15g}", hint.empty() ? "; " : ", ",
                          hint.empty() ? "the file is" : "it is", unit.name, unit.micrometres);
  }
  return hint;
}

bool isUnit(double factor, double error) {
  return std::any_of(std::begin(units), std::end(units),
                     [&](const Unit& unit) { return std::abs(factor / unit.micrometres - 1.0) <= error; });
}

std::optional<PositionFactor> positionFactor(const Container& container, const std::vector<Vec3>& positions,
                                             double volumes, double dx, const Communicator& ranks) {
  // A few cells can lie anywhere. Dozens of a box slightly larger than the lumen can all lie in it after
  // multiplication by a factor near 1.
  constexpr std::int64_t fewest = 5, fewestForNearFactors = 30;
  constexpr double mostlyIn = 0.9, allIn = 0.99, leastSpread = 0.6;
  const std::int64_t all = ranks.sum(std::int64_t(positions.size()));
  if (all < fewest) return {};
  const Fit given = fitOf(container, positions, volumes, 1.0, ranks);
  if (given.inside >= mostlyIn && given.canBe) return {};
  std::vector<PositionFactor> candidates = {
      {dx, "they are in lattice units or for a lattice spacing of 1 µm"},
      {1e6, "they are in metres"},
      {1e3, "they are in millimetres"},
      {1e-3, "they are in nanometres"},
      {1.0 / dx, "they were multiplied by the lattice spacing"}};
  for (const double old : {0.1, 0.2, 0.25, 0.4, 0.5, 0.6, 0.75, 0.8, 2.0})
    candidates.push_back(
        {dx / old, fmt::format("they are for a lattice spacing of {:.6g} µm, but it is {:.6g} µm", old, dx)});
  std::optional<PositionFactor> best;
  double widest = leastSpread;
  for (const PositionFactor& candidate : candidates) {
    if (candidate.factor == 1.0) continue;
    const bool near = candidate.factor > 0.5 && candidate.factor < 2.0;
    if (near && all < fewestForNearFactors) continue;
    const Fit fit = fitOf(container, positions, volumes, candidate.factor, ranks);
    if (!(fit.inside >= allIn && fit.spread > widest && fit.canBe)) continue;
    best = candidate;
    widest = fit.spread;
  }
  if (best || dx == 1.0) return best;
  // Cells that were not packed into this very lumen fill its bounds all the same.
  constexpr double fills = 0.75, exceeds = 1.05, partlyIn = 0.5;
  const Fit inNodes = fitOf(container, positions, volumes, dx, ranks);
  if (inNodes.leastSpread >= fills && inNodes.mostSpread <= exceeds && inNodes.inside >= partlyIn &&
      inNodes.inside > given.inside && inNodes.canBe)
    return candidates.front();
  return {};
}

}  // namespace packmesh::hemocell
