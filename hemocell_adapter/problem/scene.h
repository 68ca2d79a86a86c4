// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lumen and species of a job with everything that can be asked of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/read_lines.h"
#include "hemocell_adapter/problem/job.h"
#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/problem/scene_part.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh::hemocell {

struct SceneSpecies {
  JobSpecies job;
  std::shared_ptr<const Shape> shape;
  std::shared_ptr<const Wall> wall;              ///< where packing allows it; nullptr: the container's own
  std::shared_ptr<const Acceptance> acceptance;  ///< nullptr without a lattice
  std::int64_t count = 0;                        ///< requested

  std::int64_t mostCells() const { return count + job.stock; }  ///< of a packing
};

struct Scene {
  Lumen lumen;
  std::vector<SceneSpecies> species;
  std::vector<SceneRegion> regions;  ///< empty: one hematocrit for all of the lumen
  std::vector<ScenePart> parts;      ///< what is packed
  ReadLines read;                    ///< cells that were there
  std::vector<std::string> warnings;

  /// The volume the hematocrit is a share of [µm³].
  double referenceVolume(const Job& job) const {
    return job.fluidVolume ? lumen.fluidVolume() : lumen.container->volume();
  }
};

/// What people may be told who ask for more than packs at random: "; --order columns ...", or nothing where
/// columns (see Columns) are not for that scene.
std::string columnsInstead(const Job& job, const Scene& scene);

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
