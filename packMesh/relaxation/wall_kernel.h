// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The other innermost loop: how deep do the sample points of a cell reach into the wall.
///
/// A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include "packMesh/field/brick_view.h"
#include "packMesh/relaxation/contact_kernel.h"

namespace packmesh {

/// A sampled wall as seen from a cell's centre.
struct WallGrid {
  BrickView bricks;
  int base[3];              ///< a node below all points of the cell along each axis
  float start[3];           ///< the cell's centre, from there [nodes]
  float first[3], last[3];  ///< where the grid begins and ends, from there [nodes]
};

/// A ClosedFormWall as seen from a cell's centre. Written with what is small near the wall, so that floats
/// err by some 1e-6 µm in lumens of any size.
struct WallForm {
  static constexpr float none = 1e30f;
  float across[3], radius;
  float fromAxis[3];       ///< the cell's centre from the axis or the middle of the round wall [µm]
  float excess;            ///< radius² - |fromAxis|² [µm²]
  float toLo[3], toHi[3];  ///< how far the centre is from the planes [µm]; none: no plane
};

/// Where a cell is in front of its wall.
struct WallFrame {
  float m[9];  ///< from the body frame to the axes of the world, with the cell's scale
  float scale;
  enum class Kind { form, coarse, sampled } kind;
  WallForm form;
  WallGrid coarse, fine;  ///< sampled: the fine one only where the coarse one says that the wall is near
  float slack;            ///< coarse distances are too large by at most this [µm]
};

/// Sums over points that touch the wall from about the same direction, weighted by how much nearer than the
/// clearance they are; seen from the cell's centre.
struct WallContact {
  float weight;     ///< sum of penetrations
  float point[3];   ///< sum of penetration * point
  float normal[3];  ///< sum of penetration * direction into the lumen
  float deepest;    ///< largest penetration
};

struct WallSums {
  static constexpr int most = 4;
  int contacts;  ///< in a narrow lumen a cell touches opposite walls at once: one for each direction
  WallContact contact[most];
  float nearest;  ///< without contacts: no sample point is nearer to the wall than this
};

/// Looks at the clusters in `mask`. When these are all, `mask` becomes the set of those that may have a point
/// nearer than clearance + margin.
using WallKernel = void (*)(const SampleView&, const WallFrame&, float clearance, float margin,
                            ClusterMask& mask, WallSums&);

/// The version for an instruction set. Pre: available(set).
template <InstructionSet set>
WallKernel wallKernel();
inline WallKernel wallKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return wallKernel<constant.value>(); });
}

}  // namespace packmesh
