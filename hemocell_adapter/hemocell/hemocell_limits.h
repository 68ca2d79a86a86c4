// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Limits of HemoCell that require changes of the case.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/case.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// HemoCell numbers the periodic images of cells and stops if these numbers could overflow: with its default
/// limits, above 212,622 cells.
/// @param calls calls of setSystemPeriodicityLimit in the case
/// @return the required addition to the case's C++ code; empty if the number of cells is possible
std::optional<std::string> cellNumberWarning(std::int64_t cells, const std::vector<PeriodicityCall>& calls);

/// How many times longer than its template the longest red cell became in a periodic tube, in HemoCell 2.7
/// (docs/howto/simulation.md, "How long cells become").
struct MeasuredStretch {
  int wallShearStress;  ///< [Pa]
  double stretch;
  int iterations;    ///< of 0.1 µs
  double allowance;  ///< what is recommended: as `stretch`, for longer runs
};
constexpr MeasuredStretch weakShear = {2, 1.2, 25000, 1.5}, strongShear = {10, 2.5, 100000, 2.75};

/// `<particleEnvelope>` [nodes] for cells of this length [µm] at rest: HemoCell knows the vertices of a cell
/// only within it of each block that has a part of the cell, and deletes a cell of which one is missing.
/// @param dx lattice spacing [µm]
int neededEnvelope(double length, double dx, double stretch);

/// The same at this stress [Pa], up to the strongest measured.
int neededEnvelopeAt(double wallShearStress, double length, double dx);

/// Whether the flow can stretch cells beyond `<particleEnvelope>`. What is recommended is at most the longest
/// extent of the lattice: of the nodes around a block, HemoCell exchanges those of the lattice and of its
/// next images, and files do not tell along which axes those are.
/// @param cell name of the longest kind of cell
/// @param length its longest extent at rest [µm]
/// @param lattice nodes along each axis, if known
/// @return the tag to set, for weak and for strong shear, and how many blocks it leaves room for; what to do
/// where the lattice is too short for it; empty if the present one is as recommended for the stress that the
/// case expects, or without one for strong shear, or is not given
std::optional<std::string> envelopeWarning(const std::string& cell, double length, const Domain& domain,
                                           const std::optional<std::array<int, 3>>& lattice);

/// Largest distance between two vertices [unit of the mesh].
double longestExtent(const TriangleMesh& mesh);

}  // namespace packmesh::hemocell
