// SPDX-License-Identifier: AGPL-3.0-or-later
// Names, paths and files that nobody would give on purpose: each is refused in words that tell which, at
// once.
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <functional>
#include <regex>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/io/sealed_file.h"
#include "tests/hemocell_adapter/refusal.h"
#include "tests/support/catch.h"
#include "tests/support/places.h"

using namespace packmesh;
using namespace packmesh::test;
using packmesh::hemocell::parseCommandLine;
using packmesh::hemocell::UsageError;
namespace fs = std::filesystem;

namespace {

std::string caseOf(const std::string& packing) {
  return "<hemocell><domain><dx>5e-7</dx><refDirN>60</refDirN></domain><packing><walls>none</walls>" +
         packing + "</packing></hemocell>";
}

std::string ellipsoids(int count) {
  std::string species;
  for (int i = 0; i < count; ++i)
    species += fmt::format("<species name=\"c{}\" count=\"1\" ellipsoid=\"1 .5 1\"/>\n", i);
  return species;
}

}  // namespace

TEST_CASE("Cell names that no file or table can hold are rejected", "[executable]") {
  const std::string box = "20 20 20 --cell ", ellipsoid = " 1 2 2 2",
                    expected = "expected a cell name of at most 100 bytes";
  std::vector<RefusedRow> rows = {
      {box + std::string(252, 'x') + ellipsoid, 1, expected},
      {box + std::string(101, 'x') + ellipsoid, 1, expected},
      {"20 20 20 --fixed a,b.pos", 2, "a,b.pos: the name before .pos is the name of the cells; " + expected},
  };
  for (const char* name : {"a,b",
                           "a\x01"
                           "b",
                           "a\xff"
                           "b",
                           "\"a", "a\x7f", "a\xc2\x9b", "=1+1", "@a", "\u202ea", "\ufeffa", "a#b"}) {
    rows.push_back({box + "'" + name + "'" + ellipsoid, 1, expected});
    rows.push_back({"config.xml", 2, "config.xml:1: ", [name](const fs::path& folder) {
                      const std::string quoted =
                          fmt::format("<species name='{}' count='1' ellipsoid='1 1 1'/>", name);
                      writeText(folder / "config.xml", caseOf(quoted));
                    }});
  }
  requireRefused(rows);
  const TemporaryFolder folder;
  ok(folder, box + std::string(100, 'x') + ellipsoid + " --vtp --export csv --state s.h5");
  ok(folder, "20 20 20 --cell 'sphère-2(b)'" + ellipsoid + " --export csv");
}

TEST_CASE("Names that a folder or a state gives to cells are not exported as formulas or written elsewhere",
          "[executable]") {
  const SampleCase folder;
  writeText(folder / "RBC#1.xml", readText(folder / "RBC.xml"));
  writeText(folder / "RBC#1.pos", "1\n30 20 20 0 0 0\n");
  requireRefused(folder,
                 {{"check config.xml --export csv", 2, "misread the name 'RBC#1'; expected a cell name"}});

  const TemporaryFolder inner;
  ok(inner, "20 20 20 --cell 12345678 3 2 2 2 --state s.h5");
  std::string state = readText(inner / "s.h5");
  std::size_t found = 0;
  for (std::size_t at = 0; (at = state.find("12345678", at)) != std::string::npos; ++found)
    state.replace(at, 8, "../../ev");
  REQUIRE(found > 0);
  writeText(inner / "s.h5", state);
  // Sealed again, as whoever changes it on purpose would.
  std::smatch head;
  REQUIRE(std::regex_search(state, head, std::regex("packMesh (\\w+), version (\\d+)\nwritten by (.*)\n")));
  REQUIRE(seal(inner / "s.h5", {head[1], std::stoll(head[2]), head[3]}).empty());
  const std::string named = "s.h5: contains cells named '../../ev'; expected a cell name";
  requireRefused(inner, {{"20 20 20 --start s.h5", 2, named},
                         {"20 20 20 --rbc 1 --fixed s.h5", 2, named},
                         {"check --box 20 20 20 --start s.h5", 2, named}});
}

