// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/output_plan.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/problem/realisation_folders.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "packMesh/io/sealed_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

constexpr char mark[] = ".checkpoint";

/// Where the outputs are: the folder of the case, and the state in it.
OutputRequest withPlaces(OutputRequest output, const CompletedRequest& completed) {
  const std::optional<fs::path>& restart = completed.request.restart;
  if (output.folder.empty())
    output.folder = completed.simulation ? completed.simulation->folder : fs::path(".");
  if (!output.stateFile && (output.checkpointEvery > 0.0 || restart))
    output.stateFile = restart ? resultOf(*restart) : output.folder / "state.h5";
  return output;
}

/// Outputs that cannot be are refused, not ignored.
void refuseContradictions(const Request& request, const OutputRequest& output) {
  if (output.reportFile && output.reportFile->extension() != ".json" &&
      output.reportFile->extension() != ".html")
    refuseStated(
        request, "report",
        fmt::format("expected a file that ends in .json or .html, found '{}'", output.reportFile->string()));
  if (request.largestClearance && output.stateFile)
    throw UsageError(fmt::format(
        "the largest clearance ({}) requires many packings, and a state belongs to one: omit {} and {}, or "
        "state a clearance",
        named("clearance", "max"), named("state"), named("checkpoint-every")));
}

/// A restart of one of several realisations continues with the following ones, in the folder that contains
/// them all.
OutputRequest withRealisations(OutputRequest output, const Request& request) {
  if (request.realisations == 1 || !request.restart) return output;
  const auto place = placeInSeries(*request.restart, request.realisations);
  if (!place)
    throw UsageError(fmt::format(
        "{}: realisations continue from the state of one of them, where it was written: {}; found '{}'",
        heading("restart"),
        (output.folder / realisationFolder(1, request.realisations) / "state.h5").string(),
        request.restart->string()));
  output.realisation = place->realisation;
  output.folder = place->seriesFolder;
  return output;
}

OutputRequest settled(OutputRequest output, const CompletedRequest& completed) {
  output = withPlaces(std::move(output), completed);
  refuseContradictions(completed.request, output);
  return withRealisations(std::move(output), completed.request);
}

}  // namespace

OutputRequest outputsToPack(const CompletedRequest& completed) {
  OutputRequest output = settled(completed.request.output, completed);
  const bool deformed = completed.deformed || completed.request.deforms();
  if (deformed && !output.stateFile && !(completed.simulation && completed.simulation->running))
    output.stateFile = output.folder / "state.h5";  // .pos files cannot have such cells
  return output;
}

OutputRequest outputsInRunning(const CompletedRequest& completed) {
  OutputRequest output = outputsToPack(completed);
  if (!completed.request.states("outputDirectory")) output.exports.clear();
  return output;
}

OutputRequest outputsInMemory(const Request& asked, const CompletedRequest& completed) {
  const OutputRequest all = outputsToPack(completed);
  OutputRequest output;
  output.folder = all.folder;
  output.checkpointEvery = all.checkpointEvery;
  if (asked.output.stateFile || asked.restart || asked.states("checkpointEvery"))
    output.stateFile = all.stateFile;
  if (asked.states(framesSetting().key())) output.frames = all.frames;
  return output;
}

OutputRequest outputsToCheck(const Request& asked, const CompletedRequest& completed,
                             const std::optional<fs::path>& folder) {
  OutputRequest output = completed.request.output;
  output.exports = asked.output.exports;
  output.povScene = asked.output.povScene;
  output.vtp = asked.output.vtp;
  output.vtpMeshes = asked.output.vtpMeshes;
  output.undeformed = asked.output.undeformed;
  output.reportFile = asked.output.reportFile;
  output = settled(std::move(output), completed);
  if (folder) output.folder = *folder;
  return output;
}

std::vector<fs::path> foldersToCheck(const Request& request, const OutputRequest& output) {
  if (!request.startStates.empty()) return {};
  std::vector<fs::path> folders = realisationFoldersIn(output.folder);
  if (folders.empty()) return folders;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(output.folder, ignored))
    if (entry.path().extension() == ".pos") {
      folders.insert(folders.begin(), output.folder);
      break;
    }
  if (output.asksForViews())
    throw UsageError(fmt::format(
        "reports, scenes, VTK files and exports of a check are of one folder: name one of the realisations "
        "by {}",
        named("output-dir")));
  return folders;
}

fs::path outputFolder(const Case& simulation) {
  const fs::path& stated = simulation.packing.output.folder;
  return stated.empty() ? fs::absolute(simulation.file).parent_path() : stated;
}

std::optional<FrameSeries> requestedFrames(const OutputRequest& output) {
  if (output.frames == 0) return {};
  return FrameSeries{output.folder, output.frames};
}

fs::path checkpointOf(const fs::path& state) {
  return state.parent_path() / (state.stem().string() + mark + state.extension().string());
}

bool isCheckpoint(const fs::path& file) {
  return file.extension() == mark || file.stem().extension() == mark;  // a state may have no extension
}

fs::path resultOf(const fs::path& file) {
  if (!isCheckpoint(file)) return file;
  if (file.extension() == mark) return file.parent_path() / file.stem();
  return file.parent_path() / (file.stem().stem().string() + file.extension().string());
}

bool savesCheckpoints(const Request& request, const OutputRequest& output) {
  return output.stateFile && (request.states("stateFile") || output.checkpointEvery > 0.0 || request.restart);
}

void SharedFiles::makeFolder(const std::filesystem::path& folder) {
  onFirstRank(ranks_, [&] {
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
      throw OutputError(
          fmt::format("{}: the folder cannot be created: {}", folder.string(), error.message()));
  });
}

void SharedFiles::begin(const std::filesystem::path& target) {
  onFirstRank(ranks_, [&] { files_.begin(target); });
}

void SharedFiles::append(const std::function<std::string()>& text) {
  onFirstRank(ranks_, [&] { files_.append(text()); });
}

void SharedFiles::appendParts(const std::vector<std::string>& own) {
  std::optional<OutputError> error;
  ranks_.streamToFirst({own.begin(), own.end()}, [&](std::string_view part) {
    try {
      if (!error) files_.append(part);
    } catch (const OutputError& failure) {
      error = failure;
    }
  });
  onFirstRank(ranks_, [&] {
    if (error) throw *error;
  });
}

void SharedFiles::end() {
  onFirstRank(ranks_, [&] { files_.end(); });
}

void SharedFiles::take(AtomicFiles& others) {
  onFirstRank(ranks_, [&] { files_.take(others); });
}

std::string SharedFiles::hash() {
  return ranks_.broadcast(ranks_.rank() == 0 ? fileHash(files_.temporary()) : std::string(), 0);
}

void SharedFiles::commit() {
  onFirstRank(ranks_, [&] { files_.commit(); });
}

}  // namespace packmesh::hemocell
