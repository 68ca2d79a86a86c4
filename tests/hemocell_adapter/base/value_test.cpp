// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/base/value.h"

#include <cmath>

#include "packMesh/core/error.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

ValueSpec spec(Kind kind) {
  ValueSpec s;
  s.kind = kind;
  return s;
}

}  // namespace

TEST_CASE("Numbers are parsed entirely or rejected", "[value]") {
  CHECK(toNumber("5e-7") == 5e-7);
  CHECK(toNumber("+0.5") == 0.5);
  CHECK(toNumber("-3") == -3.0);
  for (const char* text : {"", "abc", "1.5x", "1,5", "+-1", "0x10", "1 2", "--1", " 1"}) {
    CAPTURE(text);
    CHECK_FALSE(toNumber(text));
  }
  CHECK(std::isinf(*toNumber("1e999")));
}

TEST_CASE("Values must have the right kind and range", "[value]") {
  ValueSpec fraction = spec(Kind::number);
  fraction.low = 0;
  fraction.lowExcluded = true;
  fraction.high = 1;
  fraction.highExcluded = true;
  CHECK(std::get<double>(parseValue(fraction, " 0.3 ")) == 0.3);
  for (const char* text : {"0", "1", "-0.1", "nan", "inf", "", "0.3.1", "1e999"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(parseValue(fraction, text), Contains("expected a number in (0, 1), found"));
  }
  ValueSpec count = spec(Kind::integer);
  count.low = 0;
  CHECK(std::get<std::int64_t>(parseValue(count, "50")) == 50);
  CHECK(std::get<std::int64_t>(parseValue(count, "50.0")) == 50);
  CHECK(std::get<std::int64_t>(parseValue(count, "1e3")) == 1000);
  CHECK_THROWS_WITH(parseValue(count, "10.7"), Contains("expected a whole number >= 0, found '10.7'"));
  CHECK_THROWS_WITH(parseValue(count, "-1"), Contains(">= 0"));
  CHECK(std::get<bool>(parseValue(spec(Kind::boolean), "Yes")));
  CHECK_THROWS_AS(parseValue(spec(Kind::boolean), "perhaps"), InputError);
  CHECK(std::get<std::string>(parseValue(spec(Kind::axes), "zy")) == "yz");
  CHECK(std::get<std::string>(parseValue(spec(Kind::axes), "none")).empty());
  CHECK_THROWS_AS(parseValue(spec(Kind::axes), "xq"), InputError);
  CHECK_THROWS_AS(parseValue(spec(Kind::axes), "xx"), InputError);
  CHECK(std::get<std::int64_t>(parseValue(spec(Kind::axis), "Y")) == 1);
  CHECK(std::get<Vec3>(parseValue(spec(Kind::vector), " 1 2\n3 ")) == Vec3(1, 2, 3));
  CHECK_THROWS_AS(parseValue(spec(Kind::vector), "1 2"), InputError);
  CHECK_THROWS_AS(parseValue(spec(Kind::vector), "1 2 3 4"), InputError);
  CHECK_THROWS_AS(parseValue(spec(Kind::name), "../RBC"), InputError);
  CHECK_THROWS_AS(parseValue(spec(Kind::name), "a b"), InputError);
}

TEST_CASE("Cell names mean nothing else to spreadsheets, to readers of tables and on command lines",
          "[value]") {
  for (const char* good : {"RBC", "RBC_HO", "a=b", "a-b", "a+b", "a@b", "血", "sphère-2(b)"}) {
    CAPTURE(good);
    CHECK(isCellName(good));
  }
  for (const char* bad : {"", ".a", "=1+1", "+a", "-a", "@a", "＝a", "＋a", "－a", "＠a", "a#b", "a;b", "a,b",
                          "a b", "a\tb", "a\nb", "\u202ea", "\ufeffa", "a\xff"}) {
    CAPTURE(bad);
    CHECK_FALSE(isCellName(bad));
    CHECK_THROWS_WITH(parseValue(spec(Kind::name), std::string("x") + bad + "/"),
                      Contains("a cell name of at most"));
  }
}

TEST_CASE("Typing errors are recognised", "[value]") {
  const std::vector<std::string> known = {"hematocrit", "seed", "clearance", "wallClearance"};
  CHECK(nearestName("hematocrti", known) == std::string("hematocrit"));
  CHECK(nearestName("hematokrit", known) == std::string("hematocrit"));
  CHECK(nearestName("Seed", known) == std::string("seed"));
  CHECK(nearestName("WALLC", known) == std::string("wallClearance"));
  CHECK(nearestName("wallclearence", known) == std::string("wallClearance"));
  CHECK_FALSE(nearestName("viscosity", known));
}
