// SPDX-License-Identifier: AGPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "hemocell_adapter/app/fill.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "packMesh/hemocell_system.h"

namespace packmesh::plugin {
namespace {

using hemocell::AddedCell;
using hemocell::Lattice;
using hemocell::RunningCase;

hemocell::BuiltCell builtCell(const CellType& type, double dx) {
  hemocell::BuiltCell cell;
  cell.name = type.name;
  cell.minimumDistanceFromSolid = type.minimumDistanceFromSolid;
  if (type.volume > 0.0) cell.hemocellVolume = type.volume;
  for (const auto& v : type.vertices) cell.mesh.vertices.push_back(dx * Vec3(v[0], v[1], v[2]));
  cell.mesh.triangles = type.triangles;
  const Vec3 center = boundingBox(cell.mesh).center();
  for (Vec3& v : cell.mesh.vertices) v -= center;
  return cell;
}

/// A row of fluid nodes along x, in nodes of the whole lattice.
struct Run {
  std::int32_t from, to, j, k;
};

std::vector<Run> fluidRuns(const System& system) {
  std::vector<Run> runs;
  for (const Block& block : system.blocks) {
    std::array<std::int64_t, 3> n{}, at{};
    for (int a = 0; a < 3; ++a) {
      n[a] = block.last[a] - block.first[a] + 1;
      at[a] = block.first[a] - system.first[a];
    }
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j) {
        const auto fluid = [&](std::int64_t i) { return i < n[0] && block.fluid[(i * n[1] + j) * n[2] + k]; };
        for (std::int64_t i = 0; i < n[0]; ++i) {
          if (!fluid(i)) continue;
          const std::int64_t from = i;
          while (fluid(i + 1)) ++i;
          runs.push_back({std::int32_t(at[0] + from), std::int32_t(at[0] + i), std::int32_t(at[1] + j),
                          std::int32_t(at[2] + k)});
        }
      }
  }
  return runs;
}

std::shared_ptr<const Lattice> latticeOf(const System& system, const Communicator& ranks) {
  std::array<int, 3> nodes{};
  for (int a = 0; a < 3; ++a) nodes[a] = int(system.last[a] - system.first[a] + 1);
  auto lattice = std::make_shared<Lattice>(nodes, system.dx);
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j) lattice->setFluid(0, nodes[0] - 1, j, k, false);
  for (const Run& run : ranks.gatherAll(fluidRuns(system))) lattice->setFluid(run.from, run.to, run.j, run.k, true);
  return lattice;
}

std::shared_ptr<const RunningCase> caseOf(const System& system, const Request& request,
                                          const Communicator& ranks) {
  auto running = std::make_shared<RunningCase>();
  hemocell::together(ranks, [&] { running->config = hemocell::packingConfigOf(system.config, "config.xml"); });
  hemocell::Settings& packing = running->config.packing;
  for (const auto& [name, count] : request.counts) speciesNamed(packing, name).count = count;
  for (const auto& [name, ratio] : request.ratios) speciesNamed(packing, name).ratio = ratio;
  running->lattice = latticeOf(system, ranks);
  running->periodic = system.periodic;
  running->isPreInlet = system.isPreInlet;
  for (const CellType& type : system.types) running->cells.push_back(builtCell(type, system.dx));
  hemocell::Domain& domain = running->config.domain;
  domain.dx = system.dx;
  domain.dxWhere = "<dx>";
  domain.boxNodes = running->lattice->nodes();
  domain.particleEnvelope = system.particleEnvelope;
  domain.particleEnvelopeWhere = "<particleEnvelope>";
  return running;
}

Cell inNodes(const AddedCell& cell, const System& system) {
  Cell result{};
  result.type = cell.type;
  result.id = cell.id;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      result.linear[3 * row + column] = cell.placement.linear(row, column);
    result.translation[row] = cell.placement.translation[row] / system.dx + double(system.first[row]);
  }
  return result;
}

/// The region of a block in which it has vertices, in nodes of the whole lattice.
struct Region {
  std::int32_t rank;
  float lo[3], hi[3];
};

/// Sends cells to the ranks that have vertices of them.
class Distribution {
 public:
  Distribution(const System& system, const RunningCase& running, const Communicator& ranks)
      : system_(system), running_(running), ranks_(ranks) {
    std::vector<Region> mine;
    for (const Block& block : system.blocks) {
      Region region{};
      region.rank = ranks.rank();
      for (int a = 0; a < 3; ++a) {
        region.lo[a] = float(block.first[a] - system.first[a]) - 0.5f;
        region.hi[a] = float(block.last[a] - system.first[a]) + 0.5f;
      }
      mine.push_back(region);
    }
    regions_ = ranks.gatherAll(mine);
  }

  std::vector<Cell> operator()(const std::vector<AddedCell>& cells) const {
    std::vector<std::vector<Cell>> to(ranks_.size());
    for (const AddedCell& cell : cells) {
      const Box box = boundingBox(placed(running_.cells[cell.type].mesh, cell.placement));
      std::vector<bool> sent(ranks_.size(), false);
      for (const Region& region : regions_)
        if (!sent[region.rank] && meets(box, region)) {
          to[region.rank].push_back(inNodes(cell, system_));
          sent[region.rank] = true;
        }
    }
    std::vector<Cell> received;
    for (const std::vector<Cell>& part : ranks_.exchange(to))
      received.insert(received.end(), part.begin(), part.end());
    return received;
  }

 private:
  /// Whether an image of a box [µm] and a region have common points, up to a margin for rounding.
  bool meets(const Box& box, const Region& region) const {
    constexpr double margin = 0.01;  // [nodes]
    const double dx = running_.lattice->dx();
    for (int a = 0; a < 3; ++a) {
      const double lo = box.lo[a] / dx - margin, hi = box.hi[a] / dx + margin;
      const int n = running_.lattice->nodes()[a];
      bool any = false;
      for (int image = running_.periodic[a] ? -1 : 0; image <= (running_.periodic[a] ? 1 : 0); ++image)
        any = any || (lo + image * n <= region.hi[a] && hi + image * n >= region.lo[a]);
      if (!any) return false;
    }
    return true;
  }

  const System& system_;
  const RunningCase& running_;
  const Communicator& ranks_;
  std::vector<Region> regions_;
};

}  // namespace

Filling fill(const System& system, const Request& request) {
  Filling filling;
  try {
    const Communicator ranks = Communicator::copyOf(system.ranks);
    hemocell::log::setLevel(ranks.rank() > 0 ? hemocell::log::Level::silent : hemocell::log::Level::normal);
    const std::shared_ptr<const RunningCase> running = caseOf(system, request, ranks);
    const hemocell::Filling packed = hemocell::fill(running, request.words, ranks);
    filling.counts = packed.counts;
    filling.cells = Distribution(system, *running, ranks)(packed.cells);
  } catch (...) {
    const hemocell::Failure failure = hemocell::failureOfException();
    filling.exitCode = int(failure.code);
    filling.message = failure.message;
  }
  return filling;
}

}  // namespace packmesh::plugin
