// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certificate_input.h"

#include <algorithm>

namespace packmesh {

CertificateInput certificateInputOf(const Physics& physics, const std::vector<PlacedCell>& cells,
                                    const Threads& threads) {
  CertificateInput input;
  for (const auto& shape : physics.shapes) input.shapes.push_back(shape.get());
  for (const Species& species : physics.species) {
    input.walls.push_back(physics.wallOf(species));
    input.extraWallGap.push_back(species.freedom.extraWallClearance);
  }
  input.container = physics.container.get();
  input.cells = &cells;
  input.requiredGap = physics.clearance;
  input.requiredWallGap = physics.wallClearance;
  input.largestGap = measuredUpTo(input.requiredGap);
  for (std::size_t s = 0; s < physics.species.size(); ++s)
    input.largestWallGap = std::max(input.largestWallGap, measuredUpTo(input.wallGapOf(int(s))));
  input.threads = threads;
  return input;
}

}  // namespace packmesh
