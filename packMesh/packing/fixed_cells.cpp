// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/fixed_cells.h"

#include <string>
#include <vector>

#include "packMesh/certificate/certify.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/written_cells.h"

namespace packmesh {

void requireFixedApart(const PackingProblem& problem) {
  CertificateInput input;
  std::vector<PlacedCell> cells;
  std::vector<std::string> names;
  for (const Species& species : problem.species) {
    const int index = static_cast<int>(input.shapes.size());
    input.shapes.push_back(species.shape.get());
    input.walls.push_back(problem.wallOf(species));
    input.extraWallGap.push_back(species.freedom.extraWallClearance);
    if (!species.freedom.fixed) continue;
    for (const Pose& pose : species.start) {
      cells.push_back({index, WrittenCells::placement(problem, pose)});
      names.push_back("cell " + std::to_string(&pose - species.start.data() + 1) + " of '" + species.name +
                      "'");
    }
  }
  if (cells.empty()) return;
  input.container = problem.container.get();
  input.cells = &cells;
  input.requiredGap = problem.clearance;
  input.requiredWallGap = problem.wallClearance;
  input.upToFirstFault = true;
  const Certificate found = certify(input);
  if (!found.misplaced.empty()) {
    const MisplacedCell& cell = found.misplaced.front();
    throw InputError(names[cell.cell] + " is fixed, but " + cell.reason);
  }
  if (!found.overlapping.empty()) {
    const OverlappingPair& pair = found.overlapping.front();
    throw InputError(names[pair.first] + " and " + names[pair.second] + " are fixed, but " +
                     (pair.gap > 0.0 ? "are closer to each other than the clearance" : "overlap each other"));
  }
}

}  // namespace packmesh
