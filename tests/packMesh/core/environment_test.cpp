// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/core/environment.h"

#include <catch2/catch.hpp>
#include <cstdlib>

using namespace packmesh;

TEST_CASE("Numbers in the environment are read as a whole") {
  const char* variable = "PACKMESH_TEST_NUMBER";
  const auto numberOf = [&](const char* text, char end = '\0') {
    ::setenv(variable, text, 1);
    return numberInEnvironment(variable, end);
  };
  ::unsetenv(variable);
  CHECK_FALSE(numberInEnvironment(variable));
  CHECK_FALSE(numberOf(""));
  CHECK_FALSE(numberOf("  "));
  CHECK(numberOf("4") == 4);
  CHECK(numberOf(" 12\n") == 12);
  CHECK(numberOf("4 , 2", ',') == 4);
  CHECK(numberOf("-3") == -3);
  for (const char* wrong : {"four", "4x", "4,2", ",", "1e3", "99999999999999999999"})
    CHECK(numberOf(wrong) == -1);
  CHECK(numberOf(", 2", ',') == -1);
  ::unsetenv(variable);
}
