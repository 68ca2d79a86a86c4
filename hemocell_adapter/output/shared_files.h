// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Output files to which all ranks contribute.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// AtomicFiles written by the first rank; the others send it their parts, in the order of the ranks. All
/// ranks call everything. @throws AgreedFailure on all ranks if something cannot be written
class SharedFiles {
 public:
  explicit SharedFiles(const Communicator& ranks) : ranks_(ranks) {}

  void makeFolder(const std::filesystem::path& folder);
  void begin(const std::filesystem::path& target);
  /// Adds the text of the first rank.
  void append(const std::function<std::string()>& text);
  /// Adds the texts of all ranks, in their order.
  void appendParts(const std::string& own);
  void end();
  void commit();

 private:
  const Communicator& ranks_;
  AtomicFiles files_;
};

}  // namespace packmesh::hemocell
