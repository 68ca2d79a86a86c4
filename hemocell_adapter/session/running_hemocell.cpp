// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/session/running_hemocell.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/cell_files.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/session/examination.h"
#include "hemocell_adapter/session/session.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/timer.h"
#include "packMesh/mesh/self_intersection.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

using SharedCase = std::shared_ptr<const Case>;

/// Numbers cells as HemoCell numbers those of .pos files. Pre: sorted by type, those of lower ranks before
CellsToAdd numbered(CellsToAdd filling, std::size_t types, const Communicator& ranks) {
  filling.counts.assign(types, 0);
  for (const Cell& cell : filling.cells) ++filling.counts[cell.species];
  std::vector<std::int64_t> next = ranks.sumBefore(filling.counts);
  ranks.sum(filling.counts);
  std::int64_t first = 0;  // of the type
  for (std::size_t t = 0; t < types; ++t) {
    next[t] += first;
    first += filling.counts[t];
  }
  for (Cell& cell : filling.cells) cell.id = next[cell.species]++;
  return filling;
}

CellsToAdd numbered(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const std::vector<BuiltCell>& types = problem.running()->cells;
  CellsToAdd filling;
  for (std::size_t i = 0; i < packing.cells.size(); ++i) {
    const PlacedCell& cell = packing.cells[i];
    const BuiltCell* type = problem.running()->cell(problem.species[cell.species].name);
    filling.placements.push_back(cell.placement);
    filling.cells.push_back({0, static_cast<std::int32_t>(type - types.data()), packing.poses[i]});
    if (problem.isDeformed(cell)) filling.cells.back().vertices = problem.shapes[cell.shape]->mesh().vertices;
  }
  return numbered(std::move(filling), types.size(), problem.ranks);
}

/// A request of these cells of each type and nothing else. @param start state with the cells to start from
Request requestOf(const std::vector<BuiltCell>& types, const std::vector<std::int64_t>& counts,
                  const std::filesystem::path& start = {}) {
  Request request;
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (counts[t] == 0) continue;
    speciesNamed(request, types[t].name).count = counts[t];
    request.origins[keyOfSpecies(types[t].name, "count")] = {Origin::Kind::member, ""};
  }
  if (start.empty()) return request;
  request.startStates.push_back(start);
  request.origins["start"] = {Origin::Kind::member, ""};
  return request;
}

/// The case, whatever its `<packing>` asks for.
SharedCase withoutSection(const SharedCase& simulation) {
  auto copy = std::make_shared<Case>(*simulation);
  copy->packing = {};
  return copy;
}

/// Packs, and writes what is requested.
CellsToAdd packAndWrite(const CompletedRequest& completed, const OutputRequest& output, Session& session,
                        const Communicator& ranks) {
  const std::shared_ptr<const Problem> problem = session.prepare(completed);
  const bool withFiles = completed.request.states("outputDirectory");
  onFirstRank(ranks, [&] { requireWritableOutputs(*problem, output, withFiles); });
  for (const std::string& line : headLines(*problem)) log::info(line);
  const Packing packing = session.pack(problem, output);
  logSummary(packing);
  bool saved = packing.state.has_value();
  if (withFiles)
    for (const auto& file : writeCellFiles(packing, output, saved))
      log::info(fmt::format("Wrote {}", file.string()));
  else if (saved)
    saved = saveResult(packing);
  if (saved)
    onFirstRank(ranks, [&] { removeCheckpoint(completed.request, output, session.stateSavedOnce()); });
  writeViews(packing);
  return numbered(packing);
}

}  // namespace

CellsToAdd fill(std::shared_ptr<const Case> simulation, const Request& asked, const Communicator& ranks) {
  const InputRecord inputs;
  Session session(addedToHemocell, {}, ranks);
  CompletedRequest completed;
  OutputRequest output;
  together(ranks, [&] {
    completed = requestToPack(asked, std::move(simulation));
    output = outputsInRunning(completed);
  });
  return packAndWrite(completed, output, session, ranks);
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
                                [](const Cell& cell) { return cell.vertices.empty(); }));
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

/// @throws InputError if cells have meshes of their own with other triangles
void requireTriangles(const StateCells& state, const std::vector<std::int32_t>& types,
                      const RunningSystem& running, const std::string& file) {
  for (const Cell& cell : state.cells)
    if (!cell.vertices.empty() &&
        state.species[cell.species].mesh.triangles != running.cells[types[cell.species]].mesh.triangles)
      throw InputError(fmt::format(
          "{}: its cells '{}' have meshes of their own whose triangles are not those of HemoCell's", file,
          state.species[cell.species].name));
}

