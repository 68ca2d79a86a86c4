// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/fill.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/session/session.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/input_record.h"
#include "packMesh/core/timer.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/state_cells.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

using SharedCase = std::shared_ptr<const Case>;

CompletedRequest requestFor(SharedCase simulation, const std::vector<std::string>& words) {
  std::vector<std::string> all = {simulation->file.string()};
  all.insert(all.end(), words.begin(), words.end());
  CompletedRequest completed = requestToPack(parseCommandLine("packMesh", all), std::move(simulation));
  if (!completed.request.states("output-dir")) completed.request.output.exports.clear();
  return completed;
}

/// Numbers cells as HemoCell numbers those of .pos files. Pre: sorted by type, those of lower ranks before
Filling numbered(std::vector<AddedCell> cells, std::size_t types, const Communicator& ranks) {
  Filling filling;
  filling.counts.assign(types, 0);
  for (const AddedCell& cell : cells) ++filling.counts[cell.type];
  std::vector<std::int64_t> next = ranks.sumBefore(filling.counts);
  ranks.sum(filling.counts);
  std::int64_t first = 0;  // of the type
  for (std::size_t t = 0; t < types; ++t) {
    next[t] += first;
    first += filling.counts[t];
  }
  for (AddedCell& cell : cells) cell.id = next[cell.type]++;
  filling.cells = std::move(cells);
  return filling;
}

Filling numbered(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const std::vector<BuiltCell>& types = problem.running()->cells;
  std::vector<AddedCell> cells;
  cells.reserve(packing.result.cells.size());
  for (const PlacedCell& cell : packing.result.cells) {
    const int species = problem.speciesOf(cell.species);
    const BuiltCell* type = problem.running()->cell(problem.species[species].name);
    cells.push_back({static_cast<std::int32_t>(type - types.data()), 0, cell.placement});
    if (cell.species != species) cells.back().vertices = problem.shapeOf(cell.species).mesh().vertices;
  }
  return numbered(std::move(cells), types.size(), problem.ranks);
}

/// The case with a `<packing>` that asks for these cells of each type and nothing else.
/// @param start state with the cells to start from, or nothing
SharedCase withCounts(const SharedCase& simulation, const std::vector<std::int64_t>& counts,
                      const std::filesystem::path& start = {}) {
  auto copy = std::make_shared<Case>(*simulation);
  copy->packing = {};
  const std::vector<BuiltCell>& types = simulation->running->cells;
  for (std::size_t t = 0; t < counts.size(); ++t)
    if (counts[t] > 0) speciesNamed(copy->packing, types[t].name).count = counts[t];
  if (!start.empty()) copy->packing.startStates.push_back(start);
  return copy;
}

/// Packs, and writes what is requested.
Filling filled(const CompletedRequest& completed, Session& session, const Communicator& ranks) {
  const std::shared_ptr<const Problem> problem = session.problemOf(completed);
  const OutputRequest& output = completed.request.output;
  const bool withFiles = completed.request.states("output-dir");
  onFirstRank(ranks, [&] { requireWritableOutputs(*problem, output, withFiles); });
  for (const std::string& line : headLines(*problem)) log::info(line);
  const Packing packing = session.pack(problem);
  logSummary(packing);
  if (withFiles)
    for (const auto& file : writeCellFiles(*problem, output, packing.result, packing.cells.tally.counts))
      log::info(fmt::format("Wrote {}", file.string()));
  asFinished(packing, output, [&](const Finished& done) { writeViews(done, packing.times); });
  return numbered(packing);
}

}  // namespace

Filling fill(std::shared_ptr<const Case> simulation, const std::vector<std::string>& words,
             const Communicator& ranks) {
  const InputRecord inputs;
  Session session(addedToHemocell, {}, ranks);
  CompletedRequest completed;
  together(ranks, [&] { completed = requestFor(std::move(simulation), words); });
  return filled(completed, session, ranks);
}

