// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A certificate that is kept up to date while a few cells move at a time.
#pragma once

#include <optional>
#include <vector>

#include "packMesh/certificate/certified_cells.h"

namespace packmesh {

/// Search for the smallest of many gaps of which few are measured: only those below a limit that falls with
/// the smallest found so far.
class SmallestGap {
 public:
  /// @param level gaps are first looked for below this [µm]
  /// @param lowest no gap below this is expected [µm]
  SmallestGap(double largestGap, double level, double lowest = 0.0)
      : ofInterest_(largestGap), level_(std::min(level, largestGap)), alwaysMeasured_(lowest + reserve) {}

  /// Gaps are measured when they are below this [µm].
  double limit() const { return std::min(ofInterest_, std::max(alwaysMeasured_, std::min(least_, level_))); }
  /// The smallest gap that is known [µm], infinity: none below the gap of interest.
  double least() const { return least_; }
  /// Whether no gap that was not measured can be smaller.
  bool settled() const { return least_ <= known_ || known_ >= ofInterest_; }

  /// Some gaps were measured up to limit(); the others are at least that.
  void measured() { known_ = std::min(known_, limit()); }
  void found(double gap) {
    if (gap < ofInterest_) least_ = std::min(least_, gap);
  }
  /// Forgets the smallest gap: `found` tells it anew.
  void forgetLeast() { least_ = std::numeric_limits<double>::infinity(); }
  /// Forgets everything; gaps will be looked for further up. Pre: not settled.
  void beginAgain() {
    constexpr double growth = 8.0;
    level_ =
        least_ < ofInterest_ ? std::nextafter(least_, ofInterest_) : std::min(growth * level_, ofInterest_);
    least_ = known_ = std::numeric_limits<double>::infinity();
  }

 private:
  /// Gaps that exceed the lowest by no more than this are all measured [µm]: hardly more work, and when the
  /// smallest goes, the next is known.
  static constexpr double reserve = 0.005;

  double ofInterest_, level_, alwaysMeasured_;
  double least_ = std::numeric_limits<double>::infinity();
  double known_ = std::numeric_limits<double>::infinity();  ///< all gaps below this have been measured
};

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
