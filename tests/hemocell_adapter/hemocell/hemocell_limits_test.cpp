// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/hemocell_limits.h"

#include <fmt/format.h>

#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"
#include "tests/support/shapes.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

TEST_CASE("More cells than HemoCell can number require limits on two axes", "[hemocell_limits]") {
  CHECK_FALSE(cellNumberWarning(0, {}));
  CHECK_FALSE(cellNumberWarning(212622, {}));
  const auto warning = cellNumberWarning(212623, {});
  REQUIRE(warning);
  CHECK_THAT(*warning, Contains("more than 212622") && Contains("setSystemPeriodicityLimit(0, 99);\n") &&
                           Contains("setSystemPeriodicityLimit(1, 99);"));
  CHECK_THAT(*cellNumberWarning(1000000, {}), Contains("Limit(0, 45)") && Contains("Limit(1, 45)"));
  CHECK_THAT(*cellNumberWarning(10000000, {}), Contains("Limit(0, 14)"));
  CHECK_THAT(*cellNumberWarning(2000000000, {}), Contains("with any settings"));
  // What the case says already.
  CHECK_FALSE(cellNumberWarning(1000000, {{0.0, 45.0}, {1.0, 45.0}}));
  CHECK(cellNumberWarning(1000000, {{0.0, 46.0}, {1.0, 46.0}}));
  CHECK(cellNumberWarning(1000000, {{0.0, 45.0}}));
  CHECK(cellNumberWarning(1000000, {{0.0, 45.0}, {1.0, {}}}));
}

TEST_CASE("A particleEnvelope that stretched cells exceed gives a warning with the tag to set",
          "[hemocell_limits]") {
  const TriangleMesh red = buildTemplate(*defaultModel("RBC"), 0.5);
  double longest = 0.0;
  for (const Vec3& a : red.vertices)
    for (const Vec3& b : red.vertices) longest = std::max(longest, (a - b).norm());
  CHECK(longestExtent(red) == longest);
  CHECK(neededEnvelope(longest, 0.5, 1.0) == 16);
  const int weak = neededEnvelope(longest, 0.5, weakShear.allowance);
  const int strong = neededEnvelope(longest, 0.5, strongShear.allowance);
  CHECK(neededEnvelopeAt(weakShear.wallShearStress, longest, 0.5) == weak);
  CHECK(neededEnvelopeAt(weakShear.wallShearStress + 0.1, longest, 0.5) == strong);
  const auto tag = [](int nodes) { return fmt::format("<particleEnvelope> {} </particleEnvelope>", nodes); };
  Domain domain;
  domain.dx = 0.5;
  domain.particleEnvelopeWhere = "config.xml:9: <particleEnvelope>";
  const auto warning = [&](std::optional<int> envelope) {
    domain.particleEnvelope = envelope;
    return envelopeWarning("RBC", longest, domain, std::array<int, 3>{103, 53, 53}).value_or("");
  };
  CHECK(warning({}).empty());
  CHECK(warning(strong).empty());
  CHECK_THAT(warning(15), Contains("config.xml:9: <particleEnvelope>: 15 is 0.96 times") &&
                              Contains("15.6 nodes") && Contains(tag(weak)) && Contains(tag(strong)));
  CHECK_THAT(warning(16), Contains("1.02 times the longest extent of RBC at rest") && Contains(tag(weak)));
  // HemoCell's own examples: enough for weak shear.
  CHECK_THAT(warning(25), Contains("25 is 1.60 times the longest extent of RBC at rest, 15.6 nodes") &&
                              Contains("to 2.5 times at 10 Pa (100000 iterations)") &&
                              Contains("Above 2 Pa set") && !Contains(tag(weak)) && Contains(tag(strong)));
  CHECK_THAT(
      warning(25),
      Contains("with 44 nodes, a lattice of 103 x 53 x 53 has room for 2 x 1 x 1 blocks, so for 2 ranks"));
  domain.wallShearStress = weakShear.wallShearStress;  // the case says that it has no stronger shear
  CHECK(warning(25).empty());
  CHECK_THAT(warning(15), Contains(tag(weak)));
  domain.wallShearStress = strongShear.wallShearStress;
  CHECK_THAT(warning(25), Contains(tag(strong)));
  domain.smallestBlock = {26, 53, 27};
  CHECK_THAT(warning(25), Contains("the smallest block is now 26 x 53 x 27"));
  CHECK_FALSE(Contains("blocks").match(*envelopeWarning("RBC", longest, domain, {})));
}

TEST_CASE("The recommended particleEnvelope is not longer than the lattice", "[hemocell_limits]") {
  Domain domain;
  domain.dx = 0.5;
  const double length = 7.9;
  const auto warning = [&](int envelope, std::array<int, 3> lattice) {
    domain.particleEnvelope = envelope;
    return envelopeWarning("RBC", length, domain, lattice).value_or("");
  };
  const auto tag = [](int nodes) { return fmt::format("<particleEnvelope> {} </particleEnvelope>", nodes); };
  REQUIRE(neededEnvelope(length, 0.5, strongShear.allowance) == 44);
  CHECK_THAT(warning(20, {40, 40, 40}),
             Contains("Set\n  " + tag(24) + "\nor, above 2 Pa,\n  " + tag(40)) && !Contains(tag(44)) &&
                 Contains("The lattice has 40 nodes along its longest axis, fewer than the 44") &&
                 Contains("with 40 nodes, a lattice of 40 x 40 x 40 has room for 1 x 1 x 1 blocks"));
  CHECK_THAT(warning(25, {40, 40, 40}), Contains("Above 2 Pa set\n  " + tag(40)));
  CHECK_THAT(warning(15, {20, 18, 20}),
             Contains("Set\n  " + tag(20)) && !Contains(tag(24)) && Contains("wall shear stress below 2 Pa"));
  CHECK_THAT(warning(40, {40, 40, 40}), Contains("lengthen it") && !Contains("</particleEnvelope>"));
  CHECK_THAT(warning(25, {43, 27, 27}), Contains(tag(43)));  // narrow, and cells lie along it
  CHECK_FALSE(Contains("lengthen").match(warning(25, {44, 27, 27})));
}

TEST_CASE("Packing, dry run and check report HemoCell's limits", "[executable]") {
  const SampleCase folder;
  for (const int envelope : {12, 25}) {
    writeText(folder / "config.xml",
              configXml(sampleDomain + fmt::format("<particleEnvelope> {} </particleEnvelope>", envelope)));
    for (const char* arguments : {"config.xml --rbc 3 --dry-run", "config.xml --rbc 3", "check config.xml"}) {
      CHECK_THAT(ok(folder, arguments).err, Contains(fmt::format("<particleEnvelope>: {} is ", envelope)) &&
                                                Contains("<particleEnvelope> 44 </particleEnvelope>") &&
                                                Contains("for 1 rank"));
    }
  }
  writeText(folder / "config.xml", configXml(sampleDomain + "<particleEnvelope> wide </particleEnvelope>"));
  CHECK_THAT(run(folder, "config.xml --rbc 3").err, Contains("<particleEnvelope>: expected a whole number"));
  const Ran many = run(folder, "50 50 50 --ends periodic --hematocrit 0.3 --tile 9 9 9 --dry-run");
  INFO(many.all());
  CHECK_THAT(many.err, Contains("setSystemPeriodicityLimit(0, 76)"));
  CHECK(run(folder, "50 50 50 --ends periodic --hematocrit 0.3 --tile 5 5 5 --dry-run").err.empty());
}