namespace {

/// Whether HemoCell builds the same template, up to rounding.
bool isBuiltAlike(const TriangleMesh& mesh, const TriangleMesh& built) {
  constexpr double rounding = 1e-6;  // of templates built alike [µm]
  if (mesh.vertices.size() != built.vertices.size()) return false;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if ((mesh.vertices[i] - built.vertices[i]).cwiseAbs().maxCoeff() >= rounding) return false;
  return true;
}

struct StateTypes {
  std::vector<std::int32_t> types;  ///< of each kind of cell
  std::string other;  ///< a kind whose template HemoCell builds differently; empty if there is none
};

/// Whether all cells have meshes of their own. All ranks call.
bool areDeformed(const StateCells& state, const Communicator& ranks) {
  return !state.species.empty() &&
         !ranks.any(std::any_of(state.cells.begin(), state.cells.end(),
                                [](const StateCell& cell) { return cell.vertices.empty(); }));
}

/// The type of each kind of cell of a state. @throws InputError if HemoCell has no such type
StateTypes typesOf(const StateCells& state, const RunningSystem& running, const std::string& file) {
  StateTypes result;
  for (const StateCells::Kind& kind : state.species) {
    const BuiltCell* built = running.cell(kind.name);
    if (!built)
      throw InputError(fmt::format("{}: has cells of type '{}', the case has none", file, kind.name));
    if (!isBuiltAlike(kind.mesh, built->mesh)) result.other = kind.name;
    result.types.push_back(static_cast<std::int32_t>(built - running.cells.data()));
  }
  return result;
}

/// Cells of which HemoCell would delete a rigid one; of cells of a run, which may come nearer to the wall,
/// those with their centres outside. @throws InputError
void requireKept(const Problem& problem, const StateCells& state, const std::vector<AddedCell>& cells,
                 const std::string& file) {
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::size_t s = 0; s < problem.species.size(); ++s) {
      const CellSpecies& species = problem.species[s];
      if (species.name != state.species[state.cells[i].species].name) continue;
      if (!cells[i].vertices.empty()) {
        const Wall* const lumen = problem.lumen.container->wall();
        const Vec3& center = cells[i].placement.translation;
        if (lumen && !(lumen->distance(center).distance > -problem.request.dx))
          throw InputError(
              fmt::format("{}: a cell '{}' at ({:.6g}, {:.6g}, {:.6g}) µm is outside of the fluid: is this a "
                          "state of the same case?",
                          file, species.name, center[0], center[1], center[2]));
        continue;
      }
      const auto& own = problem.atDemanded.walls[s];
      const Wall* wall = own ? own.get() : problem.lumen.container->wall();
      if (!wall) continue;
      if (const auto violation =
              wall->examine({species.shape->hierarchy(), cells[i].placement}, 0.0).violation)
        throw InputError(fmt::format(
            "{}: a cell '{}' at ({:.6g}, {:.6g}, {:.6g}) µm {}: is this a state of the same case?", file,
            species.name, cells[i].placement.translation[0], cells[i].placement.translation[1],
            cells[i].placement.translation[2], *violation));
    }
}

}  // namespace

