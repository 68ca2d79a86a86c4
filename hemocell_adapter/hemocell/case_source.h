// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Calls with literal arguments in the C++ code of a case: data that config.xml does not contain.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/base/node_plane.h"

namespace packmesh::hemocell {

/// Call of hemocell.setInitialMinimumDistanceFromSolid("RBC", 1).
struct DistanceCall {
  std::string where;                ///< "pipeflow.cpp:91"
  std::string text;                 ///< the call, for messages
  std::optional<std::string> name;  ///< name of the cell; empty: not a literal
  std::optional<double> distance;   ///< [µm]; empty: not a literal
};

/// Call of preInlet->autoPreinletFromBoundary(Direction::Xpos) or preInletFromSlice(Direction::Xpos, slice).
struct PreInletCall {
  std::string where, text;
  std::optional<std::string> direction;  ///< "Xpos"; empty: not a literal
  std::optional<NodePlane> slice;        ///< of autoPreinletFromBoundary with a literal
};

/// Call of hemocell.setSystemPeriodicityLimit(0, 45).
struct PeriodicityCall {
  std::optional<double> axis, limit;  ///< empty: not a literal
};

/// Call of defineDynamics(lattice, box, new BounceBack...), which makes the nodes of a box solid.
struct WallCall {
  std::string where, text;
};

/// Call of hemocell.setSystemPeriodicity(1, true), unless it says false.
struct PeriodicAxis {
  std::string where, text;
  std::optional<int> axis;  ///< empty: not a literal
};

struct CaseSource {
  std::vector<std::string> files;   ///< names of the files that were read
  std::vector<std::string> unread;  ///< reasons why other files were not read
  std::vector<DistanceCall> distances;
  std::vector<PreInletCall> preInlets;
  std::vector<PeriodicityCall> periodicity;
  std::vector<WallCall> walls;
  std::vector<PeriodicAxis> periodicAxes;
};

/// Reads the C++ files of a folder, sorted by name; not those of subfolders.
CaseSource readCaseSource(const std::filesystem::path& folder);

/// Adds the calls in the text of one file: those of members (`hemocell.` or `hemocell->`) outside comments.
/// Text that is not C++ is accepted. @param file its name, for messages
void scanSource(const std::string& text, const std::string& file, CaseSource& source);

}  // namespace packmesh::hemocell
