// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A finished packing.
#pragma once

#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/scene.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// A packing that was made and then repeated in a larger box.
struct Repeated {
  const Scene& scene;
  const PackingResult& result;
};

/// A packing that is finished, certified and counted, or cells of files that were examined. References its
/// parts.
struct Finished {
  const Scene& scene;
  const PackingResult& result;
  const Tally& tally;
  const Kept& kept;
  const Communicator& ranks;
  const Repeated* repeated = nullptr;  ///< the packing that was repeated
  bool checked = false;                ///< cells of files: nothing was packed
};

}  // namespace packmesh::hemocell