/// A request that leaves cells where they are as far as they do not overlap.
CompletedRequest withoutClearance(CompletedRequest completed) {
  completed.request.clearance = completed.request.wallClearance = 0.0;
  return completed;
}

/// Whether the cells are those of a finished packing in this lumen, so that no two of them overlap.
bool isCertifiedIn(const Container& lumen, const StateCells& state) {
  const Box bounds = lumen.bounds();
  return state.certified && state.period == lumen.period() && state.box.lo == bounds.lo &&
         state.box.hi == bounds.hi;
}

/// Warns of .pos files that HemoCell's own loader would read instead of the state, and that are of another
/// run.
void warnOfOtherFiles(const std::filesystem::path& state) {
  const std::vector<std::string> other = filesOfState(state).other;
  if (!other.empty())
    log::warning(fmt::format("{}: {} beside it {} not written together with it, and not loaded",
                             state.string(), fmt::join(other, " and "), other.size() == 1 ? "was" : "were"));
}

/// Why HemoCell would delete a cell of a state at once, or why a rigid one is not inside the lumen; nothing
/// if it is kept. Deformed cells of a run may be outside the surface of the wall, and nearer to it than
/// HemoCell's loader accepts.
std::optional<std::string> violationOf(const Problem& problem, int s, const Cell& cell,
                                       const Placement& placement) {
  const CellSpecies& species = problem.species[s];
  if (!cell.vertices.empty()) {
    std::vector<Vec3> vertices;
    for (const Vec3& v : cell.vertices) vertices.push_back(placement(v));
    return species.acceptance->violation(vertices, {problem.running()->periodic, true});
  }
  const auto& own = problem.atDemanded.walls[s];
  const Wall* const wall = own ? own.get() : problem.lumen.container->wall();
  if (!wall) return {};
  return wall->examine({species.shape->hierarchy(), placement}, 0.0).violation;
}

/// This rank's cells of a state that HemoCell would delete: index, and "RBC 3 at (1, 2, 3) µm: a vertex lies
/// on a wall node".
std::vector<std::pair<std::size_t, std::string>> unkeptCells(const Problem& problem, const StateCells& state,
                                                             const std::vector<Placement>& placements) {
  std::vector<int> speciesOf;
  std::vector<std::int64_t> firstOf(1, 0);  // cell of each kind in the file
  for (const StateCells::Kind& kind : state.species) {
    const auto same = [&](const CellSpecies& species) { return species.name == kind.name; };
    const auto& all = problem.species;
    speciesOf.push_back(int(std::find_if(all.begin(), all.end(), same) - all.begin()));
    firstOf.push_back(firstOf.back() + kind.count);
  }
  std::vector<std::pair<std::size_t, std::string>> unkept;
  for (std::size_t i = 0; i < placements.size(); ++i) {
    const Cell& cell = state.cells[i];
    const Vec3& at = placements[i].translation;
    if (const auto violation = violationOf(problem, speciesOf[cell.species], cell, placements[i]))
      unkept.emplace_back(
          i, fmt::format("{} {} at ({:.6g}, {:.6g}, {:.6g}) µm: {}", state.species[cell.species].name,
                         cell.id - firstOf[cell.species] + 1, at[0], at[1], at[2], *violation));
  }
  return unkept;
}

/// "HemoCell would delete 63 of its 96 cells: RBC 3 at ...; ... and 60 more". Empty if there are none. All
/// ranks call. @param own lines of this rank's cells
std::string unkeptText(const std::vector<std::pair<std::size_t, std::string>>& own, std::int64_t cells,
                       const Communicator& ranks) {
  constexpr std::size_t shown = 5;
  const std::int64_t count = ranks.sum(std::int64_t(own.size()));
  if (count == 0) return {};
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < std::min(shown, own.size()); ++i) lines.push_back(own[i].second);
  lines = ranks.gatherRows(lines);
  std::string text = fmt::format("HemoCell would delete {} of its {} cells", count, cells);
  for (std::size_t i = 0; i < std::min(shown, lines.size()); ++i) text += (i ? "; " : ": ") + lines[i];
  if (count > std::int64_t(shown)) text += fmt::format("; and {} more", count - std::int64_t(shown));
  return text;
}

