// SPDX-License-Identifier: AGPL-3.0-or-later
// What the README repeats of the program must be what the program says.
#include <algorithm>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/settings/command_line.h"
#include "tests/hemocell_adapter/executable.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"

using namespace packmesh;
using namespace packmesh::hemocell;

TEST_CASE("README and help list the exit codes", "[readme]") {
  std::string readme = test::readText(std::string(test::sourceFolder) + "/README.md"), help = helpText(false);
  readme.erase(std::remove(readme.begin(), readme.end(), '`'), readme.end());
  std::replace(help.begin(), help.end(), '\n', ' ');
  while (help.find("  ") != help.npos) help.erase(help.find("  "), 1);
  for (const ExitCodeMeaning& meaning : exitCodeMeanings) {
    const std::string code = std::to_string(int(meaning.code));
    CHECK_THAT(readme, Contains("\n| " + code + " | " + meaning.text + " |\n"));
    CHECK_THAT(help, Contains(" " + code + " " + meaning.text + " "));
  }
}
