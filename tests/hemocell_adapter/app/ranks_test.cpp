// SPDX-License-Identifier: AGPL-3.0-or-later
// The executable under mpirun, as batch jobs start it.
#include "hemocell_adapter/base/ranks.h"

#include <fmt/format.h>

#include <set>

#include "hemocell_adapter/settings/request.h"
#include "tests/hemocell_adapter/executable.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh::test;
using packmesh::hemocell::hasCat;
namespace fs = std::filesystem;

namespace {

std::set<fs::path> filesIn(const fs::path& folder) {
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.insert(fs::relative(entry.path(), folder));
  return files;
}

/// What a file says, but for the times of a report, with the number of ranks beside them.
std::string withoutTimes(const fs::path& file) {
  std::string text = readText(file);
  const auto drop = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    if (at != text.npos) text.erase(at, text.find(to, at) - at);
  };
  if (file.extension() == ".json") drop("\n \"times\"", "}");
  if (file.extension() == ".html") drop("\"times\":{\"ranks\"", "}");
  return text;
}

/// All that a run wrote beside the files that were there.
std::string filesOf(const fs::path& folder, const std::set<fs::path>& before) {
  std::string text;
  for (const fs::path& file : filesIn(folder))
    if (before.count(file) == 0) text += file.string() + "\n" + withoutTimes(folder / file);
  return text;
}

/// What is said of the packing, without times, progress and the number of ranks.
std::string storyOf(const std::string& out) {
  std::istringstream lines(out);
  std::string story, line;
  while (std::getline(lines, line))
    if (line.find("Time:") == line.npos && line.find("(packMesh) packMesh") == line.npos &&
        line.find("Note:") == line.npos && line.find(": sweep ") == line.npos &&
        line.find(": iteration ") == line.npos)
      story += line + '\n';
  return story;
}

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

struct Team {
  int ranks, threads;  ///< threads of each rank
};

/// Alone, and several ranks of several threads; teams differ in whether they divide blocks evenly. Those of
/// many ranks take long to start, so that few tests have them.
const std::vector<Team> someTeams = {{1, 1}, {3, 2}};
const std::vector<Team> manyTeams = {{1, 1}, {1, 3}, {2, 1}, {4, 1}, {7, 1}};

/// Without mpirun where it is a rank alone.
std::string started(const Team& team) {
  return "OMP_NUM_THREADS=" + std::to_string(team.threads) +
         (team.ranks > 1 ? " " + onRanks(team.ranks) : "");
}

/// Packs in a folder of its own on every number of ranks and threads.
void requireSameOnRanks(const std::string& arguments, const std::vector<Team>& teams = someTeams) {
  CAPTURE(arguments);
  std::string files, story;
  for (const Team& team : teams) {
    CAPTURE(team.ranks, team.threads);
    const SampleCase folder;
    const std::set<fs::path> before = filesIn(folder.path());
    const Ran ran = withExit(0, runProcess(folder, arguments, started(team)));
    if (files.empty()) {
      files = filesOf(folder.path(), before);
      story = storyOf(ran.out);
      REQUIRE(files.size() > 1000);
      continue;
    }
    CHECK((filesOf(folder.path(), before) == files));  // too long to print
    CHECK(storyOf(ran.out) == story);
    CHECK_THAT(ran.out, Contains(std::to_string(team.ranks) + (team.ranks > 1 ? " ranks" : " rank")));
    if (team.threads > 1) CHECK_THAT(ran.out, Contains("with " + std::to_string(team.threads) + " threads"));
  }
}

/// A .pos text with all positions multiplied, and every tenth cell moved towards the one before.
std::string moved(const std::string& text, double factor, double share) {
  std::istringstream in(text);
  std::ostringstream out;
  std::string count, angles;
  std::getline(in, count);
  out.precision(17);
  out << count << '\n';
  double p[3], last[3] = {0, 0, 0};
  for (int i = 0; in >> p[0] >> p[1] >> p[2] && std::getline(in, angles); ++i) {
    for (int k = 0; k < 3; ++k) {
      out << (k ? " " : "") << factor * (i % 10 == 9 ? p[k] + share * (last[k] - p[k]) : p[k]);
      last[k] = p[k];
    }
    out << angles << '\n';
  }
  return out.str();
}

