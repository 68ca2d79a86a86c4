// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The search for the smallest of many gaps.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace packmesh
