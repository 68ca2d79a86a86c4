// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the C++ code of a case says that config.xml does not.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/base/node_plane.h"
#include "hemocell_adapter/hemocell/source_tokens.h"

namespace packmesh::hemocell {

/// setInitialMinimumDistanceFromSolid("RBC", 1).
struct DistanceCall {
  std::string where;                ///< "pipeflow.cpp:91"
  std::string text;                 ///< the call, for messages
  std::optional<std::string> name;  ///< of the cell; empty: no literal
  std::optional<double> distance;   ///< [µm]; empty: no literal
};

/// preInletFromSlice(Direction::Xpos, slice) or autoPreinletFromBoundary(Direction::Xpos).
struct PreInletCall {
  std::string where, text;
  std::optional<std::string> direction;  ///< "Xpos"; empty: no literal
  std::optional<NodePlane> slice;        ///< empty: it cannot be told from the code
  std::vector<NodeRange> ranges;         ///< what of the plane is taken, where it is not all of it

  bool understood() const { return direction && slice; }
};

/// setSystemPeriodicityLimit(0, 45).
struct PeriodicityCall {
  std::optional<double> axis, limit;  ///< empty: no literal
};

struct CaseSource {
  std::vector<std::string> files;   ///< names of those that were read
  std::vector<std::string> unread;  ///< why others were not
  std::vector<DistanceCall> distances;
  std::vector<PreInletCall> preInlets;
  std::vector<PeriodicityCall> periodicity;
};

/// Reads the C++ files of a folder, in the order of their names; none of its subfolders.
CaseSource readCaseSource(const std::filesystem::path& folder);

/// Adds what the text of one file says. @param file its name, for messages
void scanSource(const std::string& text, const std::string& file, CaseSource& source);

/// The calls of PreInlet in a file: follows the variables of type Box3D from flagMatrix->getBoundingBox() or
/// literal corners through literal offsets (`slice.x0 = slice.x1 - 5`). What depends on anything else, or on
/// a condition, is unknown.
std::vector<PreInletCall> preInletCalls(const std::vector<Token>& tokens, const std::string& file);

}  // namespace packmesh::hemocell