/// The lines of packMesh in a text.
std::string own(const std::string& text) {
  std::istringstream lines(text);
  std::string kept, line;
  while (std::getline(lines, line))
    if (line.rfind("(packMesh)", 0) == 0) kept += line + '\n';
  return kept;
}

/// Checks on every number of ranks and threads.
void requireSameCheck(const TemporaryFolder& folder, const std::string& arguments, int exitCode,
                      const std::string& words, const std::vector<Team>& teams = someTeams) {
  CAPTURE(arguments);
  const std::set<fs::path> before = filesIn(folder.path());
  std::string files, story;
  for (const Team& team : teams) {
    CAPTURE(team.ranks, team.threads);
    const Ran ran = withExit(exitCode, runProcess(folder, arguments, started(team)));
    const std::string written = filesOf(folder.path(), before), said = storyOf(ran.out) + own(ran.err);
    for (const fs::path& file : filesIn(folder.path()))
      if (before.count(file) == 0) fs::remove(folder / file);
    if (story.empty()) {
      files = written;
      story = said;
      REQUIRE_THAT(story, Contains(words));
      continue;
    }
    CHECK((written == files));  // too long to print
    CHECK(said == story);
  }
}

}  // namespace

TEST_CASE("Packings have the same files and messages on any ranks", "[ranks]") {
  requireSameOnRanks("config.xml --hematocrit 0.5 --max-iterations 10 --best-effort");
  requireSameOnRanks("10 10 10 --ends periodic --hematocrit 0.73 --soft --state s.h5", {{1, 1}, {2, 2}});
  requireSameOnRanks(
      "60 60 60 --ends periodic --hematocrit 0.6 --plt_ratio 0.02 --order columns --state state.h5 "
      "--best-effort --max-iterations 40");
  if (!hasCat()) return;
  requireSameOnRanks("18 18 18 --hematocrit 0.25 --method cat --state state.h5");
  requireSameOnRanks("config.xml --rbc 2 --method cat --builder cat-faces --state state.h5");
}

TEST_CASE("All kinds of packings have the same files and messages on any ranks", "[ranks][long]") {
  const std::string outputs =
      " --report report.html --vtp --vtp-meshes --pov --state state.h5 --export csv --export "
      "lammps-molecular --export mirheo --export stl";
  requireSameOnRanks("config.xml --hematocrit 0.3 --plt_ratio 0.1" + outputs, {{1, 1}, {1, 3}, {2, 1}});
  for (const char* packing :
       {"60 60 60 --hematocrit 0.3 --plt_ratio 0.05 --seed 5", "80 30 30 --hematocrit 0.3 --state state.h5",
        "25 25 25 --ends periodic --hematocrit 0.3 --plt_ratio 0.1 --tile 2 2 2 --export csv --export "
        "lammps-molecular --export mirheo --export stl",
        "config.xml --hematocrit 0.25 --cell-free-layer 1 --orient RBC 1 0 0 40 --export csv --state "
        "state.h5",
        "config.xml --hematocrit 0.25 --plt_ratio 0.3 --profile developed --state state.h5",
        "--cylinder x 14 60 --ends periodic --discharge-hematocrit 0.4 --profile developed",
        "config.xml --hematocrit 0.25 --plt_ratio 0.3 --also-dx 0.25 1"})
    requireSameOnRanks(packing);
  requireSameOnRanks("--cylinder z 10 80 --hematocrit 0.35 --state state.h5", manyTeams);
  requireSameOnRanks("10 10 10 --ends periodic --hematocrit 0.73 --soft --state s.h5", {{1, 1}, {4, 1}});
  requireSameOnRanks(
      "'<packing><container><box size=\"40 20 12\"/><obstacles><box origin=\"15 9 -1\" size=\"26 2 14\"/>"
      "</obstacles></container><species name=\"RBC\"/><hematocrit>0.2</hematocrit><region count=\"9\">"
      "<beyond point=\"18 15 5\" direction=\"3 1 0\"/><species name=\"PLT\" "
      "count=\"20\"/></region></packing>'",
      {{1, 1}, {2, 1}, {4, 1}});
  if (!hasCat()) return;
  requireSameOnRanks("16 16 16 --rbc 12 --plt 4 --method cat" + outputs);
  requireSameOnRanks(
      "--sphere 5.5 --rbc 4 --plt 3 --method cat --escape --best-effort --state state.h5 --growth iterations "
      "12 --growth attempts 1");
}

