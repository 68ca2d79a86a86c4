// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/request_json.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/settings/command_line.h"
#include "hemocell_adapter/settings/packing_section.h"
#include "packMesh/packing/state_file.h"
#include "tests/support/catch.h"

using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

Request parsed(const std::string& line) {
  std::istringstream text(line);
  std::vector<std::string> words;
  for (std::string word; text >> word;) words.push_back(word);
  return parseCommandLine("packMesh", words).request;
}

Request requestOfSection(const std::string& text) {
  tinyxml2::XMLDocument document;
  REQUIRE(document.Parse(text.c_str()) == tinyxml2::XML_SUCCESS);
  return readPackingSection(*document.RootElement(), "config.xml");
}

/// What is wrong with JSON, in the terms of the program.
std::string refusal(const char* json) {
  try {
    withJson({}, Json::parse(json), {Origin::Kind::keyword, ""});
  } catch (const InputError& error) {
    return inTermsOfUser(error.what());
  }
  return "";
}

}  // namespace

TEST_CASE("Every stated setting passes through JSON unchanged", "[settings]") {
  for (const char* line :
       {"20 21.5 1e2 --hematocrit 0.3 --plt_ratio 0.1 --seed 7 --fluid-volume --noRotate --walls none",
        "config.xml --discharge-hematocrit 0.3 --pre-inlet Xpos --pre-inlet-slice last-5 --pre-inlet-range y "
        "0 last",
        "20 20 20 --rbc 3 --cell egg 4 1 2 3 --cell-mesh S 5 s.stl --mesh-scale S 2 --mesh-frame S file",
        "20 20 20 --plt 3 --orient PLT 1 0 0 20 --stock PLT 4 --method cat --escape --builder cat-faces",
        "20 20 20 --rbc 3 --method cat --growth alpha 0.5 --growth iterations 30 --growth-frames 3",
        "--cylinder y 5 20 --rbc 1 --ends periodic --clearance max --wall-clearance auto --cell-free-layer 2",
        "--vessel v.stl 2.5 --open-axis z --rbc 1 --flat-openings refuse --profile developed --max-time 0.1",
        "--open-axis z --vessel v.stl 2.5 --rbc 1 --clearance 0.3 --rbc-volume 97 --threads 2 --best-effort",
        "config.xml --open-axis z --minimum-distance-from-solid RBC 1.5 --also-dx 0.25 1 --maxiter 50",
        "20 20 20 --fixed a.h5 --fixed PLT.pos --start RBC.pos --start b.h5 --blood c.h5 --keep-all --dx 0.4",
        "20 20 20 --rbc 1 --tile 2 1 3 --export csv --export gsd --report r.html --state s.h5 --vtp --pov",
        "20 20 20 --rbc 1 --output-dir out --realisations 3 --checkpoint-every 60 --dry-run --order columns",
        "--restart s.h5 --verbose --scale 3 --validate --vtp-meshes", "check --sphere 5 --quiet"}) {
    CAPTURE(line);
    const Request request = parsed(line);
    const Json json = toJson(request);
    CAPTURE(json.dump(1));
    const Request again = withJson({}, Json::parse(json.dump()), {});
    CHECK(toJson(again) == json);
    CHECK(again.species.size() == request.species.size());
    std::vector<std::string> keys, keysAgain;
    for (const auto& [key, origin] : request.origins) keys.push_back(key);
    for (const auto& [key, origin] : again.origins)
      if (key.size() < 5 || key.substr(key.size() - 5) != ".name") keysAgain.push_back(key);
    CHECK(keys == keysAgain);
  }
}