/// Removes the cells that HemoCell would delete from a state and its filling, with a warning. All ranks call.
/// @param unkept of this rank, see unkeptCells()
/// @throws InputError if there are any and they are not to be left out
void leaveOutUnkept(const std::vector<std::pair<std::size_t, std::string>>& unkept, StateCells& state,
                    CellsToAdd& filling, bool leavesOut, const std::string& file, const Communicator& ranks) {
  const std::string text = unkeptText(unkept, ranks.sum(std::int64_t(state.cells.size())), ranks);
  if (text.empty()) return;
  together(ranks, [&] {
    if (!leavesOut)
      throw InputError(
          fmt::format("{}: {}. Is this a state of the same case? packmesh::Unkept::leaveOut, after the name "
                      "of the file, adds the others",
                      file, text));
  });
  log::warning(fmt::format("{}: {}; they are left out", file, text));
  for (auto cell = unkept.rbegin(); cell != unkept.rend(); ++cell) {
    state.cells.erase(state.cells.begin() + std::ptrdiff_t(cell->first));
    filling.placements.erase(filling.placements.begin() + std::ptrdiff_t(cell->first));
  }
}

/// Warns of cells of a run that intersect themselves.
void tellSelfIntersecting(const StateCells& state, const std::vector<Placement>& placements,
                          const std::string& file, const Communicator& ranks) {
  if (!state.deformed) return;
  for (std::size_t s = 0; s < state.species.size(); ++s) {
    const SelfIntersectionFinder finder(state.species[s].mesh);
    std::vector<std::array<double, 3>> found;
    for (std::size_t i = 0; i < state.cells.size(); ++i) {
      const Cell& cell = state.cells[i];
      if (cell.species != int(s) || cell.vertices.empty()) continue;
      std::vector<Vec3> vertices = cell.vertices;
      for (Vec3& v : vertices) v = placements[i](v);
      const Vec3& at = placements[i].translation;
      if (finder(vertices)) found.push_back({at[0], at[1], at[2]});
    }
    found = ranks.gatherAll(found);
    if (found.empty()) continue;
    log::warning(fmt::format(
        "{}: {} of its {} cells '{}' intersect{} {}, the first near ({:.6g}, {:.6g}, "
        "{:.6g}) µm; {} added as {}",
        file, found.size(), state.species[s].count, state.species[s].name, found.size() == 1 ? "s" : "",
        found.size() == 1 ? "itself" : "themselves", found[0][0], found[0][1], found[0][2],
        found.size() == 1 ? "it is" : "they are", found.size() == 1 ? "it is" : "they are"));
  }
}

std::string unfinishedText(const StateCells& state) {
  const std::string& origin = state.record.origin;
  return "the cells are not those of a finished packing" + (origin.empty() ? "" : " (" + origin + ")");
}

}  // namespace

CellsToAdd fillFromState(std::shared_ptr<const Case> simulation, const std::filesystem::path& file,
                         bool leavesOut, const Communicator& ranks) {
  const Timer timer;
  const RunningSystem& running = *simulation->running;
  StateCells state = readStateCells(file, ranks);
  StateTypes found;
  together(ranks, [&] { found = typesOf(state, running, file.string()); });
  const std::vector<std::int32_t>& types = found.types;
  std::vector<std::int64_t> counts(running.cells.size(), 0);
  for (std::size_t s = 0; s < types.size(); ++s) counts[types[s]] = state.species[s].count;
  const bool deformed = areDeformed(state, ranks);
  together(ranks, [&] { requireTriangles(state, types, running, file.string()); });
  onFirstRank(ranks, [&] { warnOfOtherFiles(file); });
  const InputRecord inputs;
  const auto requested = [&](const std::filesystem::path& start) {
    CompletedRequest completed;
    together(ranks, [&] {
      completed = requestToPack(requestOf(running.cells, counts, start), withoutSection(simulation));
    });
    return completed;
  };
  const auto packedFrom = [&](const std::string& reason, const CompletedRequest& completed) {
    log::info(fmt::format("{}: {}; packing starts from them", file.string(), reason));
    Session session(addedToHemocell, {}, ranks);
    return packAndWrite(completed, outputsInRunning(completed), session, ranks);
  };
  if (!deformed && !found.other.empty())
    return packedFrom(
        fmt::format("HemoCell builds another template of '{}', as at another lattice spacing", found.other),
        requested(file));
  if (!deformed && !state.certified) return packedFrom(unfinishedText(state), requested(file));
  CellsToAdd filling;
  for (const Cell& cell : state.cells) filling.placements.push_back(placementOf(lineOf(cell)));
  CompletedRequest asTheyAre = withoutClearance(requested({}));
  asTheyAre.request.bestEffort = true;  // however dense
  bool certified = false;
  std::vector<std::pair<std::size_t, std::string>> unkept;
  together(ranks, [&] {
    const Problem problem = problemToPack(asTheyAre);
    unkept = unkeptCells(problem, state, filling.placements);
    certified = isCertifiedIn(*problem.lumen.container, state);
  });
  if (!certified) {
    const CompletedRequest completed = withoutClearance(requested(file));
    if (const std::int64_t pairs = countOverlaps(check(completed, {}, ranks)))
      return packedFrom(fmt::format("{} pair{} of its cells overlap{}", pairs, pairs == 1 ? "" : "s",
                                    pairs == 1 ? "s" : ""),
                        completed);
  }
  leaveOutUnkept(unkept, state, filling, leavesOut, file.string(), ranks);
  tellSelfIntersecting(state, filling.placements, file.string(), ranks);
  for (Cell& cell : state.cells) cell.species = types[cell.species];
  filling.cells = std::move(state.cells);
  filling = numbered(std::move(filling), running.cells.size(), ranks);
  for (std::size_t t = 0; t < counts.size(); ++t)
    log::info(fmt::format("{}: {} cells of {}", running.cells[t].name, filling.counts[t], file.string()));
  log::info(fmt::format("Time: {:.3f} s CPU, {:.3f} s wall", timer.cpu(), timer.wall()));
  return filling;
}

