// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The innermost loops of soft cells. Kernels: see instruction_set.h.
#pragma once

#include <cstddef>
#include <cstdint>

#include "packMesh/simd/instruction_set.h"

namespace packmesh {

/// A law x + x / (limit - x²), continued linearly where |x| > turn.
struct MembraneLaw {
  float limit, turn, slope;
};

/// Bending by the angles at edges.
struct HingeView {
  /// Four per edge: corners at its right and left, and these triangles; nullptr: bending is that of patches.
  const std::int16_t* corner = nullptr;
  const float* rest = nullptr;  ///< cosine and sine of the angle of each edge at rest
  float height = 0.0f;          ///< of triangles [µm]
};

/// Links through the cell.
struct SpringView {
  int count = 0;
  const std::int16_t* end = nullptr;  ///< two per link
  const float* number = nullptr;  ///< three per link: inverse length, force at unit strain, largest strain
};

/// What the models of platelets and white cells have instead, or in addition.
struct ModelView {
  HingeView hinges = {};
  SpringView springs = {};
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
  ModelView model = {};

  /// Numbers that the forces of a cell need in addition.
  std::size_t scratch() const { return 5 * std::size_t(triangles) + 6 * std::size_t(vertices); }
};

// A kernel: see packMesh/simd/instruction_set.h. Numbers of a batch stand by vertex, then by component, then
// by cell.

struct MembraneBatch {
  static constexpr int cells = 16;
  float* position;      ///< 3 per vertex [µm]
  const float* listed;  ///< 3 per vertex: positions for which contacts were listed [µm]
  float* step;          ///< 3 per vertex: the last one [µm]
  float* force;         ///< 4 per vertex: force of contacts [pN], their stiffness [pN/µm]; changed
  const float* gap;     ///< 1 per vertex: no nearer is what it could meet [µm]
  float* scratch;       ///< MembraneView::scratch
  const float* scale;   ///< per cell
  const float* moves;   ///< per cell: 1, or 0 for those that rest
  // Results, per cell
  float* volume;        ///< [µm³]
  float* largestForce;  ///< on a vertex [pN]
  float* farthest;      ///< from `listed` [µm]
};

struct StepSettings {
  float momentum;          ///< share of the last step that is added
  float shareOfGap, most;  ///< largest step: as a share of the gap, and [µm]
  float stiffness;         ///< of links, for a scale of 1 [pN/µm]
};

using MembraneKernel = void (*)(const MembraneView&, const MembraneBatch&, const StepSettings&);

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
MembraneKernel membraneKernel();
inline MembraneKernel membraneKernel(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return membraneKernel<constant.value>(); });
}

// Two triangles meet first where a vertex of one meets the other, or where two edges cross: these pairs of a
// vertex and a triangle, and of two edges, are the contacts, as in incremental potential contact (Li et al.,
// ACM Trans. Graph. 39(4), 2020).
//
// A kernel: see packMesh/simd/instruction_set.h.

/// Four vertices: a vertex of one cell and three corners of a triangle of another one, or two ends of edges
/// of both; sixteen of them, so that they are read in lanes.
using VertexFours = std::int16_t[4][16];

enum class ContactKind { vertexTriangle, edgeEdge };

/// Vertices of two cells [µm], four numbers each: x, y, z, and one that is not used.
struct CellPair {
  const float *first, *second;
  float offset[3];  ///< added to those of the second one
};

/// The force between membranes at the distance d is stiffness (range - g) range / g, where g = d - clearance:
/// that of a logarithmic barrier.
struct Barrier {
  float clearance, range;  ///< [µm]
  float stiffness;         ///< [pN/µm]
};

/// What a contact does to the second cell.
struct Reaction {
  std::int16_t vertex[3];  ///< of an edge: the second one twice
  float second, third;     ///< weights of these vertices; that of the first is what is left of 1
  float force[3];          ///< of all of them [pN]
  float stiffness;         ///< [pN/µm]
  float gap;               ///< [µm]
};

/// Contacts out of range are not computed until the cells have moved so far that they can be within it.
struct Approach {
  float moved;   ///< sum of the largest steps of both cells since contacts were listed [µm]
  float* until;  ///< of each block: its least distance and `moved` when it was computed; 0: not yet [µm]
};

/// Forces of contacts on the first cell, and the reactions.
/// @param forces of the first cell, 4 per vertex: force [pN] and stiffness [pN/µm]; added to
/// @param gaps of the first cell: no nearer is what a vertex' edges and triangles could meet [µm]; lowered
/// @param reactions at least `size` long. @return their number
using ContactForces = int (*)(ContactKind, const CellPair&, const VertexFours*, int size, const Barrier&,
                              const Approach&, float* forces, float* gaps, Reaction* reactions);

/// Two pieces of a membrane can only meet if they face each other. Pieces whose normals have a larger product
/// cannot, unless others are in between.
constexpr float facing = 0.25f;

/// Boxes of sixteen clusters [µm]; of none: lo > hi.
struct BoxBlock {
  float lo[3][16], hi[3][16];
};
/// Those that have a point in common with a box, as bits.
using BoxesThatMeet = unsigned (*)(const BoxBlock&, const float lo[3], const float hi[3]);

/// Sixteen or fewer vertices, edges or triangles of a cell that are near each other.
struct Cluster {
  const std::int16_t (*vertex)[16];  ///< of each corner
  int count;
  float lo[3], hi[3];               ///< box around all corners [µm]
  float axis[3];                    ///< about across the membrane; 0 where it is folded
  float from, to;                   ///< where the corners are along it [µm]
  float at[3][3][16];               ///< corners and their coordinates [µm]
  float normal[3][16];              ///< their normals; 0 where the membrane is folded
  float center[3][16], radius[16];  ///< of spheres around them
  float inverse[4][16];             ///< of squared lengths
};
/// Pre: vertex, count, box, axis and normals are set
/// @param corners 1 (vertices), 2 or 3
using LoadCluster = void (*)(const float* vertices, const float offset[3], int corners, Cluster&);

/// Contacts of a kind between two clusters with a distance below `limit` [µm].
/// @param same they are of the same cell: only those that face each other
/// @param fours at least 256 long. @return their number
using ListContacts = int (*)(ContactKind, const Cluster& first, const Cluster& second, float limit, bool same,
                             std::int16_t (*fours)[4]);

struct ContactKernels {
  ContactForces forces;
  BoxesThatMeet boxes;
  LoadCluster load;
  ListContacts list;
};

/// The implementation for an instruction set. Pre: available(set).
template <InstructionSet set>
ContactKernels proximityKernels();
inline ContactKernels proximityKernels(InstructionSet set) {
  return forInstructionSet(set, [](auto constant) { return proximityKernels<constant.value>(); });
}

}  // namespace packmesh
