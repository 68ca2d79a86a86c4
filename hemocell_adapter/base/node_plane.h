// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes of lattice nodes, counted from either end.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace packmesh::hemocell {

/// A plane of nodes perpendicular to an axis: 0 is the first, 1 the next; -1 is the last, -6 is "last - 5".
using NodePlane = std::int64_t;

/// Planes from `lo` to `hi`, inclusive, along an axis.
struct NodeRange {
  int axis = 0;
  NodePlane lo = 0, hi = -1;
};
inline bool operator==(const NodeRange& a, const NodeRange& b) {
  return a.axis == b.axis && a.lo == b.lo && a.hi == b.hi;
}

/// Index of the plane in a lattice with `nodes` nodes along the axis; can lie outside 0 .. nodes - 1.
inline std::int64_t planeIn(NodePlane plane, int nodes) {
  return plane >= 0 ? plane : nodes + plane;
}

/// "42", "last", "last - 5".
std::string toString(NodePlane plane);
/// "y 0 42".
std::string toString(const NodeRange& range);

/// Parses the output of toString(), with or without blanks around the sign; empty for anything else.
std::optional<NodePlane> nodePlaneFromString(const std::string& text);

}  // namespace packmesh::hemocell
