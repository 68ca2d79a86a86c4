// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What kernels read of a membrane.
#pragma once

#include <cstddef>
#include <cstdint>

namespace packmesh {

/// A law x + x / (limit - x²), continued linearly where |x| > turn.
struct MembraneLaw {
  float limit, turn, slope;
};

/// The arrays of a Membrane. Lengths are multiplied by a cell's scale; forces see Membrane.
struct MembraneView {
  int vertices, edges, triangles;
  const std::int16_t* corner;        ///< three per triangle
  const std::int16_t* end;           ///< two per edge
  const int* ringBegin;              ///< of each vertex, and the end
  const std::int16_t* ring;          ///< neighbours of a vertex
  const std::int16_t* ringTriangle;  ///< between a neighbour and the next
  const float* ringShare;            ///< one divided by the number of neighbours that the neighbour has
  const float *inverseLength, *inverseArea, *deviation;
  float inverseMeanEdge, inverseMeanArea, inverseVolume;
  float linkForce, bendForce, areaForce, volumeForce;
  MembraneLaw link, bend, area, volume;
  float volumeStiffness;  ///< largest of the change of volume, as if all vertices moved together [pN/µm]

  /// Numbers that the forces of a cell need in addition.
  std::size_t scratch() const { return 5 * std::size_t(triangles) + 6 * std::size_t(vertices); }
};

}  // namespace packmesh
