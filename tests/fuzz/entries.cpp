// SPDX-License-Identifier: AGPL-3.0-or-later
#include "tests/fuzz/entries.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "hemocell_adapter/hemocell/case.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/species_plans.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/packing/state_file.h"
#include "tests/support/temporary_folder.h"

namespace packmesh::test {
namespace {

namespace fs = std::filesystem;
using namespace packmesh::hemocell;

const fs::path& folder() {
  static const TemporaryFolder folder;
  return folder.path();
}

fs::path fileOf(const std::string& name, const std::string& bytes) {
  const fs::path file = folder() / name;
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

/// Refusals are fine, if they say something.
template <class Reading>
void refusable(Reading&& reading) {
  try {
    reading();
  } catch (const InputError& error) {
    if (std::string(error.what()).size() < 10) throw std::logic_error("a refusal without a reason");
  }
}

void readConfig(const std::string& bytes) {
  const fs::path file = fileOf("config.xml", bytes);
  refusable([&] { readCase(file); });
  refusable([&] {
    CompletedRequest completed =
        requestToPack(parseCommandLine("packMesh", {file.string(), "--rbc", "1", "--validate"}).request);
    plansToPack(completed.request, completed.simulation.get(), completed.warnings);
  });
}

void readCell(const std::string& bytes) {
  const fs::path file = fileOf("RBC.xml", bytes);
  for (const char* name : {"RBC", "PLT", "WBC"})
    refusable([&] {
      const CellModel model = readCellXml(file, name);
      if (model.minNumTriangles <= 5120) buildTemplate(model, 0.5);
    });
}

void readMeshFile(const std::string& bytes) {
  for (const char* ending : {"stl", "off", "ply", "obj"}) {
    const fs::path file = fileOf(std::string("mesh.") + ending, bytes);
    refusable([&] {
      TriangleMesh mesh = readMesh(file);
      if (mesh.triangles.size() <= 2000) repairClosed(mesh, file.string());
    });
  }
}

void readPosFile(const std::string& bytes) {
  const fs::path file = fileOf("RBC.pos", bytes);
  refusable([&] {
    std::vector<std::string> warnings;
    const std::vector<PosLine> lines = readPos(file, &warnings);
    const fs::path again =
        fileOf("again.pos", formatPosHead(std::int64_t(lines.size())) + formatPosLines(lines));
    if (readPos(again).size() != lines.size()) throw std::logic_error("reads back differently");
  });
}

void readState(const std::string& bytes) {
  const fs::path file = fileOf("state.h5", bytes);
  refusable([&] { readStateHead(file); });
}

/// Words end at a 0 or at the end of a line. Files they name are in a folder of no files.
void readCommand(const std::string& bytes) {
  std::vector<std::string> words(1);
  for (const char c : bytes) {
    if (c == '\0' || c == '\n')
      words.emplace_back();
    else
      words.back() += c;
  }
  for (const char* program : {"packMesh", "packCells"})
    refusable([&] {
      const CommandLine commandLine = parseCommandLine(program, words);
      if (commandLine.command == Command::pack) requestToPack(commandLine.request);
      if (commandLine.command == Command::check) requestToCheck(commandLine.request);
    });
}

}  // namespace

const std::vector<FuzzEntry>& fuzzEntries() {
  static const std::vector<FuzzEntry> entries = {
      {"config_xml",
       readConfig,
       {"<packing>", "</packing>", "<container>", "<species name=\"RBC\"/>", "&a;", "<!ENTITY", "nan",
        "1e999", "-1"}},
      {"cell_xml", readCell, {"<radius>", "</radius>", "1e-300", "nan", "2147483648", "<StlFile>", "&#0;"}},
      {"mesh",
       readMeshFile,
       {"OFF", "ply\nformat ascii 1.0\n", "vertex", "element face", "1000000000", "nan", "inf", "1e308",
        "solid", "f -1/2/3"}},
      {"pos", readPosFile, {"1000000000", "nan", "\r\n", "1e308", "-0", "#", "9223372036854775807"}},
      {"state",
       readState,
       {"packMesh state, version 3\nwritten by ", "XXH3 ", "\x89HDF\r\n\x1a\n", "TREE", "HEAP", "SNOD",
        "OHDR"}},
      {"command_line",
       readCommand,
       {"--hematocrit\n", "--rbc\n", "config.xml\n", "--cell\n", "=", "--fixed\n", "1e308\n", "nan\n",
        "check\n", "--\n"}},
  };
  return entries;
}

}  // namespace packmesh::test