TEST_CASE("Invalid paths are reported as errors of the user", "[executable]") {
  const std::string longName(300, 'n'), pack = "20 20 20 --rbc 1 ";
  std::string longPath;
  while (longPath.size() < 5000) longPath += std::string(200, 'p') + '/';
  const auto loop = [](const std::string& name) {
    return [=](const fs::path& folder) { fs::create_symlink(name, folder / name); };
  };
  requireRefused({
      {longName + ".xml --rbc 1", 2, ".xml: cannot be read: File name too long"},
      {longPath + "config.xml --rbc 1", 2, "config.xml: cannot be read: File name too long"},
      {"tube.stl/config.xml --rbc 1", 2, "tube.stl/config.xml: cannot be read: Not a directory"},
      {"loop.xml --rbc 1", 2, "loop.xml: cannot be read: Too many levels of symbolic links",
       loop("loop.xml")},
      {"20 20 20 --cell-mesh a 1 loop.stl", 2, "loop.stl: cannot be read: Too many levels", loop("loop.stl")},
      {"--restart " + longName, 2, "cannot be read: File name too long"},
      {"20 20 20 --cell egg 1 1 1 1 --start " + longPath + "egg.pos", 2,
       "cannot be read: File name too long"},
      {pack + "--output-dir " + longPath, 5, "File name too long"},
      {pack + "--output-dir " + longName, 5, "File name too long"},
      {pack + "--output-dir " + std::string(5000, 'p'), 5, "/RBC.pos: "},
      {pack + "--output-dir tube.stl/deep", 5, "is not a folder"},
      {pack + "--output-dir gone", 5, "gone: is a link to nowhere, which does not exist",
       [](const fs::path& folder) { fs::create_symlink("nowhere", folder / "gone"); }},
      {pack + "--state " + longName, 5, "File name too long"},
      {pack + "--report " + longName + ".json", 5, "File name too long"},
      {pack + "--report " + longPath + "r.json", 5, "File name too long"},
      {pack, 5, "RBC.pos: cannot be written: Too many levels of symbolic links", loop("RBC.pos")},
      {"config.xml --hematocrit 0.2", 2, "tube.stl: cannot be read: Too many levels of symbolic links",
       [&](const fs::path& folder) {
         fs::remove(folder / "tube.stl");
         loop("tube.stl")(folder);
       }},
      {"config.xml --hematocrit 0.2 --plt_ratio 0", 2, "RBC.xml: cannot be read: Too many levels",
       [&](const fs::path& folder) {
         fs::remove(folder / "RBC.xml");
         loop("RBC.xml")(folder);
       }},
  });
  const TemporaryFolder folder;
  CHECK_THAT(run(folder, pack + "--output-dir " + std::string(5000, 'p')).err,
             Contains(' ' + std::string(150, 'p') + "..." + std::string(141, 'p') + "/RBC.pos: "));
}

TEST_CASE("Pipes, devices and unreadable files are rejected as input", "[executable]") {
  const auto fifo = [](const std::string& name) {
    return [=](const fs::path& folder) {
      fs::remove(folder / name);
      REQUIRE(mkfifo((folder / name).c_str(), 0600) == 0);
    };
  };
  requireRefused({
      {"config.xml --rbc 1", 2, "config.xml: is a pipe, expected an XML file", fifo("config.xml")},
      {"config.xml --rbc 1", 2, "RBC.xml: is a pipe, expected an XML file", fifo("RBC.xml")},
      {"config.xml --rbc 1", 2, "tube.stl: is a pipe, expected a mesh file", fifo("tube.stl")},
      {"20 20 20 --cell-mesh a 1 a.off", 2, "a.off: is a pipe, expected a mesh file", fifo("a.off")},
      {"20 20 20 --rbc 2 --fixed RBC.pos", 2, "RBC.pos: is a pipe, expected a .pos file", fifo("RBC.pos")},
      {"check --box 20 20 20", 2, "RBC.pos: is a pipe, expected a .pos file", fifo("RBC.pos")},
      {"--restart s.h5", 2, "s.h5: is a pipe, expected a packMesh state", fifo("s.h5")},
      {"20 20 20 --rbc 1 --state s.h5", 5, "s.h5: is not a regular file and cannot be replaced",
       fifo("s.h5")},
      // Of a regular file by its kind; what a process has at address 0 cannot be read.
      {"20 20 20 --cell-mesh a 1 a.stl", 2, "a.stl: cannot be read: Input/output error",
       [](const fs::path& folder) { fs::create_symlink("/proc/self/mem", folder / "a.stl"); }},
  });
}

TEST_CASE("Folders without permission are distinguished from missing files", "[executable]") {
  std::string asNobody;  // root may do everything
  if (geteuid() == 0) {
    if (std::system("setpriv --version > /dev/null 2>&1") != 0) {
      WARN("not tested: there is no setpriv, and root may do everything");
      return;
    }
    asNobody = "setpriv --reuid=65534 --regid=65534 --clear-groups ";
  }
  const SampleCase folder;
  fs::permissions(folder.path(), fs::perms::all);
  fs::copy_file(fs::path(test::programFolder) / "packMesh",
                folder / "program");  // its own may be inaccessible
  fs::create_directory(folder / "locked");
  fs::copy_file(folder / "config.xml", folder / "locked/config.xml");
  fs::create_directory(folder / "out");
  fs::permissions(folder / "out", fs::perms::all);
  fs::create_symlink("../locked/RBC.pos", folder / "out/RBC.pos");
  fs::permissions(folder / "locked", fs::perms::none);
  const auto say = [&](const std::string& arguments) {
    return runProcess(folder, arguments, asNobody, (folder / "program").string());
  };
  CHECK_THAT(withExit(2, say("locked/config.xml --rbc 1")).err,
             Contains("locked/config.xml: cannot be read: Permission denied"));
  CHECK_THAT(withExit(5, say("20 20 20 --rbc 1 --output-dir out")).err,
             Contains("out/RBC.pos: cannot be written: Permission denied"));
  CHECK_THAT(withExit(5, say("20 20 20 --rbc 1 --output-dir out --state locked/s.h5")).err,
             Contains("locked"));
  fs::permissions(folder / "locked", fs::perms::all);
}

