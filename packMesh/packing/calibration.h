// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Clearances of pairs from their exact gaps.
#pragma once

namespace packmesh {

/// Relaxation keeps all pairs a margin apart that few of them need: how much two meshes can be nearer to each
/// other than their sample points depends on where they touch. In a packing that is almost too dense, each
/// pair gets the margin that it needs. Its exact gap is measured, its clearance is corrected by what the gap
/// differs from the smallest one that is safe, and all cells are relaxed again, a few times.
class Calibration {
 public:
  /// Pairs whose gap exceeds the required one by more than this keep their clearance [µm].
  static constexpr double range = 0.03;

  /// Correction of the clearance of a pair [µm], a multiple of 2^-14: ranks that measure the gap of a pair in
  /// different order find the same one.
  /// @param gap between the meshes [µm]; 0: they overlap
  /// @param required smallest gap allowed [µm]
  /// @param extra present extra clearance of the pair [µm]
  static double correction(double gap, double required, double extra);
};

}  // namespace packmesh
