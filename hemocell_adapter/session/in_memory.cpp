// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/in_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/session/examination.h"
#include "packMesh/analysis/cell_measures.h"
#include "packMesh/core/input_file.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

Prepared prepare(const Request& asked, Session& session, const Communicator& ranks) {
  CompletedRequest completed;
  Prepared prepared;
  together(ranks, [&] {
    completed = requestToPack(asked);
    prepared.output = outputsInMemory(asked, completed);
  });
  prepared.problem = session.prepare(completed);
  return prepared;
}

/// The cells of a state in a problem: with its species, and its shapes where the state names one with the
/// same vertices, as that of a packing does. All ranks call.
/// @param kinds of each species @return with the problem, which has the other shapes, too
Packing placeCells(const StateCells& state, const std::vector<int>& kinds,
                   std::shared_ptr<const Problem> problem) {
  std::vector<std::int32_t> speciesOf(state.species.size());
  for (std::size_t s = 0; s < kinds.size(); ++s)
    if (kinds[s] >= 0) speciesOf[kinds[s]] = std::int32_t(s);
  Packing packing;
  std::map<std::size_t, std::vector<Vec3>> others;
  for (const Cell& cell : state.cells) {
    const std::int32_t species = speciesOf[cell.species];
    std::int32_t shape = species;
    if (!cell.vertices.empty()) {
      const auto named = std::size_t(cell.shape);
      if (named < problem->shapes.size() && problem->shapes[named]->mesh().vertices == cell.vertices)
        shape = cell.shape;
      else
        others[packing.cells.size()] = cell.vertices;
    }
    packing.cells.push_back({species, shape, placementOf(lineOf(cell))});
    packing.poses.push_back(cell.pose);
  }
  packing.cellCount = problem->ranks.sum(std::int64_t(state.cells.size()));
  auto with = std::make_shared<Problem>(*problem);
  auto read = std::make_shared<ReadLines>(*problem->read);
  read->add(state.cells);
  with->read = std::move(read);
  if (problem->ranks.any(!others.empty())) deform(packing.cells, others, with->shapes, problem->ranks);
  packing.problem = std::move(with);
  return packing;
}

}  // namespace

Prepared prepareInMemory(const Request& asked, const Communicator& ranks,
                         const std::function<bool()>& interrupted) {
  const InputRecord inputs;
  Session session(returnedToPython, {interrupted, {}}, ranks);
  return prepare(asked, session, ranks);
}

Packing packInMemory(const Request& asked, const Communicator& ranks, const Hooks& hooks) {
  const InputRecord inputs;
  Session session(returnedToPython, hooks, ranks);
  const auto [problem, output] = prepare(asked, session, ranks);
  const Request& request = problem->request;
  onFirstRank(ranks, [&, &outputs = output] { requireReplaceableState(request, outputs); });
  for (const std::string& line : headLines(*problem)) log::info(line);
  Packing packing = session.pack(problem, output);
  if (packing.state) {
    if (saveResult(packing))
      onFirstRank(ranks, [&] { removeCheckpoint(request, packing.output, session.stateSavedOnce()); });
    packing.state.reset();
  }
  logSummary(packing);
  return packing;
}

StateCells loadCells(const fs::path& file, const Communicator& ranks, const fs::path& original) {
  StateCells state = readStateCells(file, ranks);
  if (!state.record.origin.empty()) static_cast<void>(requestIn(state.record, file));  // refuses
  if (!state.certified)
    throw InputError(fmt::format(
        "{}: is the state of a packing that is not finished; packing can continue from it (restart)",
        file.string()));
  static_cast<void>(requestOfCells(state, original));  // refuses
  return state;
}

std::shared_ptr<const Request> requestOfCells(const StateCells& cells, const fs::path& file) {
  if (cells.record.request.empty()) return nullptr;
  return std::make_shared<const Request>(requestIn(cells.record, file));
}

Packing completePacking(const StateCells& cells, const fs::path& file, const Communicator& ranks) {
  const std::shared_ptr<const Request> asked = requestOfCells(cells, file);
  if (!asked) static_cast<void>(requestIn({}, file));  // refuses
  const auto [problem, output] = prepareInMemory(*asked, ranks);
  if (problem->request.isTiled())
    throw InputError(fmt::format("{}: the box of a packing that was repeated in it ({}) is not rebuilt",
                                 file.string(), named("tile")));
  const std::vector<int> kinds = findKinds(*problem, cells.species);
  for (std::size_t kind = 0; kind < cells.species.size(); ++kind) {
    const auto species = std::find(kinds.begin(), kinds.end(), int(kind)) - kinds.begin();
    if (species == std::ptrdiff_t(kinds.size()) ||
        problem->species[species].shape->mesh().vertices != cells.species[kind].mesh.vertices ||
        problem->species[species].shape->mesh().triangles != cells.species[kind].mesh.triangles)
      throw InputError(fmt::format("{}: its template of '{}' is not that of what was asked for",
                                   file.string(), cells.species[kind].name));
  }
  Packing packing = placeCells(cells, kinds, problem);
  packing.output = output;
  packing.packed = packing.problem->atDemanded;
  packing = withTally(std::move(packing));
  const Problem& with = *packing.problem;
  packing.certificate = examine(with, packing.cells);
  packing.kept = findKept(with, packing.cells, loadingOf(with, packing.cells));
  packing.deformations = deformationsOf(packing);
  return packing;
}

std::vector<StateCells::Kind> kindsOf(const Packing& packing) {
  std::vector<StateCells::Kind> kinds;
  for (std::size_t s = 0; s < packing.problem->species.size(); ++s) {
    const CellSpecies& species = packing.problem->species[s];
    kinds.push_back({species.name, species.shape->mesh(), packing.tally.counts[s]});
  }
  return kinds;
}

