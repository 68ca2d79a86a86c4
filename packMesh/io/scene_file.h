// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A scene that POV-Ray renders, being written.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace packmesh::pov {

/// A text file that replaces an older one only when it is complete.
class SceneFile {
 public:
  /// @throws OutputError when the file cannot be written
  explicit SceneFile(const std::filesystem::path& file);
  ~SceneFile();
  SceneFile(const SceneFile&) = delete;
  SceneFile& operator=(const SceneFile&) = delete;
  SceneFile& operator<<(const std::string& text);
  /// @throws OutputError when the file cannot be written
  void commit();

 private:
  [[noreturn]] void fail();
  void flush();

  std::filesystem::path file_, temporary_;
  std::ofstream stream_;
  std::string text_;
  bool done_ = false;
};

}  // namespace packmesh::pov
