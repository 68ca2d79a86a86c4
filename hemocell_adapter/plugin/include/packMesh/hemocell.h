// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Fills a running HemoCell: packmesh::loadParticles(hemocell) instead of hemocell.loadParticles().
///
/// Include it after hemocell.h, in the C++ file of the case. C++11. Only HemoCell's public interfaces are
/// used.
#pragma once

#include <mpi.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <hemocell.h>
#include "packMesh/checkpoint.h"
#include "packMesh/failure.h"
#include "packMesh/hemocell_system.h"
#include "packMesh/running_hemocell.h"
#include "packMesh/watch_cells.h"

namespace packmesh {

namespace plugin {

__attribute__((used)) static const int* const interfaceOfCase = &interface_ba88018d;

/// Calls work(system) on the ranks that have cells, and stops on all ranks if it failed.
template <class Work>
Filling onRanksWithCells(hemo::HemoCell& hemocell, const Work& work) {
  MPI_Comm ranks;
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_split(MPI_COMM_WORLD, hasCells(hemocell) ? 1 : 0, rank, &ranks);
  Filling filling;
  if (hasCells(hemocell)) {
    System system = systemOf(hemocell, ranks);
    filling = work(system);
  }
  MPI_Comm_free(&ranks);
  stopIfFailed(filling);
  filling.counts.resize(hemocell.cellfields->size(), 0);
  MPI_Allreduce(MPI_IN_PLACE, filling.counts.data(), static_cast<int>(filling.counts.size()), MPI_INT64_T,
                MPI_MAX, MPI_COMM_WORLD);
  return filling;
}

/// Adds cells as HemoCell's loader does, and verifies that it keeps them.
inline LoadedParticles loadInto(hemo::HemoCell& hemocell, const Filling& filling) {
  LoadedParticles loaded;
  loaded.counts = filling.counts;
  for (const std::int64_t count : loaded.counts) loaded.cells += count;
  hemo::HemoCellFields& fields = *hemocell.cellfields;
  fields.number_of_cells = static_cast<int>(loaded.cells);
  for (const plb::plint id : fields.immersedParticles->getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& block = fields.immersedParticles->getComponent(id);
    block.removeParticles(block.getBoundingBox());
  }
  ParticleAdder add(hemocell);
  for (const Cell& cell : filling.cells) add(cell);
  fields.syncEnvelopes();
  fields.deleteIncompleteCells(false);
  requireComplete(hemocell, loaded.counts);
  recordCounts(hemocell, loaded.counts);
  return loaded;
}

/// The complete cells whose first vertex this rank has. Pre: envelopes are up to date.
inline std::vector<Cell> cellsOf(hemo::HemoCell& hemocell) {
  std::vector<Cell> cells;
  hemo::HemoCellFields& fields = *hemocell.cellfields;
  for (const plb::plint block : fields.immersedParticles->getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& field = fields.immersedParticles->getComponent(block);
    for (const auto& numbered : field.get_particles_per_cell()) {
      const std::vector<int>& at = numbered.second;
      if (std::count(at.begin(), at.end(), -1) > 0) continue;
      const auto& first = field.particles[at[0]].sv;
      if (!field.isContainedABS(first.position, field.localDomain)) continue;
      Cell cell = Cell();
      cell.type = first.celltype;
      cell.id = fields.base_cell_id(numbered.first);
      for (const int i : at) {
        const auto& p = field.particles[i].sv.position;
        cell.vertices.push_back({{p[0], p[1], p[2]}});
      }
      cells.push_back(cell);
    }
  }
  return cells;
}

}  // namespace plugin

/// Packs cells into the fluid nodes of `hemocell` and adds them, instead of hemocell.loadParticles(). After
/// the lattice, its boundaries, the cell types and periodicity are set. Collective. Stops
/// (packMesh/failure.h) if the packing is not feasible, or HemoCell does not keep every cell. Leaves files
/// with the numbers of cells for restarts (packMesh/checkpoint.h).
inline LoadedParticles loadParticles(hemo::HemoCell& hemocell,
                                     const PackingOptions& options = PackingOptions()) {
  if (options.mostNodesOnEveryRank >= 0)
    plugin::warn("PackingOptions::mostNodesOnEveryRank has no effect, and will be removed in 2.0.0");
  return plugin::loadInto(hemocell, plugin::onRanksWithCells(hemocell, [&](plugin::System& system) {
                            return plugin::fill(system, options);
                          }));
}

/// What becomes of cells of a state that HemoCell would delete at once, since a vertex lies on a wall node.
enum class Unkept { refuse, leaveOut };

/// Adds the cells of a state that the program, loadParticles() or savePositions() wrote; each rank reads a
/// part. Cells that are not those of a packing certified in this lumen are examined; cells of a run that do
/// not overlap are added as they were, with all vertices, others are the start of a packing.
/// @param unkept stop, naming cells and reasons, if HemoCell would delete some; or add the others
inline LoadedParticles loadParticles(hemo::HemoCell& hemocell, const std::string& stateFile,
                                     Unkept unkept = Unkept::refuse) {
  return plugin::loadInto(hemocell, plugin::onRanksWithCells(hemocell, [&](const plugin::System& system) {
                            return plugin::load(system, stateFile, unkept == Unkept::leaveOut);
                          }));
}
inline LoadedParticles loadParticles(hemo::HemoCell& hemocell, const char* stateFile,
                                     Unkept unkept = Unkept::refuse) {
  return loadParticles(hemocell, std::string(stateFile), unkept);
}

/// Writes the cells as they are now, deformed, to a state file. With a pre-inlet: the cells in it.
/// Collective.
/// @param rigid write the rigid templates that fit best instead; their residual is stated
inline void savePositions(hemo::HemoCell& hemocell, const std::string& stateFile, bool rigid = false) {
  hemocell.cellfields->syncEnvelopes();
  hemocell.cellfields->deleteIncompleteCells(false);
  plugin::onRanksWithCells(hemocell, [&](const plugin::System& system) {
    return plugin::save(system, plugin::cellsOf(hemocell), hemocell.iter, stateFile, rigid);
  });
}

/// Stops, naming the numbers, unless HemoCell has every vertex of every cell now. Call it after the first
/// iteration: HemoCell changes its communication there. Collective.
/// @param loaded what loadParticles() or loadCheckPoint() returned
inline void verifyParticles(hemo::HemoCell& hemocell, const LoadedParticles& loaded) {
  hemocell.cellfields->syncEnvelopes();
  hemocell.cellfields->deleteIncompleteCells(false);
  plugin::requireComplete(hemocell, loaded.counts);
}

}  // namespace packmesh
