// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/cat/state_frames.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/python_command.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/cat/cat.h"
#include "hemocell_adapter/output/output_plan.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isFrame(const fs::path& file) {
  const std::string name = file.filename().string();
  return file.extension() == ".h5" && (name.rfind("state_", 0) == 0 || name.rfind("cat_cells_", 0) == 0);
}

void writeFrame(const fs::path& file, const std::vector<PlacedCell>& own, const PackingProblem& problem) {
  PackingResult frame;
  frame.cells = own;
  Physics physics = problem.physics;
  std::vector<std::int64_t> counts(physics.species.size());
  CellColumn scales{"scale", 1, {}};
  for (const PlacedCell& cell : own) {
    const double scale = std::cbrt(cell.placement.linear.determinant());
    frame.poses.push_back(
        {scale, Quaternion(Mat3(cell.placement.linear / scale)), cell.placement.translation});
    scales.values.push_back(scale);
    ++counts[cell.species];
  }
  problem.execution.communicator.sum(counts);
  for (std::size_t s = 0; s < counts.size(); ++s) physics.species[s].count = counts[s];
  const Communicator& ranks = problem.execution.communicator;
  commitTogether(writtenPacking(file, physics, frame, {{}, {std::move(scales)}}, ranks), ranks);
}

}  // namespace

StateFrames::StateFrames(const PackingProblem& problem, const FrameSeries& series)
    : problem_(problem), folder_(folderIn(series.folder)), every_(series.every) {
  const Communicator& ranks = problem_.execution.communicator;
  SharedFiles(ranks).makeFolder(folder_);
  onFirstRank(ranks, [&] {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored))
      if (isFrame(entry.path())) fs::remove(entry.path(), ignored);
  });
}

void StateFrames::add(const std::vector<PlacedCell>& own) {
  const std::int64_t state = states_++;
  if (state % every_ != 0) return;
  const Communicator& ranks = problem_.execution.communicator;
  try {
    writeFrame(folder_ / fmt::format("state_{:06}.h5", state), own, problem_);
  } catch (const OutputError& error) {  // the same on all ranks
    throw AgreedFailure({ExitCode::cannotWrite, error.what()});
  }
  if (ranks.sum(std::int64_t(own.size())) > mostWithCatCells) return;
  const std::vector<PlacedCell> all = ranks.gatherAll(own);
  onFirstRank(ranks, [&] {
    const std::vector<NamedMesh> cells = catCellsOf(all, problem_.physics);
    if (!cells.empty()) writeMeshes(folder_ / fmt::format("cat_cells_{:06}.h5", state), cells);
  });
}

void StateFrames::convert() const {
  onFirstRank(problem_.execution.communicator, [&] {
    const std::vector<std::string> words = {"growth-frames", folder_.string(), "--remove"};
    const CommandEnd end = runPackmesh(words, interrupted);
    for (const std::string& line : end.lines) log::detail(line);
    if (end.kind != CommandEnd::Kind::done)
      log::warning(
          fmt::format("the states of growth in {} are not yet series for ParaView ({}); this makes them: {}",
                      folder_.string(), end.message, asTyped(words)));
  });
}

}  // namespace packmesh::hemocell