Filling fillFromState(std::shared_ptr<const Case> simulation, const std::filesystem::path& file,
                      const Communicator& ranks) {
  const Timer timer;
  const RunningSystem& running = *simulation->running;
  const StateCells state = readStateCells(file, ranks);
  StateTypes found;
  together(ranks, [&] { found = typesOf(state, running, file.string()); });
  const std::vector<std::int32_t>& types = found.types;
  std::vector<std::int64_t> counts(running.cells.size(), 0);
  for (std::size_t s = 0; s < types.size(); ++s) counts[types[s]] = state.species[s].count;
  const bool deformed = areDeformed(state, ranks);
  together(ranks, [&] {
    for (const StateCell& cell : state.cells)
      if (!cell.vertices.empty() &&
          state.species[cell.species].mesh.triangles != running.cells[types[cell.species]].mesh.triangles)
        throw InputError(fmt::format(
            "{}: its cells '{}' have meshes of their own whose triangles are not those of HemoCell's",
            file.string(), state.species[cell.species].name));
  });
  if (!deformed && (!state.certified || !found.other.empty())) {
    const std::string reason =
        state.certified
            ? fmt::format("HemoCell builds another template of '{}', as at another lattice spacing",
                          found.other)
            : fmt::format("the cells are not those of a finished packing ({})",
                          fmt::join(state.command, " "));
    log::info(fmt::format("{}: {}; packing starts from them", file.string(), reason));
    const InputRecord inputs;
    Session session(addedToHemocell, {}, ranks);
    CompletedRequest completed;
    together(ranks, [&] { completed = requestFor(withCounts(simulation, counts, file), {}); });
    return filled(completed, session, ranks);
  }
  std::vector<AddedCell> cells;
  for (const StateCell& cell : state.cells)
    cells.push_back({types[cell.species], 0, placementOf(posLineOf(cell.pose)), cell.vertices});
  together(ranks, [&] {
    CompletedRequest completed = requestFor(withCounts(simulation, counts), {});
    completed.request.bestEffort = true;  // the cells are there: however dense
    completed.request.clearance = completed.request.wallClearance = 0.0;
    requireKept(problemToPack(completed), state, cells, file.string());
  });
  Filling filling = numbered(std::move(cells), running.cells.size(), ranks);
  for (std::size_t t = 0; t < counts.size(); ++t)
    log::info(fmt::format("{}: {} cells of {}", running.cells[t].name, counts[t], file.string()));
  log::info(fmt::format("Time: {:.3f} s CPU, {:.3f} s wall", timer.cpu(), timer.wall()));
  return filling;
}

namespace {

/// Number of a cell in a state before cells are counted, of type and number in HemoCell.
std::int64_t idOf(const MovedCell& cell, std::int64_t numbers) {
  return cell.type * numbers + cell.id;
}

/// The vertices of this rank's share of the cells of a state. All ranks call.
/// @param numbers of cells in HemoCell @param ids of a state before cells are counted @param count of all
/// cells
std::vector<std::vector<Vec3>> verticesInOrder(const std::vector<MovedCell>& cells, std::int64_t numbers,
                                               std::int64_t ids, std::int64_t count,
                                               const Communicator& ranks) {
  struct Origin {
    std::int64_t id;
    int rank, index;
  };
  std::vector<Origin> order;
  for (std::size_t i = 0; i < cells.size(); ++i)
    order.push_back({idOf(cells[i], numbers), ranks.rank(), int(i)});
  const auto byId = [](const Origin& a, const Origin& b) { return a.id < b.id; };
  std::sort(order.begin(), order.end(), byId);
  order = IdShares(ids, ranks).collect(order);
  std::int64_t next = ranks.sumBefore({std::int64_t(order.size())}).front();
  for (Origin& one : order) one.id = next++;
  order = IdShares(count, ranks).collect(order);
  std::vector<std::vector<int>> asked(ranks.size());
  for (const Origin& one : order) asked[one.rank].push_back(one.index);
  std::vector<std::vector<double>> sent(ranks.size());
  const std::vector<std::vector<int>> asking = ranks.exchange(asked);
  for (int rank = 0; rank < ranks.size(); ++rank)
    for (const int index : asking[rank]) {
      const std::vector<Vec3>& vertices = cells[index].vertices;
      sent[rank].push_back(double(vertices.size()));
      for (const Vec3& v : vertices) sent[rank].insert(sent[rank].end(), v.data(), v.data() + 3);
    }
  const std::vector<std::vector<double>> received = ranks.exchange(sent);
  std::vector<std::size_t> at(ranks.size(), 0);
  std::vector<std::vector<Vec3>> ordered;
  for (const Origin& one : order) {
    const std::vector<double>& from = received[one.rank];
    std::size_t& place = at[one.rank];
    std::vector<Vec3>& vertices = ordered.emplace_back(std::size_t(from[place++]));
    for (Vec3& v : vertices) {
      v = Vec3(from[place], from[place + 1], from[place + 2]);
      place += 3;
    }
  }
  return ordered;
}

}  // namespace

