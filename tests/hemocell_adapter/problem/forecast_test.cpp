// SPDX-License-Identifier: AGPL-3.0-or-later
// What is said before packing, and on the way.
#include "hemocell_adapter/problem/forecast.h"
#include "hemocell_adapter/base/messages.h"

#include <regex>

#include "hemocell_adapter/session/ladder.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/packMesh/write_mesh.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vessels.h"

using namespace packmesh;
using namespace packmesh::hemocell;
using namespace packmesh::test;
namespace fs = std::filesystem;

namespace {

Forecast forecast(const std::vector<std::string>& words) {
  return forecastOf(planned(words));
}

}  // namespace

TEST_CASE("A periodic box is as difficult as its fraction, and walls and clearances increase the difficulty",
          "[forecast]") {
  const Forecast box =
      forecast({"40", "40", "40", "--ends", "periodic", "--hematocrit", "0.4", "--plt_ratio", "0"});
  CHECK(box.cells == 316);
  CHECK(box.fraction == Approx(0.4005).margin(1e-4));
  CHECK(box.effectiveFraction == Approx(box.fraction));
  const Forecast apart = forecast({"40", "40", "40", "--ends", "periodic", "--hematocrit", "0.4",
                                   "--plt_ratio", "0", "--clearance", "0.2"});
  CHECK(apart.effectiveFraction > box.effectiveFraction + 0.04);
  const Forecast walls = forecast(
      {"40", "40", "40", "--ends", "periodic", "--hematocrit", "0.4", "--plt_ratio", "0", "--walls", "xyz"});
  // The layer takes 1 - (1 - 2 · 0.55 / 40)³ = 8.0 % of the box.
  CHECK(walls.effectiveFraction == Approx(box.fraction / 0.92).epsilon(0.01));
  CHECK(walls.seconds > box.seconds);
  double last = 0.0;
  for (const char* h : {"0.1", "0.3", "0.4", "0.5", "0.55", "0.58", "0.6", "0.65"}) {
    const Forecast f =
        forecast({"40", "40", "40", "--ends", "periodic", "--hematocrit", h, "--plt_ratio", "0"});
    if (f.seconds) CHECK(*f.seconds > last);
    CHECK(f.seconds.has_value() == (f.effectiveFraction <= Forecast::possible));
    last = f.seconds.value_or(last);
  }
}

TEST_CASE("With a profile its densest shell decides how difficult a packing is", "[forecast]") {
  const std::vector<std::string> words = {"--cylinder",   "x",    "8",           "31.5", "--ends", "periodic",
                                          "--hematocrit", "0.45", "--plt_ratio", "0.25"};
  std::vector<std::string> developed = words;
  developed.insert(developed.end(), {"--profile", "developed"});
  const Forecast without = forecast(words), with = forecast(developed);
  CHECK(without.effectiveFraction < Forecast::easy);
  CHECK(with.effectiveFraction > Forecast::easy);  // 35 red cells beside a layer of 1.1 µm
  CHECK(with.effectiveFraction <= Forecast::possible);
  CHECK(*with.seconds > *without.seconds);
}

TEST_CASE("The forecast time increases with the number of cells", "[forecast]") {
  const Forecast small = forecast({"40", "40", "40", "--ends", "periodic", "--hematocrit", "0.4"});
  const Forecast large = forecast({"400", "400", "400", "--ends", "periodic", "--hematocrit", "0.4"});
  CHECK(*large.seconds > 1000.0 * *small.seconds);
  CHECK(*large.seconds < 2000.0 * *small.seconds);
  CHECK(large.megabytes > 400.0);
}

