// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/calibration.h"

#include <algorithm>
#include <cmath>

#include "packMesh/core/tolerances.h"

namespace packmesh {
namespace {

/// Excess of the gap that is aimed at, and below which it is increased [µm]: cells move by thousandths of a
/// micrometre in each round.
constexpr double wantedExcess = 0.0015, leastExcess = 0.001;

/// Fraction of the difference that is corrected in a round, and largest reduction in a round [µm]: when all
/// pairs get nearer at the same time, their gaps change by more than their clearances.
constexpr double fraction = 0.8, largestReduction = 0.006;

/// No pair is allowed to be nearer than this by its sample points [µm].
constexpr double nearest = -0.01;

constexpr double stepsPerMicrometre = 0x1p14;

}  // namespace

double Calibration::correction(double gap, double required, double extra) {
  if (gap <= 0.0) return tolerance::repairClearance;
  const double excess = gap - required;
  if (excess >= leastExcess && excess <= wantedExcess) return 0.0;
  const double least = nearest - tolerance::relaxationMargin + tolerance::compactionSlack;
  const double wanted = std::max(fraction * (wantedExcess - excess), -largestReduction);
  return std::floor(std::max(wanted, std::min(0.0, least - extra)) * stepsPerMicrometre) / stepsPerMicrometre;
}

}  // namespace packmesh
