// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A job with its lumen and species, and everything that can be asked of them.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/read_lines.h"
#include "hemocell_adapter/problem/job.h"
#include "hemocell_adapter/problem/lumen.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh::hemocell {

/// Cells of one species with the same freedom, which are a species of the problem that is packed.
struct ScenePart {
  int species = 0;
  int region = -1;  ///< in Lumen::regions; -1: none
  Species cells;    ///< "RBC", "RBC, fixed", "RBC, region 1"
};

/// A job with what it says built: lumen, species and the parts that are packed.
struct Scene : Job {
  /// Nothing is built yet: buildScene() does.
  explicit Scene(Job job) : Job(std::move(job)), clearances(demanded) {}

  Lumen lumen;
  Clearances clearances;             ///< that are packed with (setClearances()); at first those demanded
  std::vector<ScenePart> parts;      ///< what is packed
  ReadLines read;                    ///< existing cells
  std::vector<std::string> notices;  ///< what the user should know about how it was built

  /// The volume the hematocrit is a share of [µm³].
  double referenceVolume() const { return fluidVolume ? lumen.fluidVolume() : lumen.container->volume(); }
};

/// What people may be told who ask for more than packs at random: "; --order columns ...", or nothing where
/// columns (see Columns) are not for that scene.
std::string columnsInstead(const Scene& scene);

/// Makes the species of a result, which are parts of the scene, those of the scene.
/// @return how many cells of each part there are on this rank
std::vector<std::int64_t> namedBySpecies(const Scene& scene, PackingResult& result);

/// What HemoCell would do with a placed cell: nothing when it keeps it, otherwise why not.
std::optional<std::string> hemocellViolation(const Scene& scene, const PlacedCell& cell);

/// Whether the scene knows what HemoCell keeps: there is a lattice, or a box.
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

/// How many there are of each species among `chosen` (indices into `cells`; nullptr: all).
std::vector<std::int64_t> countsOf(const Scene& scene, const std::vector<PlacedCell>& cells,
                                   const std::vector<std::int64_t>* chosen = nullptr);

/// @param counts of the species
Tally tallyOf(const Scene& scene, std::vector<std::int64_t> counts);

}  // namespace packmesh::hemocell
