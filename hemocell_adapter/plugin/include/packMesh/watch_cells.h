// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Watches the cells of a running HemoCell: packmesh::watchCells(hemocell) after hemocell.iterate().
/// Part of packMesh/hemocell.h. C++11.
#pragma once

#include <mpi.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include <hemocell.h>
#include "packMesh/failure.h"
#include "packMesh/hemocell_system.h"
#include "packMesh/running_hemocell.h"

namespace packmesh {

struct WatchOptions {
  unsigned int every = 100;  ///< iterations between examinations; calls at other iterations return at once
  double margin = 1.0;       ///< how near to the envelope a cell may come [nodes]
  bool stop = false;         ///< stop with a message (packMesh/failure.h), instead of a warning
};

/// What watchCells() has found, the same on all ranks; with a pre-inlet, in it and in the domain.
struct WatchedCells {
  bool examined = false;             ///< false between examinations: all else is empty
  std::vector<std::int64_t> counts;  ///< cells of each type, in HemoCell's order
  std::int64_t cells = 0;            ///< of all types
  double longest = 0.0;              ///< longest extent of a cell along an axis [µm]
  std::int64_t tooLong = 0;          ///< cells within the margin of the envelope
};

namespace plugin {

/// The parts of cells in the blocks of this rank.
inline std::vector<CellPart> partsOf(hemo::HemoCell& hemocell) {
  hemo::HemoCellFields& fields = *hemocell.cellfields;
  std::map<std::int64_t, CellPart> parts;  // by HemoCell's number, which is another one for each image
  for (const plb::plint id : fields.immersedParticles->getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& block = fields.immersedParticles->getComponent(id);
    for (const hemo::HemoCellParticle& particle : block.particles) {
      const auto& p = particle.sv.position;
      if (!block.isContainedABS(p, block.localDomain)) continue;
      const auto found = parts.find(particle.sv.cellId);
      if (found == parts.end()) {
        CellPart part;
        part.type = particle.sv.celltype;
        part.id = fields.base_cell_id(static_cast<int>(particle.sv.cellId));
        part.image = (particle.sv.cellId - part.id) / std::max(1, fields.number_of_cells);
        part.vertices = 1;
        part.lo = part.hi = {{p[0], p[1], p[2]}};
        parts.emplace(particle.sv.cellId, part);
        continue;
      }
      CellPart& part = found->second;
      ++part.vertices;
      for (int a = 0; a < 3; ++a) {
        part.lo[a] = std::min(part.lo[a], p[a]);
        part.hi[a] = std::max(part.hi[a], p[a]);
      }
    }
  }
  std::vector<CellPart> list;
  for (const auto& numbered : parts) list.push_back(numbered.second);
  return list;
}

inline Watch watchOf(hemo::HemoCell& hemocell, const MPI_Comm& ranks, double margin) {
  hemo::HemoCellFields& fields = *hemocell.cellfields;
  Watch watch;
  watch.ranks = &ranks;
  watch.iteration = hemocell.iter;
  watch.dx = hemo::param::dx * 1e6;
  const plb::Box3D all = hemocell.lattice->getBoundingBox();
  const std::array<std::int64_t, 3> first = low(all), last = high(all);
  watch.divided = {{false, false, false}};
  for (int a = 0; a < 3; ++a) {
    watch.nodes[a] = last[a] - first[a] + 1;
    watch.periodic[a] = fields.immersedParticles->periodicity().get(a);
    for (const plb::plint id : hemocell.lattice->getLocalInfo().getBlocks()) {
      const plb::Box3D bulk = hemocell.lattice->getMultiBlockManagement().getBulk(id);
      if (low(bulk)[a] > first[a] || high(bulk)[a] < last[a]) watch.divided[a] = true;
    }
  }
  watch.imageSteps = {{1, fields.periodicity_limit_offset_y, fields.periodicity_limit_offset_z}};
  watch.particleEnvelope = static_cast<int>(fields.envelopeSize);
  watch.margin = margin;
  for (unsigned int t = 0; t < fields.size(); ++t) watch.types.push_back(typeOf(*fields[t]));
  return watch;
}

/// Cells as text: "231 of 243 cells (220 RBC, 11 PLT)".
inline std::string watchMessage(const Watched& found, const Watch& watch, std::int64_t before) {
  std::ostringstream types;
  std::int64_t cells = 0;
  for (std::size_t t = 0; t < found.counts.size(); ++t) {
    types << (t ? ", " : "") << found.counts[t] << ' ' << watch.types[t].name;
    cells += found.counts[t];
  }
  std::ostringstream text;
  text << cells << " of " << before << " cells (" << types.str() << ")";
  return text.str();
}

/// How many cells HemoCell has deleted since the last call; empty if none, or with a pre-inlet, from which
/// cells come and go.
inline std::string deleted(hemo::HemoCell& hemocell, const Watched& found, const Watch& watch) {
  static std::int64_t before = -1;
  if (hemocell.preInlet && hemocell.preInlet->initialized) return std::string();
  const std::int64_t expected = before < 0 ? hemocell.cellfields->number_of_cells : before;
  before = 0;
  for (const std::int64_t count : found.counts) before += count;
  if (before >= expected) return std::string();
  return "iteration " + std::to_string(watch.iteration) +
         ": HemoCell has deleted cells: " + watchMessage(found, watch, expected) + " are left";
}

/// About cells that are too long: when there is one, and again whenever their number has doubled.
inline std::string tooLong(const Watched& found) {
  static std::size_t toldAt = 1;
  static std::set<std::int64_t> known;
  for (const LongCell& cell : found.tooLong) known.insert(cell.id);
  if (known.size() < toldAt || found.tooLong.empty()) return std::string();
  toldAt = 2 * known.size();
  return found.message;
}

}  // namespace plugin

/// Finds cells that the flow has stretched to nearly the length of the envelope, before HemoCell deletes
/// them: call it in the time loop, after iterate(). Says, or stops with (exit code 70), which cell it is and
/// what to set in config.xml; and how many cells HemoCell has deleted. Changes nothing in HemoCell.
/// Collective.
inline WatchedCells watchCells(hemo::HemoCell& hemocell, const WatchOptions& options = WatchOptions()) {
  WatchedCells result;
  if (options.every > 1 && hemocell.iter % options.every != 0) return result;
  // With a pre-inlet, its cells and those of the domain are in different lattices, on different ranks.
  MPI_Comm ranks;
  int rank = 0, first = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_split(MPI_COMM_WORLD, hemocell.partOfpreInlet ? 1 : 0, rank, &ranks);
  MPI_Comm_rank(ranks, &first);
  const plugin::Watch watch = plugin::watchOf(hemocell, ranks, options.margin);
  const plugin::Watched found = plugin::watch(watch, plugin::partsOf(hemocell));
  MPI_Comm_free(&ranks);
  const std::string longCells = plugin::agreed(plugin::tooLong(found));
  if (!longCells.empty() && options.stop) plugin::stop(70, longCells);
  if (!longCells.empty()) plugin::warn(longCells);
  const std::string lost = plugin::deleted(hemocell, found, watch);
  if (!lost.empty()) plugin::warn(lost);
  result.examined = true;
  result.counts = found.counts;
  result.counts.push_back(static_cast<std::int64_t>(found.tooLong.size()));
  if (first != 0) std::fill(result.counts.begin(), result.counts.end(), 0);
  MPI_Allreduce(MPI_IN_PLACE, result.counts.data(), static_cast<int>(result.counts.size()), MPI_INT64_T,
                MPI_SUM, MPI_COMM_WORLD);
  result.tooLong = result.counts.back();
  result.counts.pop_back();
  for (const std::int64_t count : result.counts) result.cells += count;
  result.longest = found.longest * watch.dx;
  MPI_Allreduce(MPI_IN_PLACE, &result.longest, 1, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  return result;
}

}  // namespace packmesh