TEST_CASE("An error is reported once, ends all ranks and leaves no files", "[ranks][long]") {
  struct Fault {
    const char* arguments;
    int exitCode;
    const char* message;
  };
  for (const Fault& fault :
       {Fault{"config.xml --hematocrit 1.5", 1, "hematocrit"},
        Fault{"missing.xml --hematocrit 0.3", 2, "missing.xml"},
        Fault{"config.xml --hematocrit 0.7 --max-iterations 20", 3, "not feasible within the limits"},
        Fault{"config.xml --hematocrit 0.1 --output-dir RBC.xml", 5, "RBC.xml"}}) {
    CAPTURE(fault.arguments);
    const SampleCase folder;
    const std::set<fs::path> before = filesIn(folder.path());
    const Ran ran = withExit(fault.exitCode, runProcess(folder, fault.arguments, onRanks(3)));
    CHECK_THAT(ran.err, Contains(fault.message));
    CHECK(count(ran.err, "(Error)") == 1);
    CHECK(filesOf(folder.path(), before).empty());
  }
}

TEST_CASE("A rank that finds different files than the first rank ends all ranks", "[ranks][long]") {
  const SampleCase folder;
  fs::create_directory(folder / "other");
  for (const auto& entry : fs::directory_iterator(folder.path()))
    if (entry.is_regular_file()) fs::copy(entry.path(), folder / "other");
  writeText(folder / "elsewhere", "[ \"$OMPI_COMM_WORLD_RANK\" = 1 ] && cd other\nexec \"$@\"\n");
  const std::string prefix = onRanks(3) + " bash '" + (folder / "elsewhere").string() + "'";
  const std::string arguments = "config.xml --hematocrit 0.2 --output-dir .";
  withExit(0, runProcess(folder, arguments, prefix));
  fs::remove(folder / "RBC.pos");
  writeText(folder / "other/tube.stl", tubeStl(2.6, 0.75, 48));
  const Ran other = withExit(2, runProcess(folder, arguments, prefix));
  REQUIRE_THAT(other.err, Contains("rank 1 has a different problem than rank 0"));
  REQUIRE(count(other.err, "(Error)") == 1);
  REQUIRE_FALSE(fs::exists(folder / "RBC.pos"));
}

TEST_CASE("Ranks without a block are idle, and this is reported", "[ranks]") {
  const SampleCase folder;
  CHECK_THAT(withExit(0, runProcess(folder, "30 30 30 --hematocrit 0.2", onRanks(4))).out,
             Contains("1 block of cells for 4 ranks; 3 had nothing to do"));
}

TEST_CASE("check says and writes the same on any ranks", "[ranks][long]") {
  const SampleCase folder;
  ok(folder, "config.xml --hematocrit 0.3 --plt_ratio 0.1 --state state.h5");
  const std::string outputs =
      " --report report.html --vtp --vtp-meshes --pov --export csv --export lammps-molecular --export stl";
  requireSameCheck(folder, "check config.xml" + outputs, 0, "Verdict: clean", manyTeams);
  requireSameCheck(folder, "check config.xml --start state.h5 --report report.json", 0, "Verdict: clean");
  requireSameCheck(folder,
                   "check config.xml --verbose --clearance 0.2 --wall-clearance 0.5 --report report.json", 4,
                   "nearer than 0.2");
  const std::string cells = readText(folder / "RBC.pos");
  writeText(folder / "RBC.pos", moved(cells, 1.0, 0.7));
  const std::string some = " --report report.json --vtp --export csv";
  requireSameCheck(folder, "check config.xml --verbose" + some, 4, "the meshes meet");
  writeText(folder / "RBC.pos", moved(cells, 1.3, 0.0));
  requireSameCheck(folder, "check config.xml --verbose" + some, 4, "Cells not wholly inside the lumen");
  writeText(folder / "RBC.pos", moved(cells, 1e-6, 0.0));
  requireSameCheck(folder, "check config.xml", 4, "perhaps they are in metres");
}

