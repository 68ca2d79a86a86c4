// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A finished packing.
#pragma once

#include <optional>

#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/packing/packing_result.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// A packing that was made and then repeated in a larger box.
struct Repeated {
  const Problem& problem;
  const PackingResult& result;
};

/// A packing that is finished, certified and counted, or cells of files that were examined. References its
/// parts.
struct Finished {
  const Problem& problem;
  const OutputRequest& output;   ///< what is written
  const Clearances& clearances;  ///< that were kept
  const PackingResult& result;
  const Tally& tally;
  const Kept& kept;
  std::optional<Repeated> repeated = {};  ///< the packing that was repeated
  bool checked = false;                   ///< cells of files: nothing was packed

  const Communicator& ranks() const { return problem.ranks; }
};

}  // namespace packmesh::hemocell
