// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A bug of HemoCell 2.7 in the exchange of particles across periodic faces between ranks.
#pragma once

#include "packMesh/hemocell_system.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Whether HemoCell can lose cells at the first iteration. It shifts the particles that a rank receives from
/// another one by the period in the buffer itself, for each pair of blocks and each image of a block in turn,
/// so that all after the first are shifted repeatedly (Proposals to HemoCell, 9). This does no harm where a
/// block spans the period: the block then makes the images itself. Neither where the blocks of a rank happen
/// to pass on what is missing, in small systems. Collective.
bool losesCells(const plugin::System& system, const Communicator& ranks);

/// Warns if so, and says what helps. Collective.
void warnOfLostCells(const plugin::System& system, const Communicator& ranks);

}  // namespace packmesh::hemocell
