// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/command_line.h"

#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/request_json.h"
#include "tests/support/catch.h"

using namespace packmesh::hemocell;

namespace {

std::vector<std::string> wordsIn(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

CommandLine parse(const std::string& line, const std::string& program = "packMesh") {
  return parseCommandLine("/usr/bin/" + program, wordsIn(line));
}

std::int64_t countOf(const CommandLine& c, const std::string& name) {
  const Request settings = c.request;
  const SpeciesRequest* species = findSpecies(settings, name);
  return species && species->count ? *species->count : -1;
}

}  // namespace

TEST_CASE("Every form of an option that getopt_long_only accepts is accepted", "[command_line]") {
  for (const char* line :
       {"50 50 50 --hematocrit 0.3", "50 50 50 --hematocrit=0.3", "50 50 50 -hematocrit 0.3",
        "50 50 50 -hematocrit=0.3", "50 50 50 -h 0.3", "-h 0.3 50 50 50", "50 -h 0.3 50 50",
        "50 50 50 --hema 0.3", "--hem=0.3 50 50 50", "50 50 50 -h=0.3", "50 50 50 -h0.3",
        "-r -s 5 50 50 50 -h 0.3", "--hematocrit 0.3 -- 50 50 50", "50 50 50 --hematocrit 0.3 -h 0.3"}) {
    CAPTURE(line);
    const CommandLine c = parse(line);
    CHECK(c.request.hematocrit == 0.3);
    REQUIRE(c.request.boxSize);
    CHECK((*c.request.boxSize)[2] == 50);
  }
}

TEST_CASE("Every option of packCells is accepted", "[command_line]") {
  const CommandLine c = parse(
      "50.5 60 70 --rbc 1 -plt 2 --wbc=3 --vrbc 4 -rbc_m 5 --plt_m 6 --plt_mko 7 --cell egg 8 3 4 5 "
      "--noRotate "
      "--allowRotate --scale 0.3 --maxiter 1000");
  const char* names[] = {"RBC", "PLT", "WBC", "vRBC", "RBC_m", "PLT_m", "PLT_mko", "egg"};
  for (int i = 0; i < 8; ++i) CHECK(countOf(c, names[i]) == i + 1);
  const Request s = c.request;
  CHECK(findSpecies(s, "egg")->ellipsoidAxes == packmesh::Vec3(3, 4, 5));
  CHECK(s.rotate == false);
  CHECK(s.maxIterations == 1000);
  CHECK(s.ignoredScale == 0.3);
  CHECK(parse("1 2 3 --plt_ratio 0.1 -h .3").request.plateletRatio == 0.1);
}

TEST_CASE("Methods and sources of planes are selected by name", "[command_line]") {
  CHECK(!parse("9 9 9 --rbc 1").request.states("method"));
  CHECK(parse("9 9 9 --rbc 1 --method cat").request.method == Method::cat);
  CHECK(parse("9 9 9 --rbc 1 --method=relaxation").request.method == Method::relaxation);
  CHECK(parse("9 9 9 --rbc 1 --builder chords").request.cat.planeSource == packmesh::PlaneSource::chords);
  CHECK(parse("9 9 9 --rbc 1 --builder cat-faces").request.cat.planeSource ==
        packmesh::PlaneSource::catFaces);
  CHECK_THROWS_WITH(parse("9 9 9 --rbc 1 --builder tetgen").request,
                    Contains("--builder") && Contains("chords") && Contains("cat-faces"));
  CHECK(parse("9 9 9 --rbc 1 --escape").request.cat.usesReserve());
  CHECK_THROWS_WITH(parse("9 9 9 --rbc 1 --method growth").request, Contains("cat"));
}

TEST_CASE("Unique prefixes of packCells' options remain unique", "[command_line]") {
  CHECK(parse("9 9 9 --max 7 --rbc 1").request.maxIterations == 7);
  CHECK(countOf(parse("9 9 9 --v 7"), "vRBC") == 7);
  CHECK(parse("9 9 9 --noR --rbc 1").request.rotate == false);
  CHECK(parse("9 9 9 --sc 7 --rbc 1").request.ignoredScale == 7.0);
  CHECK_THROWS_WITH(parse("9 9 9 --he 0.3"), Contains("ambiguous: --hematocrit or --help"));
  CHECK_THROWS_WITH(parse("9 9 9 --rb 3"), Contains("ambiguous"));
}

TEST_CASE("Commands of packmesh are told from files", "[command_line]") {
  for (const char* words : {"view state.h5", "export", "new-case vein.stl case"})
    CHECK_THROWS_WITH(parse(words),
                      Contains(std::string("the other program, packmesh, may have: packmesh ") + words));
  for (const char* words : {"chek config.xml", "chekc"})
    CHECK_THROWS_WITH(parse(words), Contains("did you mean 'check'?"));
}

TEST_CASE("Every form of the command is accepted", "[command_line]") {
  CHECK(parse("config.xml").request.config == std::filesystem::path("config.xml"));
  CHECK(parse("check config.xml").command == Command::check);
  const CommandLine box = parse("check --box 1 2 3");
  CHECK(box.command == Command::check);
  REQUIRE(box.request.boxSize);
  CHECK(parse("--cylinder x 12.5 50 --rbc 3").request.container->lumen->radius == 12.5);
  CHECK(parse("--help").command == Command::help);
  CHECK(parse("50 50 --help").command == Command::help);
  CHECK(parse("--version").command == Command::version);
  CHECK(parse("1 2 3 --rbc 1", "packCells").asPackCells);
  CHECK_FALSE(parse("1 2 3 --rbc 1").asPackCells);
}

TEST_CASE("Errors of the command line suggest a correction", "[command_line]") {
  struct Row {
    const char* line;
    const char* message;
  };
  for (const Row& row : {
           Row{"", "nothing to do"},
           {"--rbc 3", "no container: give"},
           {"50 50", "expected a config.xml or three sizes"},
           {"50 50 50 50", "found 4 sizes"},
           {"a.xml b.xml", "found 2 words"},
           {"50 50 50 --hematocrti 0.3", "unknown option '--hematocrti', did you mean '--hematocrit'?"},
           {"50 50 50 --wibble", "unknown option '--wibble'"},
           {"50 50 50 -j", "unknown option '-j'"},
           {"50 50 50 --hematocrit", "needs a value (--hematocrit h)"},
           {"50 50 50 --hematocrit --rbc 3", "needs a value"},
           {"50 50 50 --hematocrit 30", "expected a number in [0, 1) [fraction], found '30'"},
           {"50 50 50 --hematocrit -0.3", "found '-0.3'"},
           {"50 50 50 --hematocrit nan", "found 'nan'"},
           {"50 50 50 --rbc -5", "expected a whole number in [0, 100000000] [cells], found '-5'"},
           {"50 50 50 --rbc 1e12", "found '1e12'"},
           {"50 50 50 --rbc ten", "found 'ten'"},
           {"50 50 50 --cell egg 3 1 2", "the d is missing"},
           {"50 50 50 --cell egg 3 1 2 x", "option '--cell', d: expected a number"},
           {"50 50 50 --cell ../egg 3 1 2 3", "a cell name"},
           {"50 50 50 --hematocrit 0.3 --rbc 5", "excludes '--rbc'"},
           {"50 50 50 --hematocrit 0.3 --plt 5", "excludes '--plt'"},
           {"50 50 50 --ends open", "expected closed or periodic, found 'open'"},
           {"50 50 50 --walls ab", "expected axes"},
           {"50 50 50 --rbc 1 --box", "is for check"},
           {"check --box 50 50", "three sizes"},
           {"config.xml --dx 0.5", "for boxes"},
           {"50 50 50 --quiet --verbose --rbc 1", "excludes"},
           {"50 50 50 --sphere 3 --rbc 1", "exclude"},
       }) {
    CAPTURE(row.line);
    CHECK_THROWS_AS(parse(row.line), UsageError);
    CHECK_THROWS_WITH(parse(row.line), Contains(row.message));
  }
}

TEST_CASE("Help and reference list everything", "[command_line]") {
  const std::string help = helpText(false), reference = referenceText();
  for (const Setting& setting : settingsTable()) {
    if (!setting.option.empty()) CHECK_THAT(help, Contains("--" + setting.option));
    if (!setting.tag.empty()) CHECK_THAT(reference, Contains("<" + setting.tag + ">"));
  }
  for (const auto& attribute : speciesAttributes()) CHECK_THAT(reference, Contains(attribute.name));
  CHECK_THAT(help, Contains("Exit codes"));
}

TEST_CASE("Defaults are values that can be stated", "[command_line]") {
  const auto isTruth = [](const std::string& text) {
    return text.empty() || text == "true" || text == "false";
  };
  for (const Setting& setting : settingsTable()) {
    CAPTURE(setting.option, setting.tag, setting.fallback);
    if (!setting.values.empty() && setting.values[0].kind == Kind::boolean) CHECK(isTruth(setting.fallback));
  }
  for (const auto& parameter : catParameters()) {
    CAPTURE(parameter.name, parameter.fallback);
    if (parameter.value.kind == Kind::boolean) CHECK(isTruth(parameter.fallback));
  }
}

TEST_CASE("No two settings share a name", "[command_line]") {
  std::vector<std::string> names;
  for (const Setting& setting : settingsTable()) {
    for (const std::string& name : {"--" + setting.option, "<" + setting.tag}) {
      if (name.size() > 2) {
        CAPTURE(name);
        CHECK(std::find(names.begin(), names.end(), name) == names.end());
        names.push_back(name);
      }
    }
    CHECK((!setting.option.empty() || !setting.tag.empty()));
    CHECK((!setting.values.empty() && (!setting.isFlag() || setting.values.size() == 1)));
    // The values of a tag that has several are words between blanks.
    for (const ValueSpec& value : setting.values)
      CHECK((setting.tag.empty() || setting.values.size() == 1 || value.kind == Kind::axis ||
             value.kind == Kind::plane));
  }
}

TEST_CASE("A packing section can be a word of the command line", "[command_line]") {
  const auto request = [](const std::string& section) {
    return requestToPack(
               parseCommandLine("packMesh", {"20", "20", "20", section, "--seed", "3", "--plt", "5"}).request)
        .request;
  };
  const Request regions = request(
      "<packing><hematocrit>0.1</hematocrit><seed>9</seed><species name='PLT' ratio='0.1' wallClearance='1'/>"
      "<region hematocrit=\"0.2\"><sphere radius=\"3\"/></region></packing>");
  CHECK(regions.regions.size() == 1);
  CHECK(regions.hematocrit == 0.1);
  CHECK(regions.seed == 3);
  CHECK(regions.boxSize == packmesh::Vec3(20, 20, 20));
  REQUIRE(findSpecies(regions, "PLT"));
  CHECK(findSpecies(regions, "PLT")->count == 5);
  CHECK_FALSE(findSpecies(regions, "PLT")->ratio);
  CHECK(findSpecies(regions, "PLT")->wallClearance == 1.0);
  CHECK_THROWS_WITH(request("<packing><hematocrit>0.1</hematocrit><escape>true</escape></packing>"),
                    Contains("argument:1: <escape>: it is for <method> cat"));
  CHECK_THROWS_WITH(request("<packing><sed>1</sed></packing>"), Contains("argument:1: <sed>: unknown tag"));
  CHECK_THROWS_WITH(request("<packings/>"), Contains("argument: expected a section <packing>"));
  CHECK_THROWS_AS(request("<packing>"), packmesh::InputError);
  CHECK_THROWS_AS(parseCommandLine("packMesh", {"<packing/>", "<packing/>", "20", "20", "20"}), UsageError);
  CHECK(parseCommandLine("packMesh", {"<packing><container><sphere radius='5'/></container></packing>"})
            .request.container->lumen->radius == 5);
}

TEST_CASE("The words of a request state the same", "[command_line]") {
  const auto again = [](const Request& request) {
    const std::vector<std::string> words = wordsOf(request);
    CAPTURE(words);
    const Json json = toJson(parseCommandLine(words[0], {words.begin() + 1, words.end()}).request);
    CHECK(json == toJson(request));
    return words;
  };
  using Words = std::vector<std::string>;
  const auto same = [&](const std::string& line) {
    CHECK(again(parse(line).request) == wordsIn("packMesh " + line));
  };
  same("config.xml --hematocrit 0.3 --clearance max --report r.html");
  same("20 30.5 40 --plt 3 --rbc 4 --ends periodic --noRotate --tile 2 1 3 --export csv --export gsd");
  same("--cylinder x 8 20 --discharge-hematocrit 0.2 --fluid-volume --seed 7");
  same("--vessel a.stl 0.5 --open-axis z --rbc 3 --start a.h5 --start b.h5 --walls none");
  same("--sphere 9 --wbc 1 --growth iterations 40 --growth alpha 0.5 --method cat --state=-s.h5");
  CHECK(again(parse("20 20 20 --rbc 4", "packCells").request)[0] == "packCells");
  CHECK(again(parse("config.xml --rbc 1 --cell Egg 3 4 4 4 --orient RBC 1 0 0 5 --plt 2").request) ==
        Words{"packMesh", "config.xml", "--plt", "2",
              "<packing><species name=\"RBC\" count=\"1\" axis=\"1 0 0\" spread=\"5\"/>"
              "<species name=\"Egg\" count=\"3\" ellipsoid=\"4 4 4\"/></packing>"});
  again(parse("config.xml --rbc 1 --stock RBC 2 --start RBC.pos --fixed b.h5 --pre-inlet Xpos --escape "
              "--pre-inlet-range y 0 42 --pre-inlet-slice last-5 --also-dx 0.25 1 "
              "--minimum-distance-from-solid RBC 1")
            .request);
  Request off = parse("config.xml --rbc 1").request;
  off = withJson(off, Json::parse(R"({"escape": false, "rotate": true, "hematocritVolume": "lumen"})"), {});
  CHECK(again(off).at(4) == "--escape=false");
  again(parseCommandLine(
            "packMesh",
            {"9", "9", "9", "--hematocrit", "0.1",
             "<packing><species name='A' ratio='2'/><container><nodes>4 5 6</nodes><obstacles>"
             "<sphere radius='2' center='1 2 3'/><mesh file=\"b'&amp;.stl\"/></obstacles></container>"
             "<region hematocrit='0'><cylinder radius='2' length='3'/></region><region count='3'><beyond "
             "point='1 2 3' direction='1 0 0'/><species name='B' count='4'/></region></packing>"})
            .request);
  again(parseCommandLine("packMesh", {"<packing><container><cylinder radius='2' length='9' center='3 4 5'/>"
                                      "<obstacles><sphere radius='1'/></obstacles></container></packing>"})
            .request);
}