TEST_CASE("A section passes through JSON with its bodies", "[settings]") {
  const Request request = requestOfSection(
      "<packing><species name='RBC'/><species name='A' ratio='0.1' construction='WBC_SPHERE'/>"
      "<container><mesh file='v.stl' openAxis='x'/><obstacles><sphere radius='2' center='1 2 3'/>"
      "<box size='1 2 3'/></obstacles><nodes>4 5 6</nodes></container>"
      "<region hematocrit='0'><cylinder radius='2' length='3'/></region>"
      "<region count='7'><beyond point='1 2 3' direction='0 1 0'/><species name='PLT' count='5'/></region>"
      "<region><halfSpace point='1 2 3' normal='0 1 0'/><species name='B' count='0'/></region>"
      "<growth barriers='0.5 1'/></packing>");
  const Json json = toJson(request);
  CHECK(json["container"]["obstacles"][0] ==
        Json::parse(R"({"kind":"sphere","radius":2.0,"center":[1.0,2.0,3.0]})"));
  CHECK(json["growth"] == Json::parse(R"({"barriers":[0.5,1.0]})"));
  CHECK(json["regions"][1] ==
        Json::parse(R"({"count":7,"body":{"kind":"beyond","point":[1.0,2.0,3.0],"direction":[0.0,1.0,0.0]},
                        "species":[{"name":"PLT","count":5}]})"));
  CHECK(toJson(withJson({}, json, {})) == json);
  CHECK(request.originOf("species.A.ratio")->place == "config.xml:1: <species>, attribute ratio");
  CHECK(request.originOf("growth")->isSection());
}

TEST_CASE("What is stated later replaces what it says in another way", "[settings]") {
  const Request base = requestOfSection(
      "<packing><dischargeHematocrit>0.3</dischargeHematocrit><seed>4</seed><walls>yz</walls>"
      "<species name='RBC' file='r.stl' scale='2'/><species name='PLT' ratio='0.1' wallClearance='0.3'/>"
      "<container><mesh file='v.stl'/><obstacles><sphere radius='2'/></obstacles></container>"
      "<region hematocrit='0.1'><sphere radius='3'/></region></packing>");
  const Request changed =
      overridden(overridden(base, parsed("config.xml --plt 4")),
                 parsed("config.xml --hematocrit 0.2 --cell RBC 5 1 2 3 --cylinder x 4 9 --noRotate"));
  CHECK(changed.hematocrit == 0.2);
  CHECK_FALSE(changed.dischargeHematocrit);
  CHECK_FALSE(changed.states("dischargeHematocrit"));
  CHECK(changed.seed == 4);
  CHECK_FALSE(changed.rotate);
  CHECK(changed.species[0].ellipsoidAxes == Vec3(1, 2, 3));
  CHECK_FALSE(changed.species[0].meshFile);
  CHECK_FALSE(changed.species[0].meshScale);
  CHECK(changed.species[1].count == 4);
  CHECK_FALSE(changed.species[1].ratio);
  CHECK_FALSE(changed.states("species.PLT.ratio"));
  CHECK(changed.species[1].wallClearance == 0.3);
  CHECK(changed.container->lumen->kind == SolidRequest::Kind::cylinder);
  CHECK(changed.container->obstacles.size() == 1);
  CHECK(changed.regions.size() == 1);
  CHECK(changed.originOf("walls")->place == "config.xml:1: <walls>");
  CHECK(changed.originOf("species.PLT.count")->kind == Origin::Kind::option);
  const Request opened = overridden(base, parsed("config.xml --open-axis z"));
  CHECK(opened.container->lumen->openAxis == 2);
  CHECK(opened.container->lumen->file == "v.stl");
  CHECK_THAT(opened.container->lumen->where, Contains("config.xml:1: <mesh>"));
}