TEST_CASE("check of periodic boxes says the same on any ranks", "[ranks][long]") {
  const TemporaryFolder folder;
  const std::string box = " --box 60 30 30 --ends periodic";
  ok(folder, "60 30 30 --ends periodic --hematocrit 0.3");
  requireSameCheck(folder, "check" + box + " --report report.json --vtp --export csv", 0, "Verdict: clean");
  const std::string cells = readText(folder / "RBC.pos");
  writeText(folder / "RBC.pos", moved(cells, 1.0, 0.9));
  requireSameCheck(folder, "check" + box + " --verbose --report report.json", 4, "(periodic image)");
  writeText(folder / "RBC.pos", "2\n1 2 3 0 0 0\n59.5 2 3 0 90 0\n");  // fewer cells than ranks
  requireSameCheck(folder, "check" + box + " --report report.json --export csv", 4, "Overlapping pairs: 1");
  writeText(folder / "RBC.pos", "0\n");
  requireSameCheck(folder, "check" + box, 0, "Verdict: clean");
}

TEST_CASE("check of cells that all overlap ends the search at the same cell on any ranks", "[ranks][long]") {
  const TemporaryFolder folder;
  std::string heap = "700\n", heaps = "1400\n";
  for (int i = 0; i < 700; ++i) {
    const std::string line = std::to_string(0.003 * (i % 9)) + " 0.01 0 0 " + std::to_string(i) + " 0\n";
    heap += "30 " + line.substr(line.find(' ') + 1);
    heaps += "10" + line.substr(1) + "50" + line.substr(1);
  }
  writeText(folder / "RBC.pos", heap);
  requireSameCheck(folder, "check --box 60 60 60 --verbose", 4, "Overlapping pairs: at least");
  writeText(folder / "RBC.pos", heaps);  // on different ranks
  requireSameCheck(folder, "check --box 60 60 60 --verbose", 4, "Overlapping pairs: at least");
  std::string late = "900\n";  // cells that overlap nothing come first
  for (int i = 0; i < 200; ++i)
    late += fmt::format("{} {} {} 0 0 0\n", 9 * (i % 6) + 5, 9 * (i / 6 % 6) + 5, 9 * (i / 36) + 5);
  late += heap.substr(heap.find('\n') + 1);
  writeText(folder / "RBC.pos", late);
  requireSameCheck(folder, "check --box 60 60 60 --verbose", 4, "Overlapping pairs: at least");
}

TEST_CASE("check refuses files with the same words on any ranks", "[ranks][long]") {
  const TemporaryFolder folder;
  std::string lines;
  for (int i = 0; i < 20; ++i)
    lines += std::to_string(5 + 10 * (i % 5)) + " " + std::to_string(5 + 10 * (i / 5)) + " 9 0 0 0\n";
  const auto refused = [&](const std::string& text, const std::string& words) {
    writeText(folder / "RBC.pos", text);
    requireSameCheck(folder, "check --box 60 60 60", 2, words);
  };
  refused("", "RBC.pos:1: the file is empty");
  refused("30\n" + lines, "announces 30 cells, but 20 follow");
  refused("40\n" + lines + "1 2 3 4 5\n" + lines + "1 2 3 4 5 nan\n", "RBC.pos:22: 5 fields");
  refused("21\n" + lines + "1 2 3 4 5 nan\n", "RBC.pos:22: field 6");
  writeText(folder / "RBC.pos", "20\r\n\n" + lines + "1 2 3 4 5 nan\n");
  requireSameCheck(folder, "check --box 60 60 60", 0, "a blank line between cells");
}

TEST_CASE("check of realisations says the same on any ranks", "[ranks][long]") {
  const TemporaryFolder folder;
  ok(folder, "30 30 30 --hematocrit 0.2 --realisations 3");
  requireSameCheck(folder, "check --box 30 30 30", 0, "Verdict: 3 of 3 folders clean");
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(folder.path()))
    if (entry.is_directory()) folders.push_back(entry.path());
  REQUIRE(folders.size() == 3);
  writeText(folders[0] / "RBC.pos", "2\n5 6 7 0 0 0\n5 6 7 0 0 0\n");
  writeText(folders[1] / "RBC.pos", "2\n5 6 7 0 0 0\n");
  requireSameCheck(folder, "check --box 30 30 30", 4, "Verdict: 1 of 3 folders clean");
}

TEST_CASE("An error found by all ranks is reported once", "[ranks]") {
  const TemporaryFolder folder;
  const Ran ran = withExit(2, runProcess(folder, "50 50 50 --rbc 60 --clearance 20", onRanks(3)));
  CHECK(count(ran.err, "(packMesh) (Error) ") == 1);
  CHECK_THAT(ran.err, Contains("60 cells 20 µm apart need a lumen larger than"));
  CHECK_THAT(ran.err, !Contains("MPI_ABORT"));
}