TEST_CASE("A dry run reports whether the request is feasible", "[forecast]") {
  const auto said = [](const std::vector<std::string>& words, int ranks = 1) {
    std::string all;
    for (const std::string& line : forecastText(planned(words), ranks).lines) all += line + "\n";
    return inTermsOfUser(all);
  };
  CHECK_THAT(said({"50", "50", "50", "--ends", "periodic", "--hematocrit", "0.45"}),
             Contains("Feasible: effective fraction 0.451; slow above 0.60"));
  CHECK_THAT(said({"50", "50", "50", "--ends", "periodic", "--hematocrit", "0.605"}),
             Contains("At the limit"));
  CHECK_THAT(said({"50", "50", "50", "--ends", "periodic", "--hematocrit", "0.65"}),
             Contains("Probably infeasible: 0.03"));
  for (const char* fraction : {"0.605", "0.65"}) {
    const auto ofBox = [&](const std::vector<std::string>& more) {
      std::vector<std::string> words = {"50", "50", "50", "--ends", "periodic", "--hematocrit", fraction};
      words.insert(words.end(), more.begin(), more.end());
      return said(words);
    };
    CHECK_THAT(ofBox({}), Contains("--order columns"));
    std::vector<std::vector<std::string>> others = {{"--order", "columns"}, {"--walls", "z"}, {"--noRotate"}};
    if (hasCat()) others.push_back({"--method", "cat"});
    for (const std::vector<std::string>& more : others) CHECK_THAT(ofBox(more), !Contains("--order columns"));
  }
  CHECK_THAT(said({"500", "500", "500", "--ends", "periodic", "--hematocrit", "0.45"}, 8),
             Contains("on 8 ranks"));
  if (hasCat())
    CHECK_THAT(said({"50", "50", "50", "--ends", "periodic", "--hematocrit", "0.3", "--method", "cat"}),
               Contains("unknown"));
}

TEST_CASE("A forecast accounts for the volume lost to clearances, layers and HemoCell", "[forecast]") {
  const std::vector<std::string> pipe = {"--cylinder", "x",        "12.5",        "50",
                                         "--ends",     "periodic", "--hematocrit"};
  const auto inPipe = [&](const char* hematocrit, const std::vector<std::string>& more) {
    std::vector<std::string> words = pipe;
    words.emplace_back(hematocrit);
    words.insert(words.end(), more.begin(), more.end());
    return planned(words);
  };
  const auto said = [](const Problem& problem) {
    std::string all;
    for (const std::string& line : forecastText(problem, 1).lines) all += line + "\n";
    return all;
  };
  const Problem layered = inPipe("0.3", {"--cell-free-layer", "2"});
  const Forecast f = forecastOf(layered);
  REQUIRE(f.roomShares.size() == 2);
  CHECK(f.roomShares[0] == Approx(10.5 * 10.5 / (12.5 * 12.5)).margin(0.01));
  CHECK(f.roomShares[1] == 1.0);
  // Red cells in their core less 0.55 µm, platelets in all of the pipe less that.
  CHECK(f.effectiveFraction == Approx(0.3 * 12.5 * 12.5 / (9.95 * 9.95) + 0.001).margin(0.01));
  CHECK_THAT(said(layered),
             Contains("RBC can reach 7") && !Contains("PLT can reach") && Contains("Feasible"));
  CHECK_THAT(said(inPipe("0.05", {"--cell-free-layer", "12"})),
             Contains("Infeasible: 15 RBC have 1217 µm³, more than the available volume"));
  CHECK_THAT(said(inPipe("0.004", {"--cell-free-layer", "10"})),
             Contains("Infeasible: not even one RBC fits") && Contains("Time: unknown"));
  CHECK_THAT(said(inPipe("0.004", {"--cell-free-layer", "8.3"})), Contains("Feasible"));
  CHECK_THAT(said(inPipe("0.4", {"--wall-clearance", "3"})), Contains("Probably infeasible: "));
}

TEST_CASE("What walls or images order is uncertain, and few cells may be denser", "[forecast]") {
  const auto said = [](std::vector<std::string> words) {
    if (words.front() != "--sphere") words.insert(words.end(), {"--ends", "periodic"});
    std::string all;
    for (const std::string& line : forecastText(planned(words), 1).lines) all += line + "\n";
    return all;
  };
  // Tubes of this width were packed to 0.49 with one seed, to 0.55 with another.
  CHECK_THAT(said({"--cylinder", "x", "4.3", "60", "--hematocrit", "0.55"}),
             Contains("Uncertain: effective fraction 0.73") && !Contains("nfeasible"));
  CHECK_THAT(said({"--cylinder", "x", "4.3", "60", "--hematocrit", "0.3"}), Contains("Feasible"));
  CHECK_THAT(said({"--sphere", "8", "--hematocrit", "0.5"}), Contains("At the limit: between 0.60 and 0.72"));
  CHECK_THAT(said({"--cylinder", "x", "25", "40", "--hematocrit", "0.62"}), Contains("Probably infeasible"));
  // Wider than the box, along two axes.
  CHECK_THAT(said({"30", "4", "4", "--rbc", "1"}), Contains("Infeasible: not even one RBC fits"));
  CHECK_THAT(said({"30", "30", "4", "--rbc", "10"}), Contains("Feasible"));
}

