// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Output files to which all ranks contribute.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/io/atomic_files.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// AtomicFiles of the first rank, to which the others send their parts. All ranks call everything.
/// @throws AgreedFailure on all ranks if something cannot be written
class SharedFiles {
 public:
  explicit SharedFiles(const Communicator& ranks) : ranks_(ranks) {}

  void makeFolder(const std::filesystem::path& folder);
  void begin(const std::filesystem::path& target);
  /// Adds the text of the first rank.
  void append(const std::function<std::string()>& text);
  /// Adds the texts of all ranks, in their order.
  void appendParts(const std::vector<std::string>& own);
  void end();
  /// See AtomicFiles. The first rank decides.
  void putAside(const std::filesystem::path& file, const std::filesystem::path& as) {
    files_.putAside(file, as);
  }
  void take(AtomicFiles& others);
  /// Of the file ended last (fileHash()).
  std::string hash();
  void commit();

 private:
  const Communicator& ranks_;
  AtomicFiles files_;  ///< of the first rank
};

}  // namespace packmesh::hemocell
