// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One run at a time writes into a folder, or to a state.
#pragma once

#include <filesystem>
#include <vector>

namespace packmesh::hemocell {

/// A lock that this process holds as long as the object lives; the system releases it when the process ends
/// in any other way. It is a lock on a hidden file, which tells who holds it and goes away with it; one that
/// a killed process left behind is in nobody's way. Other machines that see the folder see the lock. Where
/// the file system has no locks there is none.
class RunLock {
 public:
  /// Of a folder, which is made when it is not there (and goes away again when it stays empty).
  /// @throws OutputError when another process holds it
  static RunLock ofFolder(const std::filesystem::path& folder);
  /// Of a file that will be written; its folder as above. Removes what killed runs left of it under
  /// temporary names. @throws OutputError when another process holds it
  static RunLock ofFile(const std::filesystem::path& file);

  RunLock(RunLock&& other) noexcept;
  RunLock& operator=(RunLock&&) = delete;
  ~RunLock();

 private:
  RunLock() = default;
  void makeFolder(const std::filesystem::path& folder);
  void take(const std::filesystem::path& path, const std::filesystem::path& target, const char* kind,
            const char* advice);

  std::filesystem::path path_;
  int descriptor_ = -1;
  int atEnd_ = -1;                                ///< see interruption.h
  std::vector<std::filesystem::path> made_ = {};  ///< folders, outermost first
};

}  // namespace packmesh::hemocell
