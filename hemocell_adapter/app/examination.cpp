// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/app/examination.h"

#include <algorithm>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/certificate/certify.h"

namespace packmesh::hemocell {
namespace {

/// Limits, in total and per cell, of the overlapping pairs that are searched. A cell touches some ten others;
/// if all overlap, as in a file in metres, the number of pairs is quadratic.
constexpr std::int64_t leastOverlaps = 100000, overlapsPerCell = 4;

}  // namespace

FoundCells readCells(const Scene& scene) {
  FoundCells found;
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    const CellSpecies& species = scene.species[s];
    std::vector<std::string> warnings;
    const std::vector<PosLine> lines =
        isState(species.startFrom) ? species.start
                                   : readPos(scene.outputDirectory / (species.name + ".pos"), &warnings);
    for (const std::string& warning : warnings) log::warning(warning);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      found.cells.push_back({int(s), placementOf(lines[i])});
      found.poses.push_back(poseOf(lines[i]));
      found.lineNumber.push_back(std::int64_t(i) + 2);
    }
  }
  return found;
}

Examination examine(const Scene& scene, const std::vector<PlacedCell>& cells) {
  CertificateInput input;
  input.container = scene.lumen.container.get();
  input.cells = &cells;
  for (const CellSpecies& species : scene.species) {
    input.shapes.push_back(species.shape.get());
    input.walls.push_back(scene.lumen.container->wall());
    input.extraWallGap.push_back(species.extraWallClearance(scene.demanded.wall));
  }
  input.requiredGap = scene.demanded.membranes;
  input.threads = scene.team;
  input.requiredWallGap = scene.demanded.wall;
  input.mostOverlaps = std::max(leastOverlaps, overlapsPerCell * std::int64_t(cells.size()));
  Examination found;
  found.certificate = certify(input);
  found.droppedIsFault = scene.lumen.acceptedOnly && !scene.periodicEnds.value_or(false);
  forEachVerdict(scene, cells, [&](std::size_t i, const std::optional<std::string>& violation) {
    found.violations.push_back(violation);
    if (!violation) found.kept.push_back(std::int64_t(i));
  });
  return found;
}

}  // namespace packmesh::hemocell
