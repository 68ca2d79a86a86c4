// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Chords from the sample points of one cell to the surface of another, and their planes.
///
/// A kernel: see packMesh/simd/instruction_set.h.
#pragma once

#include <cstdint>

#include "packMesh/shape/field_view.h"
#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// The two cells of a pair. Lengths in units of the surface's body frame, if not said otherwise.
struct ChordFrame {
  RelativeFrame toSurface;       ///< from the body frame of the sampled cell to that of the surface
  float sampled[9], surface[9];  ///< rotations of the two cells, rows first
  float limit;                   ///< longest chord
  float scale;                   ///< of the cell with the surface
  float shortChord;              ///< shorter ones take their direction from the gradient of the distance
  float share;                   ///< of the gap, for the sampled cell
  float offset;                  ///< by which the plane is moved away from the sampled cell [µm]
};

/// Where the planes of the two cells are written, in the columns of CellPlanes; nullptr: not wanted.
struct ChordPlanesOut {
  float* const* sampled;
  float* const* surface;
};

/// @param distinct for each cluster, which of its points are not repetitions of others, as bits
/// @return the number of chords; there must be room for all points and 16 more
using ChordKernel = int (*)(const SampleView&, const std::uint16_t* distinct, const ChordFrame&,
                            const FieldView&, const ChordPlanesOut&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
ChordKernel chordKernel();
inline ChordKernel chordKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return chordKernel<constant.value>(); });
}

}  // namespace packmesh
