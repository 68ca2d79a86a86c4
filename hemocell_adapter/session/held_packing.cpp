// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/held_packing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/requested_outputs.h"
#include "hemocell_adapter/output/shared_files.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/state_request.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/session/examination.h"
#include "packMesh/analysis/share_measures.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/timer.h"
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

/// The cells of a loaded packing get their shapes: those of the problem where the state names one with the
/// same vertices, as that of a packing does. All ranks call. @return the problem with the others
std::shared_ptr<const Problem> takeMeshes(HeldPacking& held, std::shared_ptr<const Problem> problem) {
  std::vector<PlacedCell>& cells = held.packing.result.cells;
  std::map<std::size_t, std::vector<Vec3>> others;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto own = held.own.find(i);
    const std::size_t named = std::exchange(cells[i].shape, cells[i].species);
    if (own == held.own.end()) continue;
    if (named < problem->shapes.size() && problem->shapes[named]->mesh().vertices == own->second)
      cells[i].shape = int(named);
    else
      others.insert(held.own.extract(own));
  }
  held.own.clear();
  if (!held.ranks.any(!others.empty())) return problem;
  auto with = std::make_shared<Problem>(*problem);
  deform(cells, others, with->shapes, held.ranks);
  return with;
}

}  // namespace

Prepared prepareInMemory(const Request& asked, const Communicator& ranks,
                         const std::function<bool()>& interrupted) {
  const InputRecord inputs;
  Session session(returnedToPython, {interrupted, {}}, ranks);
  return prepare(asked, session, ranks);
}

HeldPacking packInMemory(const Request& asked, const Communicator& ranks, const Hooks& hooks) {
  const InputRecord inputs;
  Session session(returnedToPython, hooks, ranks);
  const Prepared prepared = prepare(asked, session, ranks);
  const std::shared_ptr<const Problem>& problem = prepared.problem;
  onFirstRank(ranks, [&] { requireReplaceableState(problem->request, prepared.output); });
  for (const std::string& line : headLines(*problem)) log::info(line);
  HeldPacking held;
  held.ranks = ranks;
  held.asked = problem->request.asked;
  held.box = problem->lumen.container->bounds();
  held.period = problem->lumen.container->period();
  held.output = prepared.output;
  held.packing = session.pack(problem, held.output);
  if (const auto state = resultStateOf(held.packing)) {
    if (saveResult(*held.packing.problem, held.output, *state))
      onFirstRank(ranks, [&] {
        removeCheckpoint(held.packing.problem->request, held.output, session.stateSavedOnce());
      });
    held.packing.state.reset();
  }
  for (std::size_t s = 0; s < held.packing.problem->species.size(); ++s) {
    const CellSpecies& species = held.packing.problem->species[s];
    held.kinds.push_back({species.name, species.shape->mesh(), held.packing.cells.tally.counts[s]});
    held.kindOf.push_back(int(s));
  }
  logSummary(held.packing);
  return held;
}

HeldPacking loadPacking(const fs::path& file, const Communicator& ranks, const fs::path& original) {
  StateCells state = readStateCells(file, ranks);
  if (!state.record.origin.empty()) static_cast<void>(requestIn(state.record, file));  // refuses
  if (!state.certified)
    throw InputError(fmt::format(
        "{}: is the state of a packing that is not finished; packing can continue from it (restart)",
        file.string()));
  HeldPacking held;
  held.ranks = ranks;
  held.file = original.empty() ? file : original;
  if (!state.record.request.empty())
    held.asked = std::make_shared<const Request>(requestIn(state.record, held.file));
  held.box = state.box;
  held.period = state.period;
  held.kinds = state.species;
  held.kindOf.resize(held.kinds.size());
  std::iota(held.kindOf.begin(), held.kindOf.end(), 0);
  for (Cell& cell : state.cells) {
    held.packing.result.poses.push_back(cell.pose);
    if (!cell.vertices.empty()) held.own[held.packing.result.cells.size()] = std::move(cell.vertices);
    held.packing.result.cells.push_back({cell.species, cell.shape, placementOf(posLineOf(cell.pose))});
  }
  held.packing.result.cellCount = ranks.sum(std::int64_t(state.cells.size()));
  return held;
}

