// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/cat/state_frames.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/python_command.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/cat/cat.h"
#include "hemocell_adapter/output/shared_files.h"
#include "packMesh/io/hdf5_meshes.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isFrame(const fs::path& file) {
  const std::string name = file.filename().string();
  return file.extension() == ".h5" && (name.rfind("state_", 0) == 0 || name.rfind("cat_cells_", 0) == 0);
}

PackingTables tablesOf(const std::vector<PlacedCell>& own, const PackingProblem& problem) {
  PackingTables tables;
  const Physics& physics = problem.physics;
  const bool withShapes = physics.hasDeformed();
  std::vector<std::int64_t> counts(physics.species.size());
  CellColumn scales{"scale", 1, {}};
  for (const PlacedCell& cell : own) {
    const double scale = std::cbrt(cell.placement.linear.determinant());
    tables.kind.push_back(cell.species);
    if (withShapes)
      tables.vertices.push_back(physics.isDeformed(cell) ? &physics.shapeOf(cell).mesh().vertices : nullptr);
    tables.poses.push_back(
        {scale, Quaternion(Mat3(cell.placement.linear / scale)), cell.placement.translation});
    scales.values.push_back(scale);
    ++counts[cell.species];
  }
  problem.execution.communicator.sum(counts);
  for (std::size_t s = 0; s < counts.size(); ++s) {
    const Species& species = physics.species[s];
    tables.kinds.push_back({species.kindName(), &physics.shapeOf(species).mesh(), counts[s]});
  }
  tables.columns.push_back(std::move(scales));
  return tables;
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
  const PackingTables tables = tablesOf(own, problem_);
  try {
    writePacking(folder_ / fmt::format("state_{:06}.h5", state), tables, ranks);
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
