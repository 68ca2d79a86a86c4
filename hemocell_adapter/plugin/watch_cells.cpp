// SPDX-License-Identifier: AGPL-3.0-or-later
// Cells are put together from the parts that ranks have of them: no vertex is communicated, and HemoCell's
// particles stay as they are.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "hemocell_adapter/hemocell/hemocell_limits.h"
#include "packMesh/hemocell_system.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::plugin {
namespace {

/// Periods along each axis between two images of a cell. Pre: they are near each other. Empty if they are
/// two cells: a pre-inlet sends the same cell again, under the number of another image, each time that it has
/// gone round.
std::optional<std::array<std::int64_t, 3>> periodsBetween(std::int64_t image, std::int64_t other,
                                                          const Watch& watch) {
  std::array<std::int64_t, 3> periods{};
  std::int64_t rest = image - other;
  for (const int axis : {2, 1, 0}) {  // by decreasing steps
    if (!watch.periodic[axis]) continue;
    periods[axis] = std::llround(double(rest) / double(watch.imageSteps[axis]));
    rest -= periods[axis] * watch.imageSteps[axis];
  }
  if (rest != 0) return {};
  return periods;
}

/// Extends `cell` by a part of the same cell. @param periods between them
void join(CellPart& cell, const CellPart& part, const std::array<std::int64_t, 3>& periods,
          const Watch& watch) {
  cell.vertices += part.vertices;
  for (int a = 0; a < 3; ++a) {
    const double shift = double(periods[a] * watch.nodes[a]);
    cell.lo[a] = std::min(cell.lo[a], part.lo[a] - shift);
    cell.hi[a] = std::max(cell.hi[a], part.hi[a] - shift);
  }
}

/// The cells of which this rank keeps account, from the parts on all ranks.
std::vector<CellPart> cellsOf(const std::vector<CellPart>& parts, const Watch& watch,
                              const Communicator& ranks) {
  std::vector<std::vector<CellPart>> to(ranks.size());
  for (const CellPart& part : parts) to[part.id % ranks.size()].push_back(part);
  std::vector<CellPart> all;
  for (const std::vector<CellPart>& some : ranks.exchange(to))
    all.insert(all.end(), some.begin(), some.end());
  std::stable_sort(all.begin(), all.end(), [](const CellPart& a, const CellPart& b) {
    return std::tie(a.id, a.image) < std::tie(b.id, b.image);
  });
  std::vector<CellPart> cells;
  for (const CellPart& part : all) {
    bool known = false;
    for (auto cell = cells.rbegin(); !known && cell != cells.rend() && cell->id == part.id; ++cell)
      if (const auto periods = periodsBetween(part.image, cell->image, watch)) {
        join(*cell, part, *periods, watch);
        known = true;
      }
    if (!known) cells.push_back(part);
  }
  return cells;
}

double longestExtent(const CellType& type) {
  TriangleMesh mesh;
  for (const auto& v : type.vertices) mesh.vertices.emplace_back(v[0], v[1], v[2]);
  return hemocell::longestExtent(mesh);
}

/// What to do about the longest cell, first in `cells`.
std::string remedy(const std::vector<LongCell>& cells, const Watch& watch) {
  const LongCell& longest = cells.front();
  const CellType& type = watch.types[longest.type];
  // Not less than for strong shear; and a cell that has come so far gets longer. Of the nodes around a block,
  // HemoCell exchanges those of the lattice and of its next images: more are of no use.
  constexpr double margin = 1.25;
  const auto most = int(watch.nodes[longest.axis]);
  const int needed =
      std::min(std::max(hemocell::neededEnvelope(longestExtent(type), 1.0, hemocell::strongShear.allowance),
                        int(std::ceil(margin * longest.nodes))),
               most);
  std::string text =
      fmt::format("iteration {}: {} {} is {:.1f} nodes ({:.2f} µm) long along {}, <particleEnvelope> is {}",
                  watch.iteration, type.name, longest.id, longest.nodes, longest.nodes * watch.dx,
                  "xyz"[longest.axis], watch.particleEnvelope);
  if (cells.size() > 1)
    text +=
        fmt::format("; {} more {} as long", cells.size() - 1, cells.size() == 2 ? "cell is" : "cells are");
  text += ". HemoCell deletes a cell that is longer than the envelope. ";
  if (needed <= watch.particleEnvelope)
    return text + fmt::format(
                      "The lattice has {} nodes along {}, and a longer envelope is of no use: lengthen "
                      "it, or lower the shear",
                      most, "xyz"[longest.axis]);
  return text + fmt::format(
                    "Set\n  <particleEnvelope> {} </particleEnvelope>\nin config.xml and start again, or in "
                    "checkpoint.xml and restart from a checkpoint",
                    needed);
}

}  // namespace

Watched watch(const Watch& watch, const std::vector<CellPart>& parts) {
  const Communicator ranks = Communicator::copyOf(watch.ranks);
  std::array<bool, 3> limited{};
  for (int a = 0; a < 3; ++a) limited[a] = watch.periodic[a] || ranks.any(watch.divided[a]);
  Watched found;
  found.counts.assign(watch.types.size() + 1, 0);  // and those that are incomplete
  std::vector<LongCell> mine;
  for (const CellPart& cell : cellsOf(parts, watch, ranks)) {
    const bool complete = cell.vertices == std::int64_t(watch.types[cell.type].vertices.size());
    ++found.counts[complete ? std::size_t(cell.type) : watch.types.size()];
    LongCell longest{cell.type, 0, cell.id, 0.0};
    for (int a = 0; a < 3; ++a) {
      const double extent = cell.hi[a] - cell.lo[a];
      found.longest = std::max(found.longest, extent);
      if (!limited[a] || extent <= longest.nodes) continue;
      longest.axis = a;
      longest.nodes = extent;
    }
    if (longest.nodes > watch.particleEnvelope - watch.margin) mine.push_back(longest);
  }
  ranks.sum(found.counts);
  found.incomplete = found.counts.back();
  found.counts.pop_back();
  found.longest = ranks.max(found.longest);
  found.tooLong = ranks.gatherAll(mine);
  std::sort(found.tooLong.begin(), found.tooLong.end(), [](const LongCell& a, const LongCell& b) {
    return std::tie(b.nodes, a.id) < std::tie(a.nodes, b.id);
  });
  if (!found.tooLong.empty()) found.message = remedy(found.tooLong, watch);
  return found;
}

}  // namespace packmesh::plugin
