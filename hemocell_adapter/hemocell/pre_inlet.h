// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The inlet of a case with a `<preInlet>`, into which HemoCell loads the .pos files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/hemocell/lattice.h"

namespace packmesh::hemocell {

/// Position of the inlet in the case's C++ code (Direction::Xpos and the slice).
struct PreInletPlace {
  int axis = 0;                      ///< axis of the inflow
  bool atHighEnd = true;             ///< Xpos: beyond the high end; Xneg: before the low one
  std::optional<NodePlane> slice;    ///< plane of the frame; empty: the outermost with fluid nodes
  std::vector<NodeRange> ranges;     ///< part of the slice that is used; at most one range per axis
  std::string origin = "as stated";  ///< "AR2.cpp:71", for messages

  /// "Xpos", "zneg"...
  static PreInletPlace named(const std::string& direction);
};

/// The inlet in its own coordinate system: origin at the low corner of its box.
struct PreInlet {
  TriangleMesh surface;  ///< the cross-section of the vessel in plane `flags`, along the whole lattice [µm]
  Lattice lattice;
  int slice = 0;  ///< plane of nodes that defines the frame
  int flags = 0;  ///< plane of nodes that is repeated: the neighbour from which HemoCell takes the flags
  /// True if fluid nodes of the slice lie at the border of the case's lattice. Vessels reach it only at their
  /// openings, so the slice is probably not a cross-section.
  bool reachesBorder = false;
};

/// The box of the fluid nodes of a slice, enlarged by one node within the lattice, lengthN + 3 planes long.
/// As in HemoCell, all nodes in it have the flags of the plane before the slice (of the one after it if the
/// inflow comes from the low end).
/// @throws InputError, MeshError if the slice has no fluid node, has several outlines and no range, or has a
/// cross-section that is not a simple polygon
PreInlet makePreInlet(const VesselOnLattice& vessel, const PreInletPlace& place, int lengthN);

}  // namespace packmesh::hemocell
