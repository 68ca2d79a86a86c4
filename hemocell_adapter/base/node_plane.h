// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes of a lattice's nodes, counted from either end.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace packmesh::hemocell {

/// A plane of nodes across an axis: 0 is the first, 1 the next one; -1 is the last, -6 the one that is called
/// "last - 5".
using NodePlane = std::int64_t;

/// Planes from `lo` to `hi`, both included, along an axis.
struct NodeRange {
  int axis = 0;
  NodePlane lo = 0, hi = -1;
};
inline bool operator==(const NodeRange& a, const NodeRange& b) {
  return a.axis == b.axis && a.lo == b.lo && a.hi == b.hi;
}

/// Its number in a lattice with so many nodes along the axis, which may lie outside of 0 .. nodes - 1.
inline std::int64_t planeIn(NodePlane plane, int nodes) {
  return plane >= 0 ? plane : nodes + plane;
}

/// "42", "last", "last - 5".
std::string toString(NodePlane plane);
/// "y 0 42".
std::string toString(const NodeRange& range);

/// Reads what toString writes, blanks around the sign or not; nothing for anything else.
std::optional<NodePlane> nodePlaneFromString(const std::string& text);

}  // namespace packmesh::hemocell
