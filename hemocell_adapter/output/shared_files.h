// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Output files to which all ranks have something to add.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// AtomicFiles that the first rank writes; the others send it their parts, one rank after the other. All
/// ranks call everything. @throws AgreedFailure on all ranks when something cannot be written
class SharedFiles {
 public:
  explicit SharedFiles(const Communicator& ranks) : ranks_(ranks) {}

  void makeFolder(const std::filesystem::path& folder);
  void begin(const std::filesystem::path& target);
  /// Adds what the first rank says.
  void append(const std::function<std::string()>& text);
  /// Adds what every rank has, in their order.
  void appendParts(const std::string& own);
  void end();
  void commit();

 private:
  const Communicator& ranks_;
  AtomicFiles files_;
};

}  // namespace packmesh::hemocell
