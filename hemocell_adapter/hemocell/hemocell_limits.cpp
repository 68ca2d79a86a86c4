// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/hemocell_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace packmesh::hemocell {
namespace {

constexpr std::int64_t largestInt = std::numeric_limits<int>::max();

/// HemoCell's condition: images along y are numbered in steps of limits[0], along z of limits[0]·limits[1].
bool fits(std::int64_t cells, std::int64_t x, std::int64_t y) {
  return x + x * y <= largestInt / cells;
}

}  // namespace

std::optional<std::string> cellNumberWarning(std::int64_t cells, const std::vector<PeriodicityCall>& calls) {
  if (cells <= 0) return {};
  std::array<std::int64_t, 3> limits = {100, 100, 100};  // HemoCell's defaults
  bool known = true;
  for (const PeriodicityCall& call : calls) {
    known = known && call.axis && call.limit && *call.axis >= 0 && *call.axis < 3 &&
            std::abs(*call.limit) < double(largestInt);
    if (known) limits[int(*call.axis)] = std::int64_t(*call.limit);
  }
  if (known && fits(cells, limits[0], limits[1])) return {};
  if (fits(cells, 100, 100)) return {};
  std::int64_t most = 0;
  while (fits(cells, most + 1, most + 1)) ++most;
  if (most == 0) return fmt::format("{} cells are more than HemoCell can number, with any settings", cells);
  return fmt::format(
      "{0} cells: HemoCell stops if there are more than {1}, unless the case's C++ code limits, on two axes, "
      "how often a cell can cross the periodic boundaries. It must call, before loadParticles(),\n"
      "  hemocell.setSystemPeriodicityLimit(0, {2});\n  hemocell.setSystemPeriodicityLimit(1, {2});",
      cells, largestInt / (100 + 100 * 100), most);
}

double longestExtent(const TriangleMesh& mesh) {
  // From the outermost vertices inwards: two that are too close to the centre cannot be further apart.
  const Vec3 middle = boundingBox(mesh).center();
  std::vector<std::pair<double, const Vec3*>> byRadius;
  for (const Vec3& v : mesh.vertices) byRadius.emplace_back((v - middle).norm(), &v);
  std::sort(byRadius.begin(), byRadius.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  double longest = 0.0;
  for (std::size_t i = 0; i < byRadius.size() && 2.0 * byRadius[i].first > longest; ++i)
    for (std::size_t j = i + 1; j < byRadius.size() && byRadius[i].first + byRadius[j].first > longest; ++j)
      longest = std::max(longest, (*byRadius[i].second - *byRadius[j].second).norm());
  return longest;
}

int neededEnvelope(double length, double dx, double stretch) {
  return int(std::ceil(stretch * length / dx));
}

int neededEnvelopeAt(double wallShearStress, double length, double dx) {
  const MeasuredStretch& shear = wallShearStress <= weakShear.wallShearStress ? weakShear : strongShear;
  return neededEnvelope(length, dx, shear.allowance);
}

namespace {

/// Into how many blocks a lattice can be divided that are not smaller than an envelope [nodes].
std::string blocksText(const std::array<int, 3>& lattice, int envelope, const Domain& domain) {
  std::array<int, 3> blocks{};
  for (int a = 0; a < 3; ++a) blocks[a] = std::max(1, lattice[a] / envelope);
  const int all = blocks[0] * blocks[1] * blocks[2];
  std::string text = fmt::format(
      "\nAtomic blocks smaller than the envelope make HemoCell slow: with {} nodes, a lattice of {} x {} x "
      "{} "
      "has room for {} x {} x {} blocks, so for {} {}",
      envelope, lattice[0], lattice[1], lattice[2], blocks[0], blocks[1], blocks[2], all,
      all == 1 ? "rank" : "ranks");
  if (domain.smallestBlock)
    text += fmt::format("; the smallest block is now {} x {} x {}", (*domain.smallestBlock)[0],
                        (*domain.smallestBlock)[1], (*domain.smallestBlock)[2]);
  return text;
}

}  // namespace

std::optional<std::string> envelopeWarning(const std::string& cell, double length, const Domain& domain,
                                           const std::optional<std::array<int, 3>>& lattice) {
  if (!domain.particleEnvelope) return {};
  const int envelope = *domain.particleEnvelope;
  const int weak = neededEnvelope(length, domain.dx, weakShear.allowance);
  const int strong = neededEnvelope(length, domain.dx, strongShear.allowance);
  if (envelope >= strong) return {};
  if (domain.wallShearStress && envelope >= neededEnvelopeAt(*domain.wallShearStress, length, domain.dx))
    return {};
  const double nodes = length / domain.dx;
  const auto tag = [](int needed) {
    return fmt::format("\n  <particleEnvelope> {} </particleEnvelope>", needed);
  };
  std::string text = fmt::format("{}: {} is {:.2f} times the longest extent of {} at rest, {:.1f} nodes. ",
                                 domain.particleEnvelopeWhere, envelope, envelope / nodes, cell, nodes);
  text += envelope < nodes
              ? "HemoCell deletes cells that extend from one block into another or across a periodic face"
              : "HemoCell deletes cells that the flow stretches beyond it";
  text += fmt::format(
      ". Red cells were stretched to {} times their length at a wall shear stress of {} Pa ({} iterations), "
      "to {} "
      "times at {} Pa ({} iterations). ",
      weakShear.stretch, weakShear.wallShearStress, weakShear.iterations, strongShear.stretch,
      strongShear.wallShearStress, strongShear.iterations);
  const int most = lattice ? *std::max_element(lattice->begin(), lattice->end()) : strong;
  if (envelope < std::min(weak, most)) text += fmt::format("Set{}", tag(std::min(weak, most)));
  if (envelope < weak && weak < most)
    text += fmt::format("\nor, above {} Pa,{}", weakShear.wallShearStress, tag(std::min(strong, most)));
  else if (envelope >= weak && envelope < most)
    text += fmt::format("Above {} Pa set{}", weakShear.wallShearStress, tag(std::min(strong, most)));
  if (strong > most)
    text += fmt::format(
        "{}The lattice has {} nodes along its longest axis, fewer than the {} that cells can need: lengthen "
        "it, or "
        "keep the wall shear stress below {} Pa",
        text.back() == '>' ? "\n" : "", most, strong,
        weak > most ? weakShear.wallShearStress : strongShear.wallShearStress);
  if (lattice) text += blocksText(*lattice, std::min(strong, most), domain);
  return text;
}

}  // namespace packmesh::hemocell
