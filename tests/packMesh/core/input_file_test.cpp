// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/input_file.h"

#include <sys/stat.h>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;

TEST_CASE("Files are read entirely, and those that are invalid or endless are rejected by name") {
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

  REQUIRE(mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
  CHECK_THROWS_WITH(contentOf(folder.path() / "pipe", "a file"),
                    Contains("pipe: is a pipe, expected a file"));
  CHECK_THROWS_WITH(requireFile(folder.path() / "pipe", "a file"), Contains("is a pipe"));
  CHECK_THROWS_WITH(contentOf("/proc/self/mem", "a file"), Contains("cannot be read: Input/output error"));
  CHECK_FALSE(contentOf("/proc/self/status", "a file").empty());  // says that it is empty

  std::filesystem::create_symlink("loop", folder.path() / "loop");
  CHECK_THROWS_WITH(contentOf(folder.path() / "loop", "a file"), Contains("Too many levels"));
  CHECK(isThere(folder.path() / "loop"));
  CHECK(isThere(folder.path() / "file"));
  CHECK_FALSE(isThere(folder.path() / "none"));
  CHECK_FALSE(isThere(folder.path() / "file/none"));

  const std::string large(3'000'000, 'x');
  std::ofstream(folder.path() / "large") << large;
  CHECK(contentOf(folder.path() / "large", "a file") == large);
}
