// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/scene_file.h"

#include <system_error>

#include "packMesh/core/error.h"

namespace packmesh::pov {
namespace {

constexpr std::size_t chunk = 1 << 20;  ///< bytes collected before they are written

}  // namespace

SceneFile::SceneFile(const std::filesystem::path& file) : file_(file), temporary_(file.string() + ".tmp") {
  stream_.open(temporary_, std::ios::binary);
  if (!stream_) fail();
}

SceneFile::~SceneFile() {
  std::error_code ignored;
  if (!done_) std::filesystem::remove(temporary_, ignored);
}

SceneFile& SceneFile::operator<<(const std::string& text) {
  text_ += text;
  if (text_.size() >= chunk) flush();
  return *this;
}

void SceneFile::commit() {
  flush();
  stream_.close();
  if (!stream_) fail();
  std::error_code error;
  std::filesystem::rename(temporary_, file_, error);
  if (error) fail();
  done_ = true;
}

void SceneFile::fail() {
  throw OutputError("cannot write the picture's scene '" + file_.string() + "'");
}

void SceneFile::flush() {
  stream_.write(text_.data(), static_cast<std::streamsize>(text_.size()));
  text_.clear();
}

}  // namespace packmesh::pov
