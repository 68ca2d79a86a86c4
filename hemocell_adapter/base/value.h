// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Typed values of options and tags: expected values, strict parsing, error messages.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "packMesh/core/vector.h"

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

enum class Kind {
  number,   ///< finite decimal number, or one of ValueSpec::choices; double or std::string
  integer,  ///< whole number (`50`, `50.0`, `1e3`); std::int64_t
  boolean,  ///< true/false, yes/no, on/off, 1/0; bool
  text,     ///< any non-empty text; std::string
  name,     ///< a cell name, used as file name and table entry; std::string
  choice,   ///< one of ValueSpec::choices; std::string
  axis,     ///< x, y or z; std::int64_t 0, 1, 2
  plane,    ///< a plane of nodes: `42`, `last`, `last - 5`; NodePlane (std::int64_t)
  axes,     ///< some of x, y, z or `none`; std::string of the sorted letters
  vector,   ///< three numbers; Vec3
  numbers,  ///< one or more; std::vector<double>
};

struct MemoryInput;  // numbers instead of a file (settings/request.h)
using Value = std::variant<bool, std::int64_t, double, std::string, Vec3, std::vector<double>,
                           std::shared_ptr<const MemoryInput>>;

/// True for names of cells, which become names of files and entries of tables: visible, without what other
/// programs take for something else. A spreadsheet takes =, +, - or @ at the beginning for a formula, a
/// program takes - for an option, a reader of tables takes # for a comment.
bool isCellName(const std::string& text);
/// What it expects.
std::string expectedCellName();

/// Specification of one value.
struct ValueSpec {
  Kind kind = Kind::text;
  const char* placeholder = "";  ///< in the usage: `h`, `name`, `file`
  const char* unit = "";
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool lowExcluded = false, highExcluded = false;
  std::vector<std::string> choices = {};
};

/// "a number > 0 [µm]", "closed or periodic": for messages and the reference.
std::string expectation(const ValueSpec& spec);

/// Parses `text` (surrounding white space ignored) according to `spec`.
/// @throws InputError "expected a number > 0 [µm], found 'abc'"
Value parseValue(const ValueSpec& spec, const std::string& text);

/// Parses the whole of `text` as a number, independent of the locale; empty if it is not one. The result can
/// be NaN or infinite.
std::optional<double> toNumber(const std::string& text);

/// `text` without white space at both ends.
std::string trimmed(const std::string& text);

/// `text` with its ASCII letters in lower case.
std::string lowered(std::string text);

/// The candidate most similar to `name`, if it is similar enough for `name` to be a likely typing error.
std::optional<std::string> nearestName(const std::string& name, const std::vector<std::string>& candidates);

/// "a", "a or b", "a, b or c".
std::string alternatives(const std::vector<std::string>& items);

}  // namespace packmesh::hemocell
