// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/temporary_name.h"

#include <catch2/catch.hpp>

using namespace packmesh;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

TEST_CASE("Temporary names contain host and process and are never too long", "[io]") {
  const std::filesystem::path name = temporaryName("folder/state.h5", 7, "new");
  CHECK(name.parent_path() == "folder");
  CHECK_THAT(name.filename().string(), StartsWith(".state.h5~") && EndsWith("-7.new") &&
                                           Contains(std::to_string(processNumber())) &&
                                           Contains(hostName().substr(0, 60)));
  CHECK(temporaryName("a", 0, "new") != temporaryName("a", 1, "new"));

  std::string longest;
  while (longest.size() < 250) longest += "血";
  CHECK(temporaryName(longest, 1000, "new").filename().string().size() < 256);
}

TEST_CASE("Temporary files are told from those of targets with similar names", "[io]") {
  const std::string longName(200, 'x');
  const std::vector<std::string> targets = {"run",  "run.h5",       "run.h5.h5",   "run~a",
                                            "run~", longName + "1", longName + "2"};
  for (const std::string& target : targets)
    for (const std::string& other : targets) {
      CAPTURE(target, other);
      CHECK(isTemporaryOf(temporaryName("folder/" + other, 0, "new"), "folder/" + target, "new") ==
            (target == other));
      CHECK((lockName(target) == lockName(other)) == (target == other));
    }
  CHECK_FALSE(isTemporaryOf(temporaryName("run", 0, "old"), "run", "new"));
  CHECK_FALSE(isTemporaryOf(lockName("run"), "run", "new"));
}
