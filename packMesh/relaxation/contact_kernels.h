// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The two innermost loops: how deep the sample points of one cell penetrate the surface of another,
/// and the wall. Kernels: see instruction_set.h.
///
/// A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include <cstdint>

#include "packMesh/field/interpolation.h"
#include "packMesh/shape/field_view.h"
#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// A set of clusters: bit k represents the 2^bitShift clusters starting at k * 2^bitShift.
using ClusterMask = std::uint64_t;
constexpr ClusterMask allClusters = ~ClusterMask{0};

/// Sums over the points nearer than the clearance, weighted by how much nearer they are; in the other's
/// frame.
struct ContactSums {
  float weight;         ///< sum of penetrations
  float point[3];       ///< sum of penetration * point
  float normal[3];      ///< sum of penetration * outward gradient of a function that vanishes on the surface
  float gradient;       ///< sum of penetration * length of that gradient
  float deepest;        ///< largest penetration into the clearance
  ClusterMask touched;  ///< clusters with a point nearer than the clearance
  float nearest;        ///< no sample point is nearer to the surface than this (negative: inside)
};

/// Examines the clusters in `mask`. If `mask` contains all of them, it is set to those with a point nearer
/// than clearance + margin: as long as the two have not moved by more than the margin, no others can touch.
using ContactKernel = void (*)(const SampleView&, const RelativeFrame&, const FieldView&, float clearance,
                               float margin, ClusterMask& mask, ContactSums&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
ContactKernel contactKernel();
inline ContactKernel contactKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return contactKernel<constant.value>(); });
}

// A kernel: see packMesh/simd/instruction_set.h.

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