TEST_CASE("JSON that cannot be a request is refused with its place", "[settings]") {
  CHECK_THAT(refusal(R"({"maxTime": -3})"), Contains("option '--max-time': expected a number in (0"));
  CHECK_THAT(refusal(R"({"maxTime": -3})"), Contains("found '-3'"));
  CHECK_THAT(refusal(R"({"box": [20, 20]})"), Contains("expected three numbers"));
  CHECK_THAT(refusal(R"({"hematocrit": [1, 2]})"), Contains("found '1 2'"));
  CHECK_THAT(refusal(R"({"maxtime": 3})"), Contains("maxtime: is no setting"));
  CHECK_THAT(refusal(R"({"species": [{"name": "RBC", "count": -1}]})"),
             Contains("species[\"RBC\"].count: expected a whole number"));
  CHECK_THAT(refusal(R"({"species": [{"name": "RBC", "count": 1, "ratio": 1}]})"),
             Contains("both a count and a ratio"));
  CHECK_THAT(refusal(R"({"species": [{"name": "RBC", "counts": 1}]})"), Contains("is no attribute"));
  CHECK_THAT(refusal(R"({"species": [{"count": 1}]})"), Contains("a name is missing"));
  CHECK_THAT(refusal(R"({"growth": {"alpha": 2}})"), Contains("option '--growth' alpha: expected"));
  CHECK_THAT(refusal(R"({"tile": [2, 2]})"), Contains("expected 3 values, found 2 2"));
  CHECK_THAT(refusal(R"({"export": "csv"})"), Contains("expected a list"));
  CHECK_THAT(refusal(R"({"container": {"obstacles": [{"kind": "box", "size": [1, -2, 3]}]}})"),
             Contains("obstacles[0].size: expected three numbers"));
  CHECK_THAT(refusal(R"({"container": {"obstacles": [{"kind": "cube"}]}})"),
             Contains("obstacles[0]: expected a body"));
  CHECK_THAT(refusal(R"({"regions": [{"hematocrit": 2, "body": {"kind": "sphere", "radius": 1}}]})"),
             Contains("regions[0].hematocrit: expected a number in [0, 1)"));
  CHECK_THAT(refusal(R"({"regions": [{"hematocrit": 0, "body": {"kind": "sphere"}}]})"),
             Contains("regions[0]: radius is missing"));
  CHECK_THAT(refusal(R"({"regions": [{"count": 1.5, "body": {"kind": "sphere", "radius": 1}}]})"),
             Contains("regions[0].count: expected a whole number"));
  CHECK_THAT(
      refusal(R"({"regions": [{"body": {"kind": "sphere", "radius": 1}, "species": [{"name": "PLT"}]}]})"),
      Contains("regions[0].species: expected a name and a count"));
  CHECK_THAT(refusal(R"({"regions": [{"count": 1}]})"), Contains("regions[0]: expected a body"));
  CHECK_THAT(refusal(R"({"container": {"lumen": {"kind": "beyond", "point": [1, 2, 3]}}})"),
             Contains("expected a body (box, cylinder, sphere or mesh)"));
  CHECK_THROWS_AS(withJson({}, Json::parse("[]"), {Origin::Kind::state, ""}), InputError);
}

TEST_CASE("Settings in messages are named as the front end names them", "[settings]") {
  const std::string text = heading("walls") + ": see " + named("ends", "periodic") + " and " + named("box");
  CHECK(inTermsOfUser(text) == "option '--walls': see --ends periodic and sX sY sZ");
  CHECK(inTermsOfUser("\x01 not ended") == "\x01 not ended");
  CHECK(inTermsOfUser("none") == "none");
}

TEST_CASE("Numbers of cells that refer to nothing are refused, as a changed state can have them",
          "[request]") {
  const MemoryInput whole{"cells",
                          "start",
                          {{"/box", 3, {0, 0, 0, 9, 9, 9, 0, 0, 0}},
                           {"A/vertices", 3, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}},
                           {"A/triangles", 3, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}},
                           {"A/poses", 7, {4, 4, 4, 1, 0, 0, 0}},
                           {"A/membranes", 3, {0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1}},
                           {"A/membrane", 1, {0}}}};
  const auto read = [&](const std::string& table, int columns, const std::vector<double>& values) {
    MemoryInput changed = whole;
    for (StateTable& one : changed.tables)
      if (one.name == table) one = {table, columns, values};
    return cellsFrom(Source(std::make_shared<const MemoryInput>(changed)), {}).cells.front().vertices.size();
  };
  CHECK(read("", 1, {}) == 4);
  CHECK(read("A/membrane", 1, {-1}) == 0);
  for (const double row : {1.0, 2147483647.0, 1e300, std::nan("")})
    CHECK_THROWS_AS(read("A/membrane", 1, {row}), InputError);
  CHECK_THROWS_AS(read("A/membrane", 1, {}), InputError);
  CHECK_THROWS_AS(read("A/membranes", 3, {0, 0, 0}), InputError);
  CHECK_THROWS_AS(read("A/poses", 1, {4, 4, 4}), InputError);
  CHECK_THROWS_AS(read("A/triangles", 3, {0, 2, 4}), InputError);
  CHECK_THROWS_AS(read("/box", 3, {0, 0, 0}), InputError);
}