TEST_CASE("A forecast accounts for places that no cell can enter", "[forecast]") {
  const TemporaryFolder folder;
  const std::string file = (folder / "chambers.stl").string();
  writeMesh(file, twoChambers()->surface());
  const auto said = [&](const char* red) {
    std::string all;
    for (const std::string& line : forecastText(planned({"--vessel", file, "1", "--rbc", red}), 1).lines)
      all += line + "\n";
    return all;
  };
  CHECK_THAT(said("6"), Contains("Feasible") && Contains("RBC: the places that they can reach are 2 parts, "
                                                         "not connected, the largest with 0.5"));
  CHECK_THAT(said("20"), Contains("nfeasible"));
}

TEST_CASE("A forecast accounts for the volume that HemoCell excludes near solid nodes", "[executable]") {
  const SampleCase folder;
  CHECK_THAT(run(folder, "config.xml --hematocrit 0.3 --dry-run").out, Contains("Feasible"));
  const Ran far = run(folder, "config.xml --hematocrit 0.3 --minimum-distance-from-solid RBC 2 --dry-run");
  INFO(far.all());
  CHECK_THAT(far.out, Contains("RBC can reach ") && Contains("Probably infeasible"));
}

TEST_CASE("A forecast accounts for the continuation of the ends of a vessel", "[executable]") {
  const SampleCase folder;
  // The lattice is longer than the STL by three nodes of 0.5 µm, in which there are cells as well.
  constexpr double length = 24.0, continuation = 1.5;
  const Problem problem = planned({(folder / "config.xml").string(), "--hematocrit", "0.3", "--plt_ratio",
                                   "0", "--wall-clearance", "0", "--clearance", "0"});
  const double stl = problem.lumen.container->volume();
  REQUIRE(problem.lumen.container->bounds().size().x() == Approx(length + continuation));
  const Forecast f = forecastOf(problem);
  const double share = f.roomShares.at(0);
  CHECK(f.roomVolumes.at(0) == Approx(share * stl * (length + continuation) / length).epsilon(0.01));
  CHECK(f.fraction * stl < f.effectiveFraction * f.roomVolumes[0]);
  // What is printed is of the lumen without them: share, volumes and hematocrit belong together.
  const Problem layered = planned({(folder / "config.xml").string(), "--hematocrit", "0.1", "--plt_ratio",
                                   "0", "--cell-free-layer", "2"});
  LumenSample sample(layered);
  const std::string said = reachLines(layered, sample).front();
  INFO(said);
  std::smatch found;
  REQUIRE(std::regex_search(
      said, found,
      std::regex(
          "RBC can reach (.*) % of the lumen \\((.*) of (.*) µm³\\), where their hematocrit is (0.*);")));
  const double percent = std::stod(found[1]), reached = std::stod(found[2]), red = layered.species[0].count;
  CHECK(std::stod(found[3]) == Approx(stl).margin(0.5));
  CHECK(reached == Approx(0.01 * percent * stl).epsilon(0.001));
  CHECK(std::stod(found[4]) == Approx(red * layered.species[0].meanVolume / reached).epsilon(0.005));
  LumenSample all(problem);
  CHECK_THAT(reachLines(problem, all).front(), !Contains("can reach"));  // nearly all of it
}

