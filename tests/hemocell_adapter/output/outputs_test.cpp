// SPDX-License-Identifier: AGPL-3.0-or-later
// Outputs and what the run has read, with the real executable.
#include "hemocell_adapter/output/outputs.h"

#include "hemocell_adapter/base/exit_codes.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

using namespace packmesh::test;
using packmesh::hemocell::ExitCode;
namespace fs = std::filesystem;

namespace {

const char tetrahedron[] = "OFF\n4 4 0\n0 0 0\n8 0 0\n0 8 0\n0 0 8\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
/// A cylinder as STL, in µm.
std::string vessel() {
  return tubeStl(30.0, 12.0, 24);
}

}  // namespace

TEST_CASE("No output replaces a file that the run has read", "[executable]") {
  struct Row {
    std::string name, arguments;
  };
  const auto [name, arguments] = GENERATE(
      Row{"cells.stl", "--vessel cells.stl 1 --rbc 2 --export stl"},
      Row{"RBC_template.off", "30 30 30 --cell-mesh other 1 RBC_template.off --rbc 2 --export csv"},
      Row{"RBC.pos", "30 30 30 --rbc 3 --start RBC.pos"}, Row{"RBC.pos", "30 30 30 --rbc 3 --fixed RBC.pos"},
      Row{"other.pos", "30 30 30 --cell-mesh other 2 cell.off --start other.pos --dry-run"},
      Row{"again.json", "again.json --rbc 1 --report again.html"},
      Row{"s.h5", "30 30 30 --rbc 2 --start s.h5 --state s.h5"},
      Row{"cells.stl", "obstacle.xml --walls yz --rbc 1 --export stl"});
  CAPTURE(arguments);
  const SampleCase folder;
  const fs::path file = folder / name;
  writeText(folder / "cell.off", tetrahedron);
  writeText(
      folder / "obstacle.xml",
      configXml(
          "<dx> 5e-7 </dx> <nx>60</nx> <ny>60</ny> <nz>60</nz>",
          "<packing> <container> <obstacles> <mesh file=\"cells.stl\" scale=\"0.2\" offset=\"10 15 15\"/> "
          "</obstacles> </container> </packing>"));
  if (file.extension() == ".pos") writeText(file, "1\n10 10 10 0 0 0\n");
  if (name == "s.h5") ok(folder, "30 30 30 --rbc 2 --state s.h5 --output-dir before");
  if (name == "again.json") fs::copy_file(folder / "config.xml", file);
  if (file.extension() == ".off") writeText(file, tetrahedron);
  if (name == "cells.stl") writeText(file, vessel());
  const std::string before = readText(file);
  CHECK_THAT(ended(folder, int(ExitCode::cannotWrite), arguments).err,
             Contains(name + ": is read by this run and would be overwritten"));
  CHECK((readText(file) == before));
}

TEST_CASE("A state is replaced by the run that continues it, fixed cells by the same bytes", "[executable]") {
  const SampleCase folder;
  ok(folder, "30 30 30 --rbc 4 --state s.h5");
  ok(folder, "--restart s.h5");
  const std::string red = readText(folder / "RBC.pos");
  ok(folder, "30 30 30 --rbc 4 --fixed RBC.pos --plt 3");
  CHECK(readText(folder / "RBC.pos") == red);
  // Across a periodic face: written as its image inside, which are other bytes.
  writeText(folder / "RBC.pos", "1\n31 10 10 0 0 0\n");
  ended(folder, int(ExitCode::cannotWrite), "30 30 30 --ends periodic --rbc 1 --fixed RBC.pos --plt 3");
}
