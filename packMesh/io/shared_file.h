// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A file into which several ranks write.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "packMesh/io/checked_file.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// A file that the first rank has created and into which every rank writes its own parts. If not all ranks
/// find it, as in a folder of one node alone, the first rank writes everything.
///
/// Uses the calls of the operating system, not those of MPI: a failed collective write cannot be left by all
/// ranks. Collective: all ranks make the same calls. Errors are recorded, not thrown, so that no rank waits
/// for another that has failed; then nothing more is written on that rank.
class SharedFile {
 public:
  /// @param file name on the first rank
  /// @param target its final name, for messages
  SharedFile(const std::filesystem::path& file, const std::filesystem::path& target,
             const Communicator& ranks);

  /// Writes the parts of all ranks one after the other, in rank order.
  /// @param position of the first part [bytes]
  /// @param own pieces of the part of this rank
  /// @return the position after the last part
  std::int64_t write(std::int64_t position, const std::vector<std::string_view>& own);
  /// Writes text of the first rank alone.
  void writeOfFirst(std::int64_t position, std::string_view text);
  /// Flushes to the disk, compares with what was written, and closes the file.
  void close();
  /// @throws OutputError the first error on this rank
  void requireGood() const;

 private:
  template <class Step>
  void attempt(const Step& step);
  void gather(const std::vector<std::int64_t>& positions, const std::vector<std::string_view>& own);

  const Communicator& ranks_;
  std::optional<CheckedFile> file_;
  bool found_ = true;  ///< whether all ranks find it
  std::string error_;
};

}  // namespace packmesh
