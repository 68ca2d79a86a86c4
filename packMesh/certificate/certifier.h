// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A certificate that is kept up to date while a few cells move at a time.
#pragma once

#include <optional>
#include <vector>

#include "packMesh/certificate/certified_cells.h"
#include "packMesh/certificate/smallest_gap.h"

namespace packmesh {

/// Certifies cells, and again after some of them have changed: only pairs and walls of those are examined
/// anew.
///
/// Every field of the certificate is, to the bit, what certify() gives for the same cells. Memory: some 130
/// bytes per cell, nothing per pair.
class Certifier {
 public:
  /// Certifies all cells. What `input` refers to must outlive this; the number of cells must stay the same.
  /// @param largestGap as for certify() [µm]
  explicit Certifier(const CertificateInput& input, double largestGap = gapOfInterest);
  Certifier(const Certifier&) = delete;
  Certifier& operator=(const Certifier&) = delete;

  const Certificate& certificate() const { return certificate_; }

  /// Brings the certificate up to date. Pre: cells not in `changed` are where they were.
  void update(const std::vector<std::int64_t>& changed);

 private:
  /// Whether to give up: asks.
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
  std::optional<PeriodicNeighbors> neighbors_;  ///< of the cells as examined last
  std::vector<bool> changed_;
  bool allChanged_ = true;

  /// Of each cell's pairs with later ones that are no faults, the smallest gap [µm] and with whom; exact
  /// where below what pairGap_ has measured.
  std::vector<double> nearest_;
  std::vector<std::int32_t> partner_;
  std::vector<std::int64_t> stale_;  ///< cells that must find another partner
  SmallestGap pairGap_;

  std::vector<double> wallGaps_;  ///< of each cell, likewise [µm]
  SmallestGap wallGap_;
};

}  // namespace packmesh
