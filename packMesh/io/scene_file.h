// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A POV-Ray scene being written.
#pragma once

#include <filesystem>
#include <string>

#include "packMesh/io/atomic_files.h"

namespace packmesh::pov {

/// A text file that replaces an existing one only when it is complete.
class SceneFile {
 public:
  /// @throws OutputError if the file cannot be written
  explicit SceneFile(const std::filesystem::path& file) { files_.begin(file); }
  SceneFile& operator<<(const std::string& text) {
    text_ += text;
    if (text_.size() >= chunk) flush();
    return *this;
  }
  /// @throws OutputError if the file cannot be written
  void commit() {
    flush();
    files_.end();
    files_.commit();
  }

 private:
  static constexpr std::size_t chunk = 1 << 20;  ///< bytes collected before they are written
  void flush() {
    files_.append(text_);
    text_.clear();
  }

  AtomicFiles files_;
  std::string text_;
};

}  // namespace packmesh::pov
