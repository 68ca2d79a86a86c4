// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The second innermost loop: how deep the sample points of a cell penetrate the wall.
///
/// A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include "packMesh/field/brick_view.h"
#include "packMesh/relaxation/contact_kernel.h"

namespace packmesh {

/// A sampled wall in the frame of a cell's centre.
struct WallGrid {
  BrickView bricks;
  int base[3];              ///< a node below all points of the cell along each axis
  float start[3];           ///< the cell's centre relative to it [nodes]
  float first[3], last[3];  ///< bounds of the grid relative to it [nodes]
};

/// A ClosedFormWall relative to a cell's centre, in terms that are small near the wall, so that the error in
/// single precision is about 1e-6 µm in lumens of any size.
struct WallForm {
  static constexpr float none = 1e30f;
  float across[3], radius;
  float fromAxis[3];       ///< from the axis or the centre of the round wall to the cell's centre [µm]
  float excess;            ///< radius² - |fromAxis|² [µm²]
  float toLo[3], toHi[3];  ///< distances between centre and planes [µm]; none: no plane
};

/// The wall in the frame of a cell.
struct WallFrame {
  float m[9];  ///< from the body frame to the axes of the world, with the cell's scale
  float scale;
  enum class Kind { form, coarse, sampled } kind;
  WallForm form;
  WallGrid coarse,
      fine;     ///< sampled: the fine one is used only where the coarse one shows that the wall is near
  float slack;  ///< coarse distances are too large by at most this [µm]
};

/// Sums over points that touch the wall from about the same direction, weighted by their penetration into the
/// clearance; relative to the cell's centre.
struct WallContact {
  float weight;     ///< sum of penetrations
  float point[3];   ///< sum of penetration * point
  float normal[3];  ///< sum of penetration * direction into the lumen
  float deepest;    ///< largest penetration
};

struct WallSums {
  static constexpr int most = 4;
  int contacts;  ///< in a narrow lumen a cell touches opposite walls at once: one contact for each direction
  WallContact contact[most];
  float nearest;  ///< without contacts: lower bound of the distance between any sample point and the wall
};

/// Examines the clusters in `mask`. If `mask` contains all of them, it is set to those that may have a point
/// nearer than clearance + margin.
using WallKernel = void (*)(const SampleView&, const WallFrame&, float clearance, float margin,
                            ClusterMask& mask, WallSums&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
WallKernel wallKernel();
inline WallKernel wallKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return wallKernel<constant.value>(); });
}

}  // namespace packmesh
