// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/input_file.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "tests/support/temporary_folder.h"

using namespace packmesh;
using Catch::Matchers::Contains;

TEST_CASE("Files are read whole, and what is none or has no end is refused by name") {
  const test::TemporaryFolder folder;
  const std::string bytes("a\r\n\0b", 5);
  std::ofstream(folder.path() / "file", std::ios::binary) << bytes;
  std::ofstream(folder.path() / "empty");
  CHECK(contentOf(folder.path() / "file", "a file") == bytes);
  CHECK(contentOf(folder.path() / "empty", "a file").empty());
  CHECK_THROWS_WITH(contentOf(folder.path() / "none", "a file"), Contains("none: no such file"));
  CHECK_THROWS_WITH(contentOf(folder.path(), "a file"), Contains("is a folder, expected a file"));
  std::filesystem::create_symlink("/dev/zero", folder.path() / "endless");
  CHECK_THROWS_WITH(contentOf(folder.path() / "endless", "a file"), Contains("endless: is a device"));
}
