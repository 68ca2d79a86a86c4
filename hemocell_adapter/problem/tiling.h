// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Repetition of a periodic packing in a larger box.
#pragma once

#include "hemocell_adapter/problem/job.h"
#include "hemocell_adapter/problem/scene.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

inline bool isTiled(const Job& job) {
  return job.tiles != std::array<int, 3>{1, 1, 1};
}

/// The job of packing the larger box, in which all cells have initial poses: those of `result`, with all
/// images of a cell in succession. All ranks call; each gets all cells.
/// @throws InputError if the box is not periodic along an axis along which it is repeated, or if there are
///   too many cells
Job tiledJob(const Scene& scene, const PackingResult& result, const Communicator& ranks);

/// @throws InputError as above, before anything has been packed
void requireTileable(const Scene& scene);

}  // namespace packmesh::hemocell