TEST_CASE("A forecast gives no time for infeasible requests and rejects those beyond any known packing",
          "[forecast]") {
  const Problem problem = planned({"30", "30", "30", "--ends", "periodic", "--hematocrit", "0.95",
                                   "--best-effort", "--max-time", "5400"});
  LumenSample sample(problem);
  ProgressLog log(problem, sample);
  CHECK_THAT(log.text({"relaxation", 12, 1.0, 0.25, 345}, 125.0),
             Contains("; 2 min 5 s of 90 min at most") && !Contains("left"));
  CHECK_THROWS_WITH(planned({"30", "30", "30", "--ends", "periodic", "--hematocrit", "0.78"}),
                    Contains("requested cells 'RBC' fill 0.78") && Contains("beyond 0.7707 is known") &&
                        Contains(named("best-effort")));
  CHECK_NOTHROW(planned({"30", "30", "30", "--ends", "periodic", "--hematocrit", "0.765"}));
  CHECK_THROWS_WITH(planned({"30", "30", "30", "--cell", "ball", "800", "4", "4", "4"}),
                    Contains("requested cells 'ball' fill 0.9"));
  // A few cells can fill a lumen that is made for them.
  CHECK_NOTHROW(planned({"9", "9", "3", "--walls", "xyz", "--cell", "plate", "1", "8.3", "8.3", "2.4"}));
}

TEST_CASE("The progress line shows stage, hematocrit, overlap and remaining time", "[forecast]") {
  Problem problem =
      planned({"200", "200", "200", "--ends", "periodic", "--hematocrit", "0.55", "--max-time", "90"});
  LumenSample sample(problem);
  ProgressLog log(problem, sample);
  const std::string relaxing = log.text({"relaxation", 12, 1.0, 0.25, 345}, 2.0);
  CHECK_THAT(relaxing,
             Contains("relaxation: sweep 12, hematocrit 0.550, 345 contacts, deepest by 0.2500 µm; 2 s of "
                      "90 s at most, about "));
  CHECK_THAT(log.text({"relaxation", 12, 1.0, 0.25, 345}, 1e6), !Contains("left"));
  problem.request.method = Method::cat;
  CHECK_THAT(
      ProgressLog(problem, sample).text({"growth", 3, 0.5, 0.0, 7}, 2.0),
      Contains("growth: iteration 3, hematocrit 0.069 at scale 0.50, 7 cells below it; 2 s of 90 s at most"));
}

TEST_CASE("A dry run of what no method can pack has the exit code of what cannot be packed", "[executable]") {
  const TemporaryFolder folder;
  const std::string none = "--cylinder x 12.5 50 --hematocrit 0.004 --cell-free-layer 10";
  CHECK_THAT(ended(folder, 3, none + " --dry-run").out, Contains("Infeasible: not even one RBC fits"));
  ended(folder, 3, none + " --max-iterations 50");
  CHECK_THAT(ended(folder, 3, "30 30 30 --ends periodic --hematocrit 0.8 --dry-run").err,
             Contains("beyond 0.7707 is known"));
  CHECK(run(folder, "30 30 30 --ends periodic --hematocrit 0.8 --dry-run --best-effort").exitCode == 0);
}

TEST_CASE("Soft cells are forecast where undeformed ones cannot be packed", "[executable]") {
  const TemporaryFolder folder;
  const std::string dense = "30 30 30 --ends periodic --hematocrit 0.8 --soft --threads 1 --dry-run";
  Ran ran = ok(folder, dense);
  CHECK_THAT(ran.out, Contains("cells will be soft") &&
                          Contains("Time: 3 s to 29 s of CPU; soft cells usually take 0.01 to 0.1 s each") &&
                          Contains("Memory: about 63 MB for each rank"));
  ran = run(folder, dense + " --rigid RBC");  // platelets alone deform
  CHECK_THAT(ran.out, !Contains("Memory: about 63 MB"));
  ran = run(folder, dense + " --tile 2 1 1");
  CHECK_THAT(ran.out, Contains("Then repeated 2 x 1 x 1 times: 570 cells, about 101 MB in all"));
  ran = run(folder, "30 30 30 --ends periodic --hematocrit 0.3 --soft --dry-run");
  CHECK_THAT(ran.out, Contains("Feasible") && Contains("Memory: about 25 MB for each rank"));
  // On the threads that are given, and in units that can be read.
  ran = run(folder, "150 150 150 --ends periodic --hematocrit 0.8 --soft --threads 64 --dry-run");
  CHECK_THAT(ran.out, Contains("s of CPU, 7 s to ") && Contains(" on 64 threads; soft cells") &&
                          Contains("Memory: about 4.76 GB for each rank"));
  ran = run(folder, "150 150 150 --ends periodic --hematocrit 0.45 --threads 4 --dry-run");
  CHECK_THAT(ran.out, Contains("Time: about 2 s of CPU, less than a second on 4 threads, on a core at"));
}

