// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Search for the smallest of many gaps.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace packmesh {

/// Finds the smallest of many gaps while measuring only a few of them: those below a limit that decreases
/// with the smallest gap found so far.
class SmallestGap {
 public:
  /// @param level initial limit [µm]
  /// @param lowest no gap below this is expected [µm]
  SmallestGap(double largestGap, double level, double lowest = 0.0)
      : ofInterest_(largestGap), level_(std::min(level, largestGap)), alwaysMeasured_(lowest + reserve) {}

  /// Gaps below this are measured [µm].
  double limit() const { return std::min(ofInterest_, std::max(alwaysMeasured_, std::min(least_, level_))); }
  /// The smallest gap known [µm]; infinity: none below the gap of interest.
  double least() const { return least_; }
  /// True if no unmeasured gap can be smaller.
  bool settled() const { return least_ <= known_ || known_ >= ofInterest_; }

  /// Some gaps were measured up to limit(); all others are at least that large.
  void measured() { known_ = std::min(known_, limit()); }
  void found(double gap) {
    if (gap < ofInterest_) least_ = std::min(least_, gap);
  }
  /// Takes over what another search with the same limits has found.
  void join(const SmallestGap& other) {
    least_ = std::min(least_, other.least_);
    known_ = std::min(known_, other.known_);
  }
  /// Forgets the smallest gap; found() provides it again.
  void forgetLeast() { least_ = std::numeric_limits<double>::infinity(); }
  /// Forgets everything and raises the limit. Pre: not settled.
  void beginAgain() {
    constexpr double factor = 8.0;
    level_ =
        least_ < ofInterest_ ? std::nextafter(least_, ofInterest_) : std::min(factor * level_, ofInterest_);
    least_ = known_ = std::numeric_limits<double>::infinity();
  }

 private:
  /// Gaps within this distance of the lowest are always measured [µm]: this costs little, and when the
  /// smallest gap disappears, the next is known.
  static constexpr double reserve = 0.005;

  double ofInterest_, level_, alwaysMeasured_;
  double least_ = std::numeric_limits<double>::infinity();
  double known_ = std::numeric_limits<double>::infinity();  ///< all gaps below this have been measured [µm]
};

}  // namespace packmesh
