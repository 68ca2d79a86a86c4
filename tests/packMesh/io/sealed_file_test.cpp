// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/sealed_file.h"
#include "packMesh/core/error.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace packmesh;
namespace fs = std::filesystem;

namespace {

void write(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace

TEST_CASE("A seal identifies a file and detects any change of it") {
  const test::TemporaryFolder folder;
  const fs::path file = folder.path() / "sealed";
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{1} << 20, (std::size_t{3} << 20) + 7}) {
    write(file, std::string(sealSize, '?') + std::string(size, 'x'));
    REQUIRE(seal(file, {"thing", 3, "me"}).empty());
    const std::string sealed = test::readText(file);
    REQUIRE(sealed.size() == sealSize + size);
    REQUIRE_THAT(sealed, StartsWith("packMesh thing, version 3\nwritten by me\nXXH3 "));
    REQUIRE(requireSealed(file, "thing", 3, 3) == 3);
    REQUIRE(requireSealed(file, "thing", 2, 4) == 3);
    REQUIRE_THROWS_WITH(
        requireSealed(file, "thing", 4, 4),
        Contains("sealed: is a thing of version 3, written by me; this packMesh reads version 4") &&
            Contains("me"));
    REQUIRE_THROWS_WITH(requireSealed(file, "something", 3, 3), Contains("is not a packMesh something"));
    for (const std::size_t at :
         {std::size_t{16}, std::size_t{40}, std::size_t{60}, sealSize - 1, sealed.size() - 1}) {
      std::string changed = sealed;
      changed[at] ^= 1;
      write(file, changed);
      REQUIRE_THROWS_AS(requireSealed(file, "thing", 3, 3), InputError);
    }
    write(file, sealed + "y");
    REQUIRE_THROWS_WITH(requireSealed(file, "thing", 3, 3), Contains("damaged"));
    for (const std::size_t left : {sealed.size() - 1, sealSize - 1, std::size_t{30}}) {
      write(file, sealed.substr(0, left));
      REQUIRE_THROWS_WITH(requireSealed(file, "thing", 3, 3), Contains("truncated"));
    }
  }
  fs::remove(file);
  REQUIRE_THROWS_WITH(requireSealed(file, "thing", 3, 3), Contains("no such file"));
  REQUIRE(!seal(file, {"thing", 3, "me"}).empty());
}
