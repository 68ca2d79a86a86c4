// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Data extracted from the C++ code of a case that config.xml does not contain.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/base/node_plane.h"
#include "hemocell_adapter/hemocell/source_tokens.h"

namespace packmesh::hemocell {

/// Call such as setInitialMinimumDistanceFromSolid("RBC", 1).
struct DistanceCall {
  std::string where;                ///< "pipeflow.cpp:91"
  std::string text;                 ///< the call, for messages
  std::optional<std::string> name;  ///< name of the cell; empty: not a literal
  std::optional<double> distance;   ///< [µm]; empty: not a literal
};

/// Call such as preInletFromSlice(Direction::Xpos, slice) or autoPreinletFromBoundary(Direction::Xpos).
struct PreInletCall {
  std::string where, text;
  std::optional<std::string> direction;  ///< "Xpos"; empty: not a literal
  std::optional<NodePlane> slice;        ///< empty: cannot be determined from the code
  std::vector<NodeRange> ranges;         ///< part of the plane that is used; empty: the whole plane

  bool understood() const { return direction && slice; }
};

/// Call such as setSystemPeriodicityLimit(0, 45).
struct PeriodicityCall {
  std::optional<double> axis, limit;  ///< empty: not a literal
};

struct CaseSource {
  std::vector<std::string> files;   ///< names of the files that were read
  std::vector<std::string> unread;  ///< reasons why other files were not read
  std::vector<DistanceCall> distances;
  std::vector<PreInletCall> preInlets;
  std::vector<PeriodicityCall> periodicity;
};

/// Reads the C++ files of a folder, sorted by name; not those of subfolders.
CaseSource readCaseSource(const std::filesystem::path& folder);

/// Adds the data found in the text of one file. @param file its name, for messages
void scanSource(const std::string& text, const std::string& file, CaseSource& source);

/// The calls of PreInlet in a file. Follows variables of type Box3D from flagMatrix->getBoundingBox() or
/// literal corners through literal offsets (`slice.x0 = slice.x1 - 5`). Values that depend on anything else,
/// or on a condition, are unknown.
std::vector<PreInletCall> preInletCalls(const std::vector<Token>& tokens, const std::string& file);

}  // namespace packmesh::hemocell
