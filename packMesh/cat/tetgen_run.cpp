// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetgen_run.h"

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/process.h"
#include "packMesh/core/version.h"

namespace packmesh {
namespace {

namespace fs = std::filesystem;

constexpr const char* programName = "packmesh-tetgen";
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
    places.push_back(folder / programName);
    for (int above = 0; above <= foldersAbove && folder != folder.root_path(); ++above) {
      places.push_back(folder / "libexec" / "packmesh" / programName);
      folder = folder.parent_path();
    }
  }
  places.push_back(fs::path(installedHelpers()) / programName);
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

namespace {

constexpr int betweenPolls = 50;  // [ms]

/// The tetrahedra of n points take about 110 n bytes, and TetGen adds fewer points than there are.
constexpr std::size_t answerPerRequest = 100, answerAtLeast = std::size_t{64} << 20;  // [bytes]

/// What a process that has ended answered to this many points.
TetgenOutput outputOf(const HelperProcess& process, std::size_t points, TetgenFailure& failure) {
  failure = {};
  std::optional<TetgenAnswer> message = tetgenAnswerOf(process.answer());
  const bool isAnswer = message.has_value();
  TetgenAnswer answer = std::move(message).value_or(TetgenAnswer());
  // Also what a program of another origin could not know.
  const bool hasAllPoints =
      answer.code != 0 || answer.output.points.size() == points + answer.output.steinerLabels.size();
  const std::string& words = process.words();
  if (!isAnswer || !hasAllPoints) {
    failure.code = TetgenFailure::noAnswer;
    failure.words = "packmesh-tetgen " +
                    (process.fault().empty() ? "sent no valid answer" : process.fault()) +
                    (words.empty() ? "" : ": " + words);
    return {};
  }
  failure.code = answer.code;
  if (failure.code == 0) return std::move(answer.output);
  if (!words.empty()) failure.words = "TetGen's message: " + words;
  return {};
}

}  // namespace

TetgenOutput runTetgen(const TetgenInput& input, TetgenFailure& failure, const std::function<bool()>& stop) {
  const auto stopped = [&] {
    if (!stop || !stop()) return false;
    failure = {};
    failure.code = TetgenFailure::stopped;
    return true;
  };
  if (stopped()) return {};
  const std::size_t points = input.points.size();
  HelperProcess process(tetgenProgram(), {}, messageOf(input),
                        answerAtLeast + answerPerRequest * sizeof(Vec3) * points);
  while (!process.wait(betweenPolls))
    if (stopped()) return {};
  return outputOf(process, points, failure);
}

}  // namespace packmesh
