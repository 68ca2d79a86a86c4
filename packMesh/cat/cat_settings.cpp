// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/cat_settings.h"

#include <cmath>
#include <limits>
#include <string>

#include "packMesh/core/error.h"

namespace packmesh {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

void require(bool holds, const char* what) {
  if (!holds) throw InputError(std::string("growth: ") + what);
}

/// Also false for NaN.
bool above(double low, double value, double high) {
  return value > low && value <= high;
}
bool within(double low, double value, double high) {
  return value >= low && value <= high;
}

}  // namespace

void validate(const GrowthSettings& s) {
  require(within(GrowthSettings::smallestScale, s.initialScale, 1.0),
          "the initial scale must be in [0.001, 1]");
  require(!s.barriers.empty() && s.barriers.back() == 1.0, "the last barrier must be 1, full size");
  double last = 0.0;
  for (const double barrier : s.barriers) {
    require(above(last, barrier, 1.0) && barrier > last, "barriers must increase, from above 0 to 1");
    last = barrier;
  }
  require(s.maxIterations >= 1, "there must be at least 1 iteration for each barrier");
  require(above(0.0, s.rotationBound, std::acos(-1.0)), "the rotation bound must be in (0, pi] rad");
  require(above(0.0, s.translationBound, 1e3), "the translation bound must be in (0, 1000]");
  require(within(0.0, s.padding, 1e3), "the padding must be in [0, 1000]");
  require(s.linearisations >= 1, "rotations must be linearised at least once");
  require(above(0.0, s.alpha, 1.0), "alpha must be in (0, 1]");
  require(above(0.0, s.beta, 1e3), "beta must be in (0, 1000]");
  require(within(0.0, s.shaking, 1.0), "shaking must be in [0, 1]");
  require(s.patience >= 1, "patience must be at least 1 iteration");
  require(s.stalledGrowth >= 0.0 && s.stalledGrowth < endless, "growth that counts as stalled must be >= 0");
  require(s.relaxationSweeps >= 0, "sweeps of relaxation must be at least 0");
  require(s.giveUpAfter >= 0, "stalls until growth gives up must be at least 0");
  require(s.attempts >= 1, "there must be at least 1 attempt");
}

}  // namespace packmesh
