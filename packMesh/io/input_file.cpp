// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/input_file.h"

#include <fstream>
#include <iterator>
#include <system_error>

#include "packMesh/error.h"

namespace packmesh {

namespace fs = std::filesystem;

void requireFile(const fs::path& file, const std::string& expected) {
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (!fs::exists(status)) throw InputError(file.string() + ": no such file");
  if (fs::is_directory(status)) throw InputError(file.string() + ": is a folder, expected " + expected);
  if (fs::is_character_file(status) || fs::is_block_file(status))
    throw InputError(file.string() + ": is a device, expected " + expected);
}

std::string contentOf(const fs::path& file, const std::string& expected) {
  requireFile(file, expected);
  std::ifstream in(file, std::ios::binary);
  std::string content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in.is_open() || in.bad()) throw InputError(file.string() + ": cannot be read");
  return content;
}

}  // namespace packmesh