HeldPacking completed(HeldPacking held) {
  if (!held.asked) static_cast<void>(requestIn({}, held.file));  // refuses
  Prepared prepared = prepareInMemory(*held.asked, held.ranks);
  std::shared_ptr<const Problem> problem = std::move(prepared.problem);
  held.output = std::move(prepared.output);
  if (problem->request.isTiled())
    throw InputError(fmt::format("{}: the box of a packing that was repeated in it ({}) is not rebuilt",
                                 held.file.string(), named("tile")));
  std::vector<int> speciesOf;
  for (const StateCells::Kind& kind : held.kinds) {
    const auto& all = problem->species;
    const auto species = std::find_if(all.begin(), all.end(), [&](const CellSpecies& s) {
      return s.name == kind.name && s.shape->mesh().vertices == kind.mesh.vertices &&
             s.shape->mesh().triangles == kind.mesh.triangles;
    });
    if (species == all.end())
      throw InputError(fmt::format("{}: its template of '{}' is not that of what was asked for",
                                   held.file.string(), kind.name));
    speciesOf.push_back(int(species - all.begin()));
  }
  Packing& packing = held.packing;
  PackingResult& result = packing.result;
  for (PlacedCell& cell : result.cells) cell.species = speciesOf[cell.species];
  problem = takeMeshes(held, std::move(problem));
  held.kindOf.assign(problem->species.size(), -1);
  for (std::size_t kind = 0; kind < speciesOf.size(); ++kind) held.kindOf[speciesOf[kind]] = int(kind);
  for (std::size_t i = 0; i < result.cells.size(); ++i)
    result.cells[i].placement = placementOf(problem->read->lineOf(result.poses[i]));
  result.certificate = examine(*problem, result.cells, loadingOf(*problem, result.cells)).certificate;
  std::vector<std::int64_t> counts = countsOf(*problem, result.cells);
  held.ranks.sum(counts);
  packing.cells.tally = tallyOf(*problem, std::move(counts), excessVolumes(*problem, result.cells));
  packing.kept = keptOf(*problem, result.cells);
  packing.packed = problem->atDemanded;
  packing.problem = problem;
  return held;
}

const std::vector<Vec3>* ownVertices(const HeldPacking& held, std::size_t cell) {
  if (const Problem* const problem = held.packing.problem.get()) {
    const PlacedCell& placed = held.packing.result.cells[cell];
    return problem->isDeformed(placed) ? &problem->shapes[placed.shape]->mesh().vertices : nullptr;
  }
  const auto own = held.own.find(cell);
  return own == held.own.end() ? nullptr : &own->second;
}

std::vector<PosLine> posLinesOf(const HeldPacking& held) {
  const Packing& packing = held.packing;
  std::vector<PosLine> lines;
  for (const Pose& pose : packing.result.poses)
    lines.push_back(packing.problem ? packing.problem->read->lineOf(pose) : posLineOf(pose));
  return lines;
}

std::vector<fs::path> writeCells(const HeldPacking& held, const fs::path& folder,
                                 const std::vector<fs::path>& others) {
  const Packing& packing = held.packing;
  OutputRequest output;
  output.folder = folder;
  onFirstRank(held.ranks, [&] { requireWritableOutputs(*packing.problem, output, true, others); });
  return writeCellFiles(*packing.problem, output, packing.result, packing.cells.tally.counts);
}

void writePosFiles(const fs::path& folder,
                   const std::vector<std::pair<std::string, std::vector<PosLine>>>& cells) {
  SharedFiles(Communicator()).makeFolder(folder);
  AtomicFiles files;
  for (const auto& [name, lines] : cells)
    files.add(folder / (name + ".pos"), formatPosHead(std::int64_t(lines.size())) + formatPosLines(lines));
  files.commit();
}