void saveCells(std::shared_ptr<const Case> simulation, const std::vector<Cell>& cells, double residual,
               std::int64_t iteration, const std::filesystem::path& file, const Communicator& ranks) {
  const RunningSystem& running = *simulation->running;
  std::vector<std::int64_t> counts(running.cells.size(), 0);
  double highest = 0.0;  // number in HemoCell
  for (const Cell& cell : cells) {
    ++counts[cell.species];
    highest = std::max(highest, static_cast<double>(cell.id));
  }
  ranks.sum(counts);
  residual = ranks.max(residual);
  const std::int64_t numbers = static_cast<std::int64_t>(ranks.max(highest)) + 1;
  std::optional<Problem> problem;
  together(ranks, [&] {
    CompletedRequest completed = requestToPack(requestOf(running.cells, counts), withoutSection(simulation));
    completed.request.bestEffort = true;  // the cells are there: however dense
    problem = problemToPack(completed, ranks);
  });
  const PackingProblem packing = packingProblemOf(*problem, problem->atDemanded);
  std::vector<std::int32_t> partOf(counts.size(), 0);
  const std::vector<Part>& parts = problem->atDemanded.parts;
  for (std::size_t p = 0; p < parts.size(); ++p)
    partOf[running.cell(problem->species[parts[p].species].name) - running.cells.data()] = std::int32_t(p);
  const bool deformed = ranks.any(
      std::any_of(cells.begin(), cells.end(), [](const Cell& cell) { return !cell.vertices.empty(); }));
  std::vector<std::int64_t> ids;  // by type and number in HemoCell
  std::vector<BodyState> bodies;
  std::vector<std::vector<Vec3>> vertices;
  for (const Cell& cell : cells) {
    const std::int32_t part = partOf[cell.species];
    ids.push_back(cell.species * numbers + cell.id);
    bodies.push_back(stateOf(ids.back(), part, packing.physics.species[part].shape, cell.pose));
    if (deformed) vertices.push_back(cell.vertices);
  }
  const IdShares byNumber(std::int64_t(counts.size()) * numbers, ranks);
  bodies = byNumber.collect(std::move(bodies));
  if (deformed) vertices = byNumber.collect(ids, std::move(vertices));
  std::int64_t id = ranks.sumBefore({std::int64_t(bodies.size())}).front();
  for (BodyState& body : bodies) body.id = id++;
  PackingState state = finalState(std::move(bodies), ranks, std::move(vertices));
  state.columns = {angleColumn(state.cells, {})};
  const std::string origin =
      deformed ? fmt::format("iteration {}, cells as they were", iteration)
               : fmt::format("iteration {}, rigid fits with residuals up to {:.4f} µm", iteration, residual);
  writeState(file, packing, {"", {}, origin}, state);
  std::string names;
  for (std::size_t t = 0; t < counts.size(); ++t)
    names += fmt::format("{}{} {}", t ? ", " : "", counts[t], running.cells[t].name);
  log::info(fmt::format("Wrote {}: {}; {}", file.string(), names, origin));
}

}  // namespace packmesh::hemocell
