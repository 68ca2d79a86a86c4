// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells as they will be written, to which the certificate refers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "packMesh/certificate/certificate_input.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// The cells of this rank at the time they were taken, and its ghosts; sorted by id. All ranks call its
/// functions together.
class WrittenCells {
 public:
  /// References `problem`, which must outlive it.
  explicit WrittenCells(const PackingProblem& problem) : problem_(&problem) {}

  /// Copies the cells from the relaxation.
  void take(Relaxation& relaxation);

  /// Updates cells that have moved since, wherever they are now.
  /// @return those (by index) that differ now; nothing if so many have moved that all have to be taken again
  std::optional<std::vector<std::int64_t>> update(Relaxation& relaxation);

  /// References this object.
  CertificateInput certificateInput() const;
  const std::vector<std::int64_t>& ids() const { return ids_; }

 private:
  const PackingProblem* problem_;
  std::vector<std::int64_t> ids_;
  std::vector<bool> own_;
  std::vector<PlacedCell> cells_;
  std::map<std::int64_t, Vec3> takenAt_;  ///< by index, of those that have moved since [µm]
};

}  // namespace packmesh
