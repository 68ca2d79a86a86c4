// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A job with its lumen and species, and queries about it.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/read_lines.h"
#include "hemocell_adapter/problem/job.h"
#include "hemocell_adapter/problem/lumen.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/core/input_record.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh::hemocell {

/// Cells of one species with the same constraints, which form a species of the problem that is packed.
struct ScenePart {
  int species = 0;
  int region = -1;  ///< in Lumen::regions; -1: none
  Species cells;    ///< "RBC", "RBC, fixed", "RBC, region 1"
};

/// A job and what is built from it: lumen, species and the parts that are packed.
struct Scene : Job {
  /// Nothing is built yet; buildScene() does that.
  explicit Scene(Job job) : Job(std::move(job)), clearances(demanded) {}

  Communicator ranks;                        ///< that pack it
  Threads team;                              ///< of this rank
  std::shared_ptr<const InputFiles> inputs;  ///< that were read for it
  Lumen lumen;
  Clearances clearances;             ///< used for packing (setClearances()); initially those demanded
  std::vector<ScenePart> parts;      ///< what is packed
  ReadLines read;                    ///< existing cells
  std::vector<std::string> notices;  ///< how it was built, for the user

  /// Cells of a packing, at most.
  std::int64_t mostCells() const {
    std::int64_t cells = 0;
    for (const CellSpecies& one : species) cells += one.mostCells();
    return cells;
  }

  /// The volume to which the hematocrit refers [µm³].
  double referenceVolume() const { return fluidVolume ? lumen.fluidVolume() : lumen.container->volume(); }
};

/// Hint for requests beyond random packing: "; --order columns ...", or empty if columns (see Columns) are
/// not possible in that scene.
std::string columnsInstead(const Scene& scene);

/// Replaces the species of a result, which are parts of the scene, by those of the scene.
/// @return number of cells of each part on this rank
std::vector<std::int64_t> namedBySpecies(const Scene& scene, PackingResult& result);

/// HemoCell's verdict on a placed cell: nothing if it keeps the cell, otherwise the reason why not.
std::optional<std::string> hemocellViolation(const Scene& scene, const PlacedCell& cell);
/// Calls visit(cell, violation) for each cell, in order, in the calling thread.
void forEachVerdict(
    const Scene& scene, const std::vector<PlacedCell>& cells,
    const std::function<void(std::size_t cell, const std::optional<std::string>& violation)>& visit);

/// Whether it is known which cells HemoCell keeps: there is a lattice, or a box.
bool knowsAcceptance(const Scene& scene);

/// Volumes and numbers of a set of cells.
struct Tally {
  std::vector<std::int64_t> counts;  ///< per species
  std::vector<double> meshVolume;    ///< per species [µm³]
  double redMesh = 0.0;              ///< volume of the red cells' meshes [µm³]
  double redHemocell = 0.0;          ///< the same by `<Volume>`, where given [µm³]
  bool hemocellKnown = true;         ///< every red species present has a `<Volume>`
  std::int64_t redCells = 0;
};

/// The number of each species among `chosen` (indices into `cells`; nullptr: all).
std::vector<std::int64_t> countsOf(const Scene& scene, const std::vector<PlacedCell>& cells,
                                   const std::vector<std::int64_t>* chosen = nullptr);

/// @param counts of the species
Tally tallyOf(const Scene& scene, std::vector<std::int64_t> counts);

}  // namespace packmesh::hemocell
