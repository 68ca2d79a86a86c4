// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The inlet of a case with a `<preInlet>`, for which HemoCell reads the .pos files.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/base/node_plane.h"
#include "hemocell_adapter/hemocell/lattice.h"

namespace packmesh::hemocell {

/// Where the inlet is: what stands in the case's C++ code (Direction::Xpos and the slice).
struct PreInletPlace {
  int axis = 0;                    ///< of the inflow
  bool atHighEnd = true;           ///< Xpos: beyond the high end; Xneg: before the low one
  std::optional<NodePlane> slice;  ///< that gives the frame; empty: the outermost with fluid nodes
  std::vector<NodeRange> ranges;   ///< nodes of the slice that count, one for each axis at most
  bool allOutlines = false;  ///< the inlet is known to be all of the slice, however many outlines it has
  std::string origin = "as stated";  ///< "AR2.cpp:71", for people

  /// "Xpos", "zneg"...
  static PreInletPlace named(const std::string& direction);

  bool isTowards(const PreInletPlace& other) const {
    return axis == other.axis && atHighEnd == other.atHighEnd;
  }
  /// Whether both are the same nodes of a lattice with so many.
  bool isSame(const PreInletPlace& other, const std::array<int, 3>& nodes) const;
};

/// "slice last - 5, y 0 42".
std::string toString(const PreInletPlace& place);

/// Of a slice that cuts the vessel more than once.
struct SeveralOutlines {
  std::string text;  ///< "the slice of the pre-inlet, plane 4 of nodes along x, has 2 outlines: ..."
  NodeRange first;   ///< takes the largest alone, if any range does
};

/// The inlet in its own frame: origin at the low corner of its box.
struct PreInlet {
  TriangleMesh surface;  ///< the cross-section of the vessel in plane `flags`, along the whole lattice [µm]
  Lattice lattice;
  int slice = 0;  ///< plane of nodes that gives the frame
  int flags = 0;  ///< plane of nodes that is repeated, the neighbour that HemoCell takes the flags from
  /// Whether fluid nodes of the slice lie at the border of the case's lattice: vessels end there only at
  /// their openings, so that the slice is hardly a cross-section.
  bool reachesBorder = false;
  std::optional<SeveralOutlines> severalOutlines = {};  ///< all of them are in the inlet
};

/// The box of the fluid nodes of a slice, with a node around them as far as the lattice reaches, lengthN + 3
/// planes long. As in HemoCell, the nodes in it have the flags of the plane before the slice (of the one
/// behind it where the inflow comes from the low end), in all of the box.
/// @throws InputError, MeshError when the slice has no fluid node, several outlines of which none is chosen,
/// or a cross-section that is no simple polygon
PreInlet makePreInlet(const VesselOnLattice& vessel, const PreInletPlace& place, int lengthN);

}  // namespace packmesh::hemocell