void savePacking(const HeldPacking& held, const fs::path& file) {
  const Packing& packing = held.packing;
  const Communicator& ranks = held.ranks;
  const PackingResult& result = packing.result;
  if (result.counts.empty())
    throw InputError(fmt::format("the packing was loaded from {}: copy that file", held.file.string()));
  PackingState state;
  state.position.stage = Stage::certificate;
  state.position.fewer = result.outcome == Outcome::outOfReach;
  state.cellCount = result.cellCount;
  const CellMeasures own = measuresOf(finishedOf(packing, {}));
  std::vector<BodyState> bodies;
  std::vector<std::int64_t> ids;
  std::int64_t id = ranks.sumBefore({std::int64_t(result.poses.size())}).front();
  for (std::size_t part = 0, i = 0; part < result.counts.size(); ++part)
    for (std::int64_t n = 0; n < result.counts[part]; ++n, ++i, ++id) {
      bodies.push_back(stateOf(id, int(part), result.cells[i].shape, result.poses[i]));
      ids.push_back(id);
    }
  const IdShares shares(result.cellCount, ranks);
  state.cells = shares.collect(std::move(bodies));
  state.measures = shares.collect(ids, own);
  writeState(file, packingProblemOf(*packing.problem, packing.packed), recordOf(*held.asked, file), state);
}

StateCells stateCellsOf(const HeldPacking& held) {
  const PackingResult& result = held.packing.result;
  struct Row {
    std::int32_t kind;
    std::int32_t vertices;  ///< their number
    Pose pose;
  };
  std::vector<Row> rows;
  std::vector<Vec3> vertices;
  for (std::size_t i = 0; i < result.cells.size(); ++i) {
    const std::vector<Vec3>* const own = ownVertices(held, i);
    rows.push_back({std::int32_t(held.kindOf[result.cells[i].species]), own ? std::int32_t(own->size()) : 0,
                    result.poses[i]});
    if (own) vertices.insert(vertices.end(), own->begin(), own->end());
  }
  rows = held.ranks.gatherAll(rows);
  vertices = held.ranks.gatherAll(vertices);
  StateCells state;
  state.species = held.kinds;
  state.box = held.box;
  state.period = held.period;
  auto next = vertices.cbegin();
  for (const Row& row : rows) {
    Cell cell{std::int64_t(state.cells.size()), row.kind, row.pose};
    cell.vertices.assign(next, next + row.vertices);
    next += row.vertices;
    state.deformed = state.deformed || row.vertices > 0;
    state.cells.push_back(std::move(cell));
  }
  return state;
}

void saveCells(StateCells state, std::shared_ptr<const Container> lumen, const fs::path& file) {
  PackingProblem problem;
  problem.physics.container = std::move(lumen);
  for (StateCells::Kind& kind : state.species)
    problem.physics.add(kind.name, std::make_shared<const Shape>(std::move(kind.mesh)), kind.count);
  PackingState saved;
  saved.position.stage = Stage::certificate;
  saved.cellCount = std::int64_t(state.cells.size());
  for (Cell& cell : state.cells) {
    saved.cells.push_back(makeBody(cell.id, cell.species, cell.species, cell.pose));
    saved.vertices.push_back(std::move(cell.vertices));
  }
  writeState(file, problem, state.record, saved);
}

std::vector<CellColumn> columnsOf(const HeldPacking& held) {
  return packmesh::columnsOf(measuresOf(finishedOf(held.packing, {})), held.packing.result.cells.size());
}

std::string reportOf(const HeldPacking& held) {
  return reportText(finishedOf(held.packing, held.output), held.packing.times);
}

void saveTables(const HeldPacking& held, const fs::path& file) {
  SharedFiles(held.ranks).makeFolder(file.parent_path());
  saveTables(finishedOf(held.packing, {}), file);
}

}  // namespace packmesh::hemocell
