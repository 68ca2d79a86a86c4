// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/cat/growth_frames.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/python_command.h"
#include "hemocell_adapter/output/shared_files.h"
#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/tetrahedralise.h"
#include "packMesh/io/hdf5_meshes.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

bool isState(const fs::path& file) {
  const std::string name = file.filename().string();
  return file.extension() == ".h5" && (name.rfind("state_", 0) == 0 || name.rfind("cat_cells_", 0) == 0);
}

PackingTables tablesOf(const std::vector<PlacedCell>& own, const PackingProblem& problem) {
  PackingTables tables;
  std::vector<std::int64_t> counts(problem.physics.species.size());
  CellColumn scales{"scale", 1, {}};
  for (const PlacedCell& cell : own) {
    const double scale = std::cbrt(cell.placement.linear.determinant());
    tables.kind.push_back(cell.species);
    tables.poses.push_back(
        {scale, Quaternion(Mat3(cell.placement.linear / scale)), cell.placement.translation});
    scales.values.push_back(scale);
    ++counts[cell.species];
  }
  problem.execution.communicator.sum(counts);
  for (std::size_t s = 0; s < counts.size(); ++s)
    tables.kinds.push_back(
        {problem.physics.species[s].name, &problem.physics.species[s].shape->mesh(), counts[s]});
  tables.columns.push_back(std::move(scales));
  return tables;
}

/// The CAT cells in the order of the cells; none if TetGen fails.
std::vector<NamedMesh> catCellsOf(const std::vector<PlacedCell>& all, const Physics& physics) {
  TetrahedraInput input;
  for (const PlacedCell& cell : all)
    input.objects.push_back({&physics.species[cell.species].shape->hierarchy(), cell.placement});
  std::optional<MeshHierarchy> lumen;
  if (physics.container->wall()) lumen.emplace(physics.container->surface());
  input.container = lumen ? &*lumen : nullptr;
  input.period = physics.container->period();
  input.bounds = physics.container->bounds();
  input.explain = false;
  std::vector<NamedMesh> meshes;
  try {
    const CatCells cells = catCells(tetrahedralise(input), WallFaces::atWall);
    for (std::size_t i = 0; i < cells.cells.size(); ++i)
      meshes.push_back({std::to_string(i), cells.cells[i], "cell"});
  } catch (const std::runtime_error&) {  // TetGen failed, or the lumen's surface touches a cell
    meshes.clear();
  }
  return meshes;
}

}  // namespace

GrowthFrames::GrowthFrames(const PackingProblem& problem, fs::path folder, std::int64_t every)
    : problem_(problem), folder_(std::move(folder)), every_(every) {
  const Communicator& ranks = problem_.execution.communicator;
  SharedFiles(ranks).makeFolder(folder_);
  onFirstRank(ranks, [&] {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored))
      if (isState(entry.path())) fs::remove(entry.path(), ignored);
  });
}

void GrowthFrames::add(const std::vector<PlacedCell>& own) {
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

void GrowthFrames::convert() const {
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
