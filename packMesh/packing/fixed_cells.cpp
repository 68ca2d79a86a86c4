// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/fixed_cells.h"

#include <string>
#include <vector>

#include "packMesh/certificate/certify.h"
#include "packMesh/core/error.h"

namespace packmesh {

void requireFixedApart(const Physics& physics, const Threads& threads) {
  std::vector<PlacedCell> cells;
  std::vector<std::string> names;
  for (std::size_t s = 0; s < physics.species.size(); ++s) {
    const Species& species = physics.species[s];
    if (!species.freedom.fixed) continue;
    for (const Pose& pose : species.start) {
      cells.push_back({static_cast<int>(s), physics.placement(pose)});
      names.push_back("cell " + std::to_string(&pose - species.start.data() + 1) + " of '" + species.name +
                      "'");
    }
  }
  if (cells.empty()) return;
  const Certificate found = certify(certificateInputOf(physics, cells, threads));
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
