// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The inlet of a case with a `<preInlet>`, for which HemoCell reads the .pos files.
#pragma once

#include <optional>
#include <string>

#include "hemocell_adapter/lattice.h"

namespace packmesh::hemocell {

/// Where the inlet is: what stands in the case's C++ code (Direction::Xpos and the slice).
struct PreInletPlace {
  int axis = 0;              ///< of the inflow
  bool atHighEnd = true;     ///< Xpos: beyond the high end; Xneg: before the low one
  std::optional<int> slice;  ///< plane of nodes that is repeated; empty: the outermost with fluid nodes

  /// "Xpos", "zneg"...
  static PreInletPlace named(const std::string& direction);
};

/// The inlet in its own frame: origin at the low corner of its box.
struct PreInlet {
  TriangleMesh
      surface;  ///< the cross-section of the vessel in the slice, repeated along the whole lattice [µm]
  Lattice lattice;
  int slice = 0;
  /// Whether fluid nodes of the slice lie at the border of the case's lattice: vessels end there only at
  /// their openings, so that the slice is hardly a cross-section.
  bool reachesBorder = false;
};

/// The fluid nodes of one plane of the vessel's lattice, with a node around them as far as the lattice
/// reaches, repeated in lengthN + 3 planes.
/// @throws InputError, MeshError when the slice has no fluid node, or a cross-section that is no simple
/// polygon
PreInlet makePreInlet(const VesselOnLattice& vessel, const PreInletPlace& place, int lengthN);

}  // namespace packmesh::hemocell
