// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/state_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/state_words.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "packMesh/core/input_file.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

/// What it took to get there.
std::string effortOf(const PackingState& state) {
  return state.growth.iterations > 0 ? fmt::format("{} iterations", state.growth.iterations)
                                     : fmt::format("{} sweeps", state.relaxation.sweeps);
}

namespace fs = std::filesystem;

/// The case of a run that continues: in the working directory or, if that is the folder of a realisation, in
/// its parent folder.
/// @throws InputError if it is in neither
void findCase(CommandLine& commandLine) {
  if (!commandLine.configFile || isThere(*commandLine.configFile)) return;
  const fs::path state = *commandLine.options().restart;
  if (const auto place = placeInSeries(state, {})) {
    const fs::path around = place->seriesFolder / *commandLine.configFile;
    if (isThere(around)) {
      commandLine.configFile = around;
      return;
    }
  }
  throw InputError(
      fmt::format("{}: no such file; the run of {} was started in another folder; restart it there",
                  commandLine.configFile->string(), state.string()));
}

}  // namespace

CommandLine parseOrContinue(const std::string& program, const std::vector<std::string>& arguments) {
  CommandLine commandLine = parseCommandLine(program, arguments);
  if (!commandLine.restartAlone) return commandLine;
  const Request options = commandLine.options();
  std::vector<std::string> words = wordsNow(readStateHead(*options.restart).command, *options.restart);
  requireCommand(words, *options.restart);
  if (words.empty())
    throw InputError(options.restart->string() +
                     ": does not contain the command of the run; repeat it with --restart");
  const std::string begunBy = words.front();
  words.erase(words.begin());
  words.insert(words.end(), arguments.begin(), arguments.end());
  CommandLine continued = parseCommandLine(begunBy, words, words.size() - arguments.size());
  findCase(continued);
  return continued;
}

void requireReplaceableState(const Request& request) {
  const std::filesystem::path& file = *request.output.stateFile;
  requireWritable(file.parent_path());
  for (const char* kind : {".pos", ".pov"})
    if (file.extension() == kind)
      throw OutputError(
          fmt::format("{}: {} files are used for cells; the state needs another name", file.string(), kind));
  try {
    requireReplaceable(file);
    std::error_code ignored;
    const bool continued = request.restart && std::filesystem::equivalent(file, *request.restart, ignored);
    if (!continued && isThere(file)) readStateHead(file);
  } catch (const Error& error) {
    throw OutputError(
        fmt::format("{}; the state is not written over it (--state names another file)", error.what()));
  }
}

Checkpoints StateFiles::checkpoints() {
  Checkpoints checkpoints;
  checkpoints.due = [this] {
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - last_;
    return checkpointAsked() ||
           (request_.output.checkpointEvery > 0.0 && since.count() >= request_.output.checkpointEvery);
  };
  checkpoints.save = [this](const PackingState& state) { save(state); };
  checkpoints.endsWithFewer = request_.bestEffort;
  return checkpoints;
}

void StateFiles::save(const PackingState& state) {
  saved_ = false;
  try {
    writeState(*request_.output.stateFile, problem_, storedWords(request_.words, *request_.output.stateFile),
               state);
    saved_ = true;
  } catch (const OutputError& error) {
    log::warning(error.what());
  }
  if (*saved_)
    log::detail(
        fmt::format("Saved the state after {} in {}", effortOf(state), request_.output.stateFile->string()));
  last_ = std::chrono::steady_clock::now();
  forgetCheckpointAsked();
}

PackingState stateToContinue(const std::filesystem::path& file, const PackingProblem& problem) {
  PackingState state = readState(file, problem);
  log::info(fmt::format("Continuing from {}: after {}", file.string(), effortOf(state)));
  return state;
}

}  // namespace packmesh::hemocell
