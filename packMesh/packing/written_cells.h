// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells as they will be written, which is what is certified.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "packMesh/packing/packing_problem.h"
#include "packMesh/stages/certificate/certificate.h"
#include "packMesh/stages/relaxation/relaxation.h"

namespace packmesh {

/// The cells of this rank, and the copies it has of cells near them; sorted by id.
class WrittenCells {
 public:
  /// References `problem`, which must outlive it.
  explicit WrittenCells(const PackingProblem& problem) : problem_(&problem) {}

  /// Takes the cells over from the relaxation.
  /// @return which of them changed, if they are the same cells as before
  std::optional<std::vector<std::int64_t>> take(const Relaxation& relaxation);

  /// References this object.
  CertificateInput certificateInput() const;
  const std::vector<std::int64_t>& ids() const { return ids_; }

  static Placement placement(const PackingProblem& problem, const Pose& pose) {
    return problem.written ? problem.written(pose) : pose.placement();
  }

 private:
  const PackingProblem* problem_;
  std::vector<std::int64_t> ids_;
  std::vector<bool> own_;
  std::vector<PlacedCell> cells_;
};

}  // namespace packmesh