TEST_CASE("Input of implausible size is rejected, and large input is read quickly", "[executable]") {
  const auto config = [](const std::string& text) {
    return [=](const fs::path& folder) { writeText(folder / "config.xml", text); };
  };
  std::string attributes;
  for (int i = 0; i < 200'000; ++i) attributes += fmt::format("a{}=\"1\" ", i);
  requireRefused({
      {"config.xml", 2, "config.xml:2: a tag has more than 1000 attributes",
       config(caseOf("<!-- <a = = = > -->\n<species name=\"RBC\" " + attributes + "/>"))},
      {"config.xml", 2, "more than 10000 species", config(caseOf(ellipsoids(10'001)))},
  });
  const TemporaryFolder folder;
  writeText(folder / "config.xml", caseOf(ellipsoids(2000)));
  CHECK_THAT(ok(folder, "config.xml --validate").out, Contains("config.xml is valid"));
}

TEST_CASE("<packing> is accepted only as a child of <hemocell>", "[executable]") {
  const std::string domain = "<domain>" + sampleDomain + "</domain>",
                    packing = "<packing><seed>2</seed></packing>";
  const auto config = [](const std::string& text) {
    return [=](const fs::path& folder) { writeText(folder / "config.xml", text); };
  };
  requireRefused({
      {"config.xml --rbc 1", 2, "config.xml:2: <packing>: found outside of <hemocell>",
       config("<hemocell>" + domain + "</hemocell>\n" + packing)},
      {"config.xml --rbc 1", 2,
       "config.xml:1: <packing>: found in <domain>; it must be a child of <hemocell>",
       config("<hemocell><domain>" + sampleDomain + packing + "</domain></hemocell>")},
      {"config.xml --rbc 1", 2, "config.xml:1: <Packing>: unknown tag, did you mean <packing>?",
       config("<hemocell>" + domain + "<Packing/></hemocell>")},
      {"config.xml --rbc 1", 2, "config.xml:1: <packin>: unknown tag, did you mean <packing>?",
       config("<hemocell>" + domain + "<packin/></hemocell>")},
      {"config.xml --rbc 1", 2, "config.xml:1: <pakcing>: unknown tag, did you mean <packing>?",
       config("<hemocell>" + domain + "<pakcing/></hemocell>")},
  });
  const SampleCase folder;  // a tag of the case's own beside <packing>
  config("<hemocell>" + domain + packing + "<packings/><backing/></hemocell>")(folder.path());
  ok(folder, "config.xml --rbc 1 --validate");
}

TEST_CASE("check is recognised at any position of the command line", "[executable]") {
  const SampleCase folder;
  ok(folder, "config.xml --rbc 5");
  const Ran usual = run(folder, "check config.xml"), other = ok(folder, "config.xml check");
  CHECK(other.out == usual.out);
  CHECK_THAT(other.out, Contains("Verdict: clean"));
}

TEST_CASE("Options given twice with different values are rejected") {
  const auto parse = [](const std::vector<std::string>& words, const char* name = "packMesh") {
    return parseCommandLine(name, words).request;
  };
  const std::vector<std::string> seeds = {"9", "9", "9", "--rbc", "1", "--seed", "1", "--seed", "2"};
  CHECK_THROWS_WITH(parse(seeds), Contains("'--seed' is given twice, with different values"));
  CHECK(parse(seeds, "packCells").seed == 2u);  // as packCells, where the last one counts
  CHECK_THROWS_WITH(parse({"--restart", "a.h5", "--restart", "b.h5"}),
                    Contains("'--restart' is given twice"));
  CHECK_THROWS_WITH(parse({"9", "9", "9", "-h", ".3", "--hematocrit=.4"}),
                    Contains("'--hematocrit' is given twice"));
  CHECK_THROWS_WITH(parse({"9", "9", "9", "--rbc", "1", "--orient", "RBC", "1", "0", "0", "5", "--orient",
                           "RBC", "0", "1", "0", "5"}),
                    Contains("'--orient' is given twice for 'RBC'"));
  CHECK_THROWS_WITH(parse({"9", "9", "9", "--fixed", "a/RBC.pos", "--fixed", "b/RBC.pos"}),
                    Contains("twice for 'RBC'"));
  CHECK_NOTHROW(parse({"9",   "9",       "9",         "--rbc",    "1",         "--rbc",  "1",        "--cell",
                       "a",   "1",       "1",         "1",        "1",         "--cell", "b",        "1",
                       "1",   "1",       "1",         "--growth", "alpha",     "0.1",    "--growth", "beta",
                       "0.1", "--fixed", "a/RBC.pos", "--fixed",  "a/PLT.pos", "--vtp",  "--vtp"}));
}

TEST_CASE("Columns are rejected for cells with a prescribed direction", "[executable]") {
  requireRefused({{"40 40 40 --ends periodic --rbc 40 --order columns --orient RBC 0 0 1 5", 2,
                   "cannot start in columns: the orientation of its cells is constrained"}});
}