std::vector<int> findKinds(const Problem& problem, const std::vector<StateCells::Kind>& kinds) {
  std::vector<int> found;
  for (const CellSpecies& species : problem.species) {
    const auto kind = std::find_if(kinds.begin(), kinds.end(),
                                   [&](const StateCells::Kind& one) { return one.name == species.name; });
    found.push_back(kind == kinds.end() ? -1 : int(kind - kinds.begin()));
  }
  return found;
}

std::vector<PosLine> posLinesOf(const Packing& packing) {
  std::vector<PosLine> lines;
  for (const Pose& pose : packing.poses) lines.push_back(packing.problem->read->lineOf(pose));
  return lines;
}

std::vector<fs::path> writeCells(const Packing& packing, const fs::path& folder,
                                 const std::vector<fs::path>& others) {
  OutputRequest output;
  output.folder = folder;
  onFirstRank(packing.ranks(), [&] { requireWritableOutputs(*packing.problem, output, true, others); });
  std::vector<fs::path> files = writeCellFiles(packing, output, false);
  warnOfCellFiles(packing, folder);
  return files;
}

void writePosFiles(const fs::path& folder,
                   const std::vector<std::pair<std::string, std::vector<PosLine>>>& cells) {
  SharedFiles(Communicator()).makeFolder(folder);
  AtomicFiles files;
  for (const auto& [name, lines] : cells)
    files.add(folder / (name + ".pos"), formatPosHead(std::int64_t(lines.size())) + formatPosLines(lines));
  files.commit();
}

void savePacking(const Packing& packing, const fs::path& file) {
  const Communicator& ranks = packing.ranks();
  const CellMeasures own = measuresOf(packing);
  std::vector<BodyState> bodies;
  std::vector<std::int64_t> ids;
  std::int64_t id = ranks.sumBefore({std::int64_t(packing.poses.size())}).front();
  for (std::size_t part = 0, i = 0; part < packing.counts.size(); ++part)
    for (std::int64_t n = 0; n < packing.counts[part]; ++n, ++i, ++id) {
      bodies.push_back(stateOf(id, int(part), packing.cells[i].shape, packing.poses[i]));
      ids.push_back(id);
    }
  PackingState state = finalState(std::move(bodies), ranks);
  state.position.fewer = packing.outcome == Outcome::outOfReach;
  state.measures = IdShares(packing.cellCount, ranks).collect(ids, own);
  state.columns = deformationColumns(*packing.problem, packing.packed, state.cells);
  state.columns.push_back(angleColumn(state.cells, *packing.problem->read));
  writeState(file, packingProblemOf(*packing.problem, packing.packed),
             recordOf(*packing.problem->request.asked, file), state);
}

StateCells cellsOf(const Packing& packing, const std::vector<StateCells::Kind>& kinds) {
  const Problem& problem = *packing.problem;
  const std::vector<int> kindOf = findKinds(problem, kinds);
  StateCells state;
  state.species = kinds;
  state.box = problem.lumen.container->bounds();
  state.period = problem.lumen.container->period();
  for (std::size_t i = 0; i < packing.cells.size(); ++i) {
    const PlacedCell& placed = packing.cells[i];
    Cell& cell = state.cells.emplace_back();
    cell.species = kindOf[placed.species];
    cell.pose = packing.poses[i];
    cell.angles = problem.read->lineOf(cell.pose).angles;
    if (problem.isDeformed(placed)) cell.vertices = problem.shapes[placed.shape]->mesh().vertices;
  }
  return state;
}

StateCells gatherCells(const StateCells& own, const Communicator& ranks) {
  std::vector<std::int32_t> kinds;
  std::vector<Pose> poses;
  std::vector<Vec3> angles;
  std::vector<std::vector<Vec3>> vertices;
  for (const Cell& cell : own.cells) {
    kinds.push_back(cell.species);
    angles.push_back(cell.angles);
    poses.push_back(cell.pose);
    vertices.push_back(cell.vertices);
  }
  kinds = ranks.gatherAll(kinds);
  poses = ranks.gatherAll(poses);
  angles = ranks.gatherAll(angles);
  vertices = ranks.gatherRows(vertices);
  StateCells state;
  state.species = own.species;
  state.box = own.box;
  state.period = own.period;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    state.deformed = state.deformed || !vertices[i].empty();
    state.cells.push_back({std::int64_t(i), kinds[i], poses[i], std::move(vertices[i]), -1, angles[i]});
  }
  return state;
}

void saveCells(StateCells state, std::shared_ptr<const Container> lumen, const fs::path& file) {
  PackingProblem problem;
  problem.physics.container = std::move(lumen);
  for (StateCells::Kind& kind : state.species)
    problem.physics.add(kind.name, std::make_shared<const Shape>(std::move(kind.mesh)), kind.count);
  std::vector<BodyState> bodies;
  std::vector<std::vector<Vec3>> vertices;
  for (Cell& cell : state.cells) {
    bodies.push_back(stateOf(cell.id, cell.species, cell.species, cell.pose));
    vertices.push_back(std::move(cell.vertices));
  }
  PackingState final = finalState(std::move(bodies), Communicator(), std::move(vertices));
  final.columns = {angleColumn(final.cells, {})};
  writeState(file, problem, state.record, final);
}

std::vector<CellColumn> columnsOf(const Packing& packing) {
  std::vector<CellColumn> columns = packmesh::columnsOf(measuresOf(packing), packing.cells.size());
  for (CellColumn& column : deformationColumns(*packing.problem, packing.cells))
    columns.push_back(std::move(column));
  return columns;
}

}  // namespace packmesh::hemocell
