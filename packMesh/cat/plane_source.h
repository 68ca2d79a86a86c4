// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The constructions of planes by name.
#pragma once

#include <memory>

namespace packmesh {

struct Execution;
struct Physics;
struct TetrahedraSums;
class PlaneFunction;

/// Construction of the planes within which cells grow.
enum class PlaneSource {
  chords,  ///< shortest chords between neighbours, from distance fields
  /// CAT faces of tetrahedra, as in the thesis. Digests of problems contain the number; 1 was another source.
  catFaces = 2,
};

/// References physics, execution and sums, which must outlive it.
/// @param sums statistics of tetrahedralisation are added to this
std::unique_ptr<PlaneFunction> makePlaneFunction(PlaneSource planeSource, const Physics& physics,
                                                 const Execution& execution, TetrahedraSums& sums);

}  // namespace packmesh
