// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lines of .pos files that were read.
#pragma once

#include <string>
#include <unordered_map>

#include "hemocell_adapter/hemocell/pos_file.h"

namespace packmesh::hemocell {

/// Lines of .pos files that were read: cells that have not moved are written as they were.
class ReadLines {
 public:
  void add(const PosLine& line);
  /// The line that stands for a pose.
  PosLine lineOf(const Pose& pose) const;

 private:
  std::unordered_map<std::string, PosLine> lines_;  ///< by the bits of the pose
};

}  // namespace packmesh::hemocell
