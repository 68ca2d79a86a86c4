// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A certificate that is updated while a few cells at a time move.
#pragma once

#include <optional>
#include <vector>

#include "packMesh/certificate/certified_cells.h"
#include "packMesh/certificate/smallest_gap.h"

namespace packmesh {

/// Certifies cells and updates the certificate when some of them have changed, by examining only the pairs
/// and walls of changed cells.
///
/// Every field of the certificate equals, to the bit, the result of certify() for the same cells. Memory:
/// about 130 bytes per cell, none per pair.
class Certifier {
 public:
  /// Certifies all cells. The data referenced by `input` must outlive this object; the number of cells must
  /// not change.
  /// @param largestGap as for certify() [µm]
  explicit Certifier(const CertificateInput& input, double largestGap = gapOfInterest);
  Certifier(const Certifier&) = delete;
  Certifier& operator=(const Certifier&) = delete;

  const Certificate& certificate() const { return certificate_; }

  /// Updates the certificate. Pre: cells not in `changed` have not moved since the last call.
  void update(const std::vector<std::int64_t>& changed);

 private:
  /// Polls `stop`.
  bool stopped();
  bool enoughOverlaps();
  void forgetChanged();
  void examineChanged();
  void examinePairs(std::int64_t cell, bool onlyLater, bool isNew);
  void measureLater(std::int64_t cell);
  void settlePairGap();
  void examineWall(std::int64_t cell, bool isNew);
  void settleWallGap();
  void summarise();

  const CertificateInput input_;
  const CertifiedCells cells_;
  Certificate certificate_;
  std::optional<PeriodicNeighbors> neighbors_;  ///< of the cells as last examined
  std::vector<bool> changed_;
  bool allChanged_ = true;

  /// Per cell: the smallest gap [µm] among its pairs with later cells that are no violations, and the
  /// partner; exact up to the limit measured by pairGap_.
  std::vector<double> nearest_;
  std::vector<std::int32_t> partner_;
  std::vector<std::int64_t> stale_;  ///< cells whose nearest partner has moved
  SmallestGap pairGap_;

  std::vector<double> wallGaps_;  ///< per cell, likewise [µm]
  SmallestGap wallGap_;
};

}  // namespace packmesh