void saveCells(std::shared_ptr<const Case> simulation, const std::vector<MovedCell>& cells,
               std::int64_t iteration, const std::filesystem::path& file, const Communicator& ranks) {
  const RunningSystem& running = *simulation->running;
  std::vector<std::int64_t> counts(running.cells.size(), 0);
  std::int64_t cellCount = 0;
  double largest = 0.0, highest = 0.0;  // residual, number in HemoCell
  for (const MovedCell& cell : cells) {
    ++counts[cell.type];
    largest = std::max(largest, cell.residual);
    highest = std::max(highest, static_cast<double>(cell.id));
  }
  ranks.sum(counts);
  for (const std::int64_t count : counts) cellCount += count;
  largest = ranks.max(largest);
  const std::int64_t numbers = static_cast<std::int64_t>(ranks.max(highest)) + 1;
  std::optional<Problem> problem;
  together(ranks, [&] {
    CompletedRequest completed = requestFor(withCounts(simulation, counts), {});
    completed.request.bestEffort = true;  // the cells are there: however dense
    problem = problemToPack(completed, ranks);
  });
  const PackingProblem packing = packingProblemOf(*problem, problem->atDemanded);
  std::vector<std::int32_t> partOf(counts.size(), 0);
  const std::vector<Part>& parts = problem->atDemanded.parts;
  for (std::size_t p = 0; p < parts.size(); ++p)
    partOf[running.cell(problem->species[parts[p].species].name) - running.cells.data()] = std::int32_t(p);
  PackingState state;
  state.position.stage = Stage::certificate;
  state.cellCount = cellCount;
  std::vector<BodyState> bodies;
  for (const MovedCell& cell : cells) {
    BodyState body{};
    for (int k = 0; k < 3; ++k) body.pose.position[k] = cell.pose.position[k];
    for (int k = 0; k < 4; ++k) body.pose.orientation[k] = cell.pose.orientation.coeffs()[k];
    body.scale = body.stepTaken = 1.0;
    body.species = partOf[cell.type];
    body.id = idOf(cell, numbers);
    bodies.push_back(body);
  }
  std::sort(bodies.begin(), bodies.end(), [](const BodyState& a, const BodyState& b) { return a.id < b.id; });
  const std::int64_t ids = static_cast<std::int64_t>(counts.size()) * numbers;
  bodies = IdShares(ids, ranks).collect(bodies);
  std::int64_t next = ranks.sumBefore({static_cast<std::int64_t>(bodies.size())}).front();
  for (BodyState& body : bodies) body.id = next++;
  state.cells = IdShares(cellCount, ranks).collect(bodies);
  const bool deformed = ranks.any(
      std::any_of(cells.begin(), cells.end(), [](const MovedCell& cell) { return !cell.vertices.empty(); }));
  if (deformed) state.vertices = verticesInOrder(cells, numbers, ids, cellCount, ranks);
  const std::string origin =
      deformed ? fmt::format("iteration {}, cells as they were", iteration)
               : fmt::format("iteration {}, rigid fits with residuals up to {:.4f} µm", iteration, largest);
  writeState(file, packing, {"savePositions", origin}, state);
  std::string names;
  for (std::size_t t = 0; t < counts.size(); ++t)
    names += fmt::format("{}{} {}", t ? ", " : "", counts[t], running.cells[t].name);
  log::info(fmt::format("Wrote {}: {}; {}", file.string(), names, origin));
}

}  // namespace packmesh::hemocell
