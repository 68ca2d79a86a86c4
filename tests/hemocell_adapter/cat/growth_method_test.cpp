// SPDX-License-Identifier: AGPL-3.0-or-later
// --method cat, with the real executable.
#include <fmt/format.h>

#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;

TEST_CASE("Growth packs a case with voxel walls and a box, and rejects what does not fit the method",
          "[executable]") {
  const SampleCase folder("<packing> <method> cat </method> <builder> chords </builder> </packing>");
  const Ran packed = ok(folder, "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3 --verbose");
  const int rbc = cellsIn(folder / "RBC.pos"), plt = cellsIn(folder / "PLT.pos");
  CHECK(rbc > 10);
  CHECK_THAT(packed.out,
             Contains("HemoCell keeps " + std::to_string(rbc + plt) + " of " + std::to_string(rbc + plt)));
  CHECK_THAT(packed.out, Contains("Certificate: clean"));
  CHECK_THAT(packed.out, Contains("Method: growth"));
  CHECK_THAT(packed.out, Contains("iterations"));
  ok(folder, "check config.xml");
  const std::string first = readText(folder / "RBC.pos");
  ok(folder, "config.xml --hematocrit 0.30 --plt_ratio 0.2 --seed 3");
  CHECK(readText(folder / "RBC.pos") == first);
  requireRefused(folder,
                 {{"config.xml --hematocrit 0.30 --plt_ratio 0.2 --method relaxation", 2, "<method> cat"}});

  const TemporaryFolder box;
  Ran ran = ok(box, "16 16 16 --hematocrit 0.35 --plt_ratio 0 --method cat");
  ok(box, "check --box 16 16 16");
  ran = ended(box, 3, "16 16 16 --hematocrit 0.35 --method cat --max-iterations 3");
  CHECK_THAT(ran.err, Contains("3 iterations"));
  requireRefused(box, {{"16 16 16 --hematocrit 0.35 --method dog", 1, "cat"},
                       {"16 16 16 --hematocrit 0.35 --builder chords", 1, "'--builder' is for --method cat"},
                       {"16 16 16 --hematocrit 0.35 --escape", 1, "'--escape' is for --method cat"}});
  ran = ok(box, "10 10 10 --rbc 2 --walls xyz --method cat --escape --verbose --builder cat-faces");
  CHECK_THAT(ran.out, Contains("tetrahedra"));
  CHECK_THAT(ran.out, Contains("attempts of TetGen"));
}

TEST_CASE("The executable passes on the growth parameters", "[executable]") {
  const TemporaryFolder folder;
  const std::string command = "12 12 12 --rbc 3 --method cat ";
  const auto posOf = [&](const std::string& arguments) {
    ok(folder, command + arguments);
    return readText(folder / "RBC.pos");
  };
  const std::string plain = posOf("");
  // Each of them changes the packing; the values of a table's fallbacks do not.
  for (const auto& parameter : catParameters()) {
    CAPTURE(parameter.name);
    CHECK(posOf(fmt::format("--growth {} '{}'", parameter.name, parameter.fallback)) == plain);
  }
  for (const char* other :
       {"initialScale 0.2", "barriers '0.6 1'", "rotationBound 0.1", "translationBound 0.1", "padding 0.5",
        "linearisations 2", "alpha 1", "beta 1e-9", "centring no", "shaking 0.1"}) {
    CAPTURE(other);
    CHECK(posOf(std::string("--growth ") + other) != plain);
  }
  ended(folder, 3, command + "--growth iterations 1 --growth barriers 1 --growth relaxationSweeps 0");
  requireRefused(folder,
                 {{command + "--growth iterations 0", 1, "'--growth' iterations: expected a whole number"},
                  {command + "--growth barriers '0.5 0.9'", 2, "the last barrier must be 1"},
                  {command + "--growth paddding 1", 1, "did you mean 'padding'?"},
                  {"12 12 12 --rbc 3 --growth padding 0.5", 1, "'--growth' is for --method cat"}});
}

TEST_CASE("Escaping fills gaps from a reserve", "[executable]") {
  const TemporaryFolder folder;
  const std::string command = "12 12 12 --rbc 5 --plt 2 --method cat --stock PLT 4 ";
  const Ran ran = ok(folder, command + "--escape --state state.h5");
  CHECK(cellsIn(folder / "RBC.pos") == 5);
  const std::string platelets = readText(folder / "PLT.pos");
  CHECK(cellsIn(folder / "PLT.pos") == 6);
  CHECK_THAT(ran.out, Contains("PLT: 6 placed (2 requested + 4 from the reserve)"));
  ok(folder, "check --box 12 12 12");
  std::filesystem::remove(folder / "PLT.pos");
  ok(folder, "--restart state.h5");
  CHECK(readText(folder / "PLT.pos") == platelets);
  requireRefused(folder, {{command, 2, "'PLT' has a reserve (stock), which only --escape uses"}});
}