TEST_CASE("A dry run and a validation write no files", "[executable]") {
  const SampleCase folder;
  Ran ran = ok(folder, "config.xml --hematocrit 0.3 --dry-run");
  CHECK_THAT(ran.out, Contains("Lumen volume") && Contains("Feasible") && Contains("Memory: about") &&
                          Contains("nothing was packed or written") &&
                          !Contains("Not included in these figures"));
  fs::create_directory(folder / "there");
  writeText(folder / "there/RBC.pos", "1\n6 8 8 0 0 0\n");
  ran =
      run(folder, "config.xml --rbc 5 --fixed there/RBC.pos --orient RBC 1 0 0 30 --dry-run --report r.json");
  INFO(ran.all());
  CHECK_THAT(
      ran.out,
      Contains("Not included in these figures: 1 fixed cell, constrained orientations; packing then "));
  CHECK_FALSE(fs::exists(folder / "r.json"));
  ran = ok(folder, "config.xml --hematocrit 0.3 --validate");
  CHECK_THAT(ran.out, Contains("config.xml is valid"));
  for (const auto& entry : fs::directory_iterator(folder.path())) CHECK(entry.path().extension() != ".pos");
}

TEST_CASE("The manual page and the completion contain every option", "[executable]") {
  const std::string man = manText(), completion = completionText();
  CHECK_THAT(man, Contains(".TH PACKMESH 1") && Contains(".SH EXIT STATUS"));
  for (const char* option : {"hematocrit", "fixed", "dry\\-run", "checkpoint\\-every"})
    CHECK_THAT(man, Contains(std::string("\\-\\-") + option));
  const TemporaryFolder folder;
  writeText(folder / "completion", completion);
  writeText(folder / "config.xml", "");
  writeText(folder / "other.txt", "");
  const auto completed = [&](const std::string& words, int position) {
    const std::string out = (folder / "out").string();
    const std::string script = "cd '" + folder.path().string() + "' && . ./completion && COMP_WORDS=(" +
                               words + ") && COMP_CWORD=" + std::to_string(position) +
                               " && { _packMesh || true; } && echo \"${COMPREPLY[@]}\" > '" + out + "'";
    writeText(folder / "script", script);
    CHECK(std::system(("bash '" + (folder / "script").string() + "'").c_str()) == 0);
    return readText(out);
  };
  CHECK(completed("packMesh --hema", 1) == "--hematocrit\n");
  CHECK(completed("packMesh --dry", 1) == "--dry-run\n");
  CHECK(completed("packMesh check --dry", 2) == "\n");
  CHECK(completed("packMesh check --hema", 2) == "--hematocrit\n");
  CHECK(completed("packMesh --print", 1) == "--print-config-reference\n");
  CHECK(completed("packMesh --method c", 2) == "cat\n");
  CHECK(completed("packMesh c", 1) == "config.xml check\n");
  CHECK(completed("packMesh x.xml --open-axis ''", 3) == "x y z\n");
}

TEST_CASE("A dry run reports realisations and repetition, and no time without an end", "[executable]") {
  const TemporaryFolder folder;
  const Ran ran = ok(folder, "16 16 16 --ends periodic --rbc 5 --tile 2 3 4 --realisations 7 --dry-run");
  CHECK_THAT(ran.out, Contains("2 x 3 x 4 times: 120 cells"));
  CHECK_THAT(ran.out, Contains("7 realisations"));
  CHECK_THAT(ok(folder, "16 16 16 --hematocrit 0.7 --dry-run").out, Contains("Time: unknown"));
}
