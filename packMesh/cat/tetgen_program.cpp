// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetgen_program.h"

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/helper_process.h"
#include "packMesh/core/spawn.h"
#include "packMesh/core/version.h"
#include "packMesh/cat/tetgen_data.h"

namespace packmesh {
namespace {

namespace fs = std::filesystem;

constexpr const char* name = "packmesh-tetgen";
constexpr const char* variable = "PACKMESH_TETGEN";

/// From a Python package to the folder it is installed under: prefix/lib/python3.x/site-packages/packmesh.
constexpr int foldersAbove = 4;

/// A program that has not printed its version after so long is not ours. [ms]
constexpr int mostMilliseconds = 60'000;

constexpr std::size_t mostShown = 300;  ///< of what it prints [bytes]

/// The file of the program or shared library that this code is part of; empty if the system does not tell.
fs::path ownFile() {
  const auto own = reinterpret_cast<std::uintptr_t>(&tetgenProgram);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    // begin-end permissions offset device inode path
    std::istringstream fields(line);
    std::uintptr_t begin = 0, end = 0;
    char dash;
    fields >> std::hex >> begin >> dash >> end;
    if (own < begin || own >= end) continue;
    const std::size_t path = line.find('/');
    return path == line.npos ? fs::path() : fs::path(line.substr(path));
  }
  return {};
}

std::vector<fs::path> placesOf() {
  std::vector<fs::path> places;
  const fs::path own = ownFile();
  if (!own.empty()) {
    fs::path folder = own.parent_path();
    places.push_back(folder / name);
    for (int above = 0; above <= foldersAbove && folder != folder.root_path(); ++above) {
      places.push_back(folder / "libexec" / "packmesh" / name);
      folder = folder.parent_path();
    }
  }
  places.push_back(fs::path(installedHelpers()) / name);
  return places;
}

/// What prevents runs; empty if nothing does.
std::string faultHere() {
  std::string program;
  try {
    program = tetgenProgram();
  } catch (const InputError& error) {
    return error.what();
  }
  HelperProcess version(program, {"--version"}, {}, 0);
  bool ended = false;
  for (int waited = 0; !ended && waited < mostMilliseconds; waited += 50) ended = version.wait(50);
  if (ended && version.fault().empty() && version.words() == tetgenProgramVersion()) return {};
  const std::string printed = " and prints '" + version.words().substr(0, mostShown) + "'";
  const std::string found = (!ended                    ? "does not end"
                             : version.fault().empty() ? "ends"
                                                       : version.fault()) +
                            printed;
  return program + " --version should print '" + tetgenProgramVersion() + "', but it " + found +
         ". Is it from another version of packMesh? (" + variable + " sets the path)";
}

}  // namespace

std::string tetgenProgram() {
  if (const char* given = std::getenv(variable); given && *given) {
    if (isProgram(given)) return given;
    throw InputError(std::string(variable) + " is '" + given +
                     "', which is not a program that can be started");
  }
  std::string places;
  for (const fs::path& place : placesOf()) {
    if (isProgram(place)) return place.string();
    places += (places.empty() ? "" : ", ") + place.string();
  }
  throw InputError(
      "tetrahedra between cells need the program packmesh-tetgen, which comes with packMesh but is not "
      "at any of these places: " +
      places + ". Set " + variable + " to its path");
}

void requireTetgen(const Communicator& ranks) {
  const std::string fault = faultHere();
  const std::int64_t first =
      ranks.min(fault.empty() ? std::int64_t{ranks.size()} : std::int64_t{ranks.rank()});
  if (first == ranks.size()) return;
  throw InputError(ranks.broadcast(fault, static_cast<int>(first)));
}

}  // namespace packmesh
