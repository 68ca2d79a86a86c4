// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lines of .pos files that were read, kept to write unmoved cells unchanged.
#pragma once

#include <string>
#include <unordered_map>

#include "hemocell_adapter/hemocell/pos_file.h"

namespace packmesh::hemocell {

/// Lines of .pos files that were read: cells that have not moved are written exactly as read.
class ReadLines {
 public:
  void add(const PosLine& line);
  /// The line that represents a pose.
  PosLine lineOf(const Pose& pose) const;

 private:
  std::unordered_map<std::string, PosLine> lines_;  ///< key: the bits of the pose
};

}  // namespace packmesh::hemocell
