// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/state_file.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "packMesh/core/error.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/io/hdf5_file.h"
#include "packMesh/io/sealed_file.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/packing/problem_digest.h"

namespace packmesh {
namespace {

namespace fs = std::filesystem;

constexpr char kind[] = "state";

/// Group of PackingState::engine, and name of its stage. There is one engine.
constexpr char engineGroup[] = "/growth";

/// Group of PackingState::soft.
constexpr char softGroup[] = "/soft";

std::string ofSoft(const char* table) {
  return std::string(softGroup) + "/" + table;
}

std::string ofEngine(const char* table) {
  return std::string(engineGroup) + "/" + table;
}

/// Bounds of plausible values: no number of a run is so large, no cell so far outside the lumen's bounds,
/// even if the lumen is small [µm].
constexpr double mostPossible = 1e17, farthest = 100.0;

/// Engines begin far above this scale.
constexpr double smallestScale = 1e-12;

/// No length except that of a path is as large [µm].
double longestPossible(const PackingProblem& problem) {
  return problem.physics.container->bounds().size().norm() + farthest;
}

const char* stageOf(const PackingState& state, bool finished) {
  if (finished) return finishedStage;
  switch (state.position.stage) {
    case Stage::relaxation:
      return "relaxation";
    case Stage::certificate:
      return "certificate";
    case Stage::repair:
      return "repair";
    case Stage::engine:
      return engineGroup + 1;
    case Stage::soft:
      return softCellsStage;
  }
  return "";
}

/// The cells, one table per property.
struct CellTables {  // orientations as w, x, y, z, which ParaView takes
  std::vector<std::int64_t> id;
  std::vector<std::int32_t> species, deepInWall;
  std::vector<std::int32_t> shape;  ///< if there are deformed cells
  std::vector<double> position, orientation, scale, extraWallClearance, overlap, moved;
};

/// Calls visit(name, columns, table) for every table.
/// @param withShapes there are deformed cells
template <class Tables, class Visit>
void forEachTable(bool withShapes, Tables& tables, Visit&& visit) {
  visit("id", 1, tables.id);
  visit("species", 1, tables.species);
  visit("position", 3, tables.position);
  visit("orientation", 4, tables.orientation);
  visit("scale", 1, tables.scale);
  visit("extra_wall_clearance", 1, tables.extraWallClearance);
  visit("overlap", 1, tables.overlap);
  visit("moved", 1, tables.moved);
  visit("deep_in_wall", 1, tables.deepInWall);
  if (withShapes) visit("shape", 1, tables.shape);
}

CellTables tablesOf(bool withShapes, const std::vector<BodyState>& cells) {
  CellTables tables;
  forEachTable(withShapes, tables, [&](const char*, int columns, auto& table) {
    table.reserve(cells.size() * static_cast<std::size_t>(columns));  // they are large
  });
  for (const BodyState& cell : cells) {
    tables.id.push_back(cell.id);
    tables.species.push_back(cell.species);
    if (withShapes) tables.shape.push_back(cell.shape);
    tables.position.insert(tables.position.end(), cell.position.begin(), cell.position.end());
    const Quaternion& q = cell.orientation;
    tables.orientation.insert(tables.orientation.end(), {q.w(), q.x(), q.y(), q.z()});
    tables.scale.push_back(cell.scale);
    tables.extraWallClearance.push_back(cell.extraWallClearance);
    tables.overlap.push_back(cell.overlap);
    tables.moved.push_back(cell.moved);
    tables.deepInWall.push_back(cell.deepInWall);
  }
  return tables;
}

/// Whether all tables have the same number of rows.
bool alike(bool withShapes, CellTables& tables) {
  const std::size_t rows = tables.id.size();
  bool same = true;
  forEachTable(withShapes, tables, [&](const char*, int columns, const auto& table) {
    same = same && table.size() == rows * static_cast<std::size_t>(columns);
  });
  return same;
}

/// @return their species and shapes may be none of the problem
std::vector<BodyState> cellsOf(const Physics& physics, const CellTables& tables) {
  std::vector<BodyState> cells(tables.id.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    BodyState& cell = cells[i];
    cell.id = tables.id[i];
    cell.species = tables.species[i];
    const bool isKnown = cell.species >= 0 && cell.species < static_cast<int>(physics.species.size());
    cell.shape = !tables.shape.empty() ? tables.shape[i] : isKnown ? physics.species[cell.species].shape : -1;
    cell.position = Vec3(&tables.position[3 * i]);
    const double* q = &tables.orientation[4 * i];
    cell.orientation = {q[0], q[1], q[2], q[3]};
    cell.scale = tables.scale[i];
    cell.extraWallClearance = tables.extraWallClearance[i];
    cell.overlap = tables.overlap[i];
    cell.moved = tables.moved[i];
    cell.deepInWall = tables.deepInWall[i] != 0;
  }
  return cells;
}

/// Names, numbers and templates.
void writeSpecies(Hdf5Writer& out, const Physics& physics) {
  out.group("/species");
  for (std::size_t s = 0; s < physics.species.size(); ++s) {
    const Species& species = physics.species[s];
    const std::string path = pathOfSpecies(s);
    out.group(path);
    out.attribute(path, "name", species.kindName());
    out.attribute(path, "count", species.count);
    writeMesh(out, path, physics.shapeOf(species).mesh());
  }
}

/// All values that do not belong to a cell, as named arrays.
struct RunTables {
  std::vector<std::int64_t> position, counters, counts, clearedPairs, disturbed, failedPairs, failures,
      wallCells;
  std::vector<std::int64_t> engine;
  std::vector<double> lengths, wallDemands, engineNumbers;
  std::vector<float> clearances;
};

template <class Tables, class Visit>
void forEachRunTable(Tables& tables, Visit&& visit) {
  visit("/run/position", 1, tables.position);
  visit("/relaxation/counters", 1, tables.counters);
  visit("/relaxation/lengths", 1, tables.lengths);
  visit("/relaxation/counts", 1, tables.counts);
  visit("/relaxation/extra_clearance_pairs", 2, tables.clearedPairs);
  visit("/relaxation/extra_clearance", 1, tables.clearances);
  visit("/relaxation/disturbed", 1, tables.disturbed);
  visit("/run/failed_pairs", 2, tables.failedPairs);
  visit("/run/failures", 1, tables.failures);
  visit("/run/misplaced_cells", 1, tables.wallCells);
  visit("/run/demanded_of_wall", 1, tables.wallDemands);
  visit(ofEngine("position"), 1, tables.engine);
  visit(ofEngine("numbers"), 1, tables.engineNumbers);
}

RunTables runTablesOf(const PackingState& state) {
  RunTables t;
  const RunPosition& at = state.position;
  t.position = {static_cast<std::int64_t>(at.stage),
                at.fewer ? 1 : 0,
                at.round,
                at.schedule.part,
                at.schedule.sweep,
                state.repairs,
                state.cellCount};
  const RelaxationState& r = state.relaxation;
  t.counters = {r.sweeps,          r.listedInSweep, r.coarsely ? 1 : 0,
                r.last.totalSteps, r.last.contacts, r.last.thorough ? 1 : 0,
                r.blocks[0],       r.blocks[1],     r.blocks[2]};
  t.lengths = {r.skin, r.slack, r.last.deepest};
  t.counts = r.counts;
  for (const auto& [pair, extra] : r.extraClearance) {
    t.clearedPairs.insert(t.clearedPairs.end(), {pair.first, pair.second});
    t.clearances.push_back(extra);
  }
  t.disturbed.assign(r.disturbed.begin(), r.disturbed.end());
  for (const auto& [pair, times] : state.failures) {
    t.failedPairs.insert(t.failedPairs.end(), {pair.first, pair.second});
    t.failures.push_back(times);
  }
  for (const auto& [cell, demanded] : state.demandedOfWall) {
    t.wallCells.push_back(cell);
    t.wallDemands.push_back(demanded);
  }
  const EnginePosition& e = state.engine;
  t.engine.assign(e.counters.begin(), e.counters.end());
  t.engine.insert(t.engine.begin() + 1, e.iterations);
  t.engineNumbers.assign(e.numbers.begin(), e.numbers.end());
  return t;
}

/// Pre: tables of the sizes that runTablesOf() gives.
PackingState stateOf(const RunTables& t) {
  PackingState state;
  state.position = {
      static_cast<Stage>(t.position[0]), t.position[1] != 0, t.position[2], {t.position[3], t.position[4]}};
  state.repairs = t.position[5];
  state.cellCount = t.position[6];
  RelaxationState& r = state.relaxation;
  r.sweeps = t.counters[0];
  r.listedInSweep = t.counters[1];
  r.coarsely = t.counters[2] != 0;
  r.last.totalSteps = t.counters[3];
  r.last.contacts = t.counters[4];
  r.last.thorough = t.counters[5] != 0;
  for (int k = 0; k < 3; ++k) r.blocks[k] = static_cast<int>(t.counters[6 + k]);
  r.skin = t.lengths[0];
  r.slack = t.lengths[1];
  r.last.deepest = t.lengths[2];
  r.counts = t.counts;
  for (std::size_t i = 0; i < t.clearances.size(); ++i)
    r.extraClearance[{t.clearedPairs[2 * i], t.clearedPairs[2 * i + 1]}] = t.clearances[i];
  r.disturbed.insert(t.disturbed.begin(), t.disturbed.end());
  for (std::size_t i = 0; i < t.failures.size(); ++i)
    state.failures[{t.failedPairs[2 * i], t.failedPairs[2 * i + 1]}] = t.failures[i];
  for (std::size_t i = 0; i < t.wallCells.size(); ++i)
    state.demandedOfWall[t.wallCells[i]] = t.wallDemands[i];
  state.engine.iterations = t.engine[1];
  state.engine.counters = {t.engine[0], t.engine[2], t.engine[3], t.engine[4], t.engine[5]};
  std::copy(t.engineNumbers.begin(), t.engineNumbers.end(), state.engine.numbers.begin());
  return state;
}

bool ofTheRightSizes(const RunTables& t, std::size_t shapes) {
  return t.position.size() == 7 && t.counters.size() == 9 && t.lengths.size() == 3 &&
         (t.counts.empty() || t.counts.size() == shapes) &&
         t.clearedPairs.size() == 2 * t.clearances.size() && t.failedPairs.size() == 2 * t.failures.size() &&
         t.wallCells.size() == t.wallDemands.size() && t.position[0] >= 0 &&
         t.position[0] <= static_cast<std::int64_t>(Stage::last) && t.engine.size() == 6 &&
         t.engineNumbers.size() == 2;
}

/// Whether the values are possible in a run: the following code does not check them.
bool ofPossibleNumbers(const RunTables& run, const PackingProblem& problem) {
  const auto from0To = [](double most) {
    return [most](const auto& table) {
      return std::all_of(table.begin(), table.end(),
                         [most](auto x) { return x >= 0 && static_cast<double>(x) < most; });  // no NaN
    };
  };
  const auto count = from0To(mostPossible), length = from0To(longestPossible(problem));
  return count(run.position) && count(run.counters) && length(run.lengths) && count(run.counts) &&
         count(run.failures) && length(run.clearances) && length(run.wallDemands) && count(run.engine) &&
         count(run.engineNumbers);
}

/// The same for cells. Their species have been checked.
bool ofPossibleNumbers(const std::vector<BodyState>& cells, const PackingProblem& problem) {
  const Box bounds = problem.physics.container->bounds();
  const Vec3 size = bounds.size();
  constexpr double rounding = 1e-6;
  const double longest = longestPossible(problem);
  for (const BodyState& cell : cells) {
    double turned = 0.0;
    for (const double q : cell.orientation.coeffs()) turned += q * q;
    bool possible = std::abs(turned - 1.0) < rounding && cell.scale > smallestScale &&
                    cell.scale < 1.0 + rounding && cell.extraWallClearance >= 0.0 &&
                    cell.extraWallClearance < longest && cell.overlap >= 0.0 && cell.overlap < longest &&
                    cell.moved >= 0.0 && cell.moved < mostPossible && cell.stepTaken >= 0.0 &&
                    cell.stepTaken <= 1.0;
    for (int k = 0; k < 3; ++k)  // positions are not always wrapped at once
      possible = possible && cell.position[k] > bounds.lo[k] - size[k] - farthest &&
                 cell.position[k] < bounds.hi[k] + size[k] + farthest;
    if (!possible) return false;
  }
  return true;
}

void writeRecord(Hdf5Writer& out, const StateRecord& record) {
  out.attribute("/", "origin", record.origin);
  out.group("/request");
  out.attribute("/request", "inputs", static_cast<std::int64_t>(record.inputs.size()));
  out.commonTable("/request/text", 1,
                  std::vector<std::uint8_t>(record.request.begin(), record.request.end()));
  for (std::size_t i = 0; i < record.inputs.size(); ++i) {
    const StateTable& input = record.inputs[i];
    const std::string path = "/request/" + std::to_string(i);
    out.group(path);
    out.attribute(path, "name", input.name);
    out.attribute(path, "columns", static_cast<std::int64_t>(input.columns));
    out.commonTable(path + "/values", input.columns, input.values);
  }
}

StateRecord readRecord(const Hdf5Reader& in) {
  StateRecord record;
  record.origin = in.text("/", "origin");
  const auto text = in.table<std::uint8_t>("/request/text", 1);
  record.request.assign(text.begin(), text.end());
  const std::int64_t inputs = in.integer("/request", "inputs");
  for (std::int64_t i = 0; i < inputs; ++i) {
    const std::string path = "/request/" + std::to_string(i);
    StateTable& input = record.inputs.emplace_back();
    input.name = in.text(path, "name");
    input.columns = static_cast<int>(in.integer(path, "columns"));
    if (input.columns < 1) in.fail("is damaged: a table without columns");
    input.values = in.table<double>(path + "/values", input.columns);
  }
  return record;
}

/// Of version 2, whose command consists of words: cells of a simulation have two, the second of which says
/// so.
StateRecord recordOfWords(const Hdf5Reader& in) {
  StateRecord record;
  if (in.integer("/command", "words") != 2) return record;
  const std::string last = in.text("/command", "1");
  if (last.rfind("iteration ", 0) == 0) record.origin = last;
  return record;
}

/// @param at the state's, the same on all ranks but for its cells
void writeSoft(Hdf5Writer& out, const SoftPosition& at) {
  out.group(softGroup);
  out.attribute(softGroup, "membranes", at.membranes);
  out.commonTable(ofSoft("position"), 1, std::vector<std::int64_t>(at.counters.begin(), at.counters.end()));
  out.commonTable(ofSoft("numbers"), 1, std::vector<double>(at.numbers.begin(), at.numbers.end()));
  out.table(ofSoft("cells"), SoftPosition::perCell, at.cells);
  out.table(ofSoft("vertices"), SoftPosition::perVertex, at.vertices);
}

/// The group with the files that were written with a state.
constexpr char filesGroup[] = "/files";

void writeAll(Hdf5Writer& out, const PackingProblem& problem, const StateRecord& record,
              const PackingState& state, const FilesOfState& together) {
  out.attribute("/", "unit", std::string("µm"));
  out.attribute("/", "problem", digestOf(problem));
  out.attribute("/", "lumen", problem.physics.container->describe());
  out.attribute("/", "seed", static_cast<std::int64_t>(problem.physics.seed));
  out.attribute("/", "stage", std::string(stageOf(state, isFinished(state, problem.execution.communicator))));
  out.attribute("/", "iteration", state.soft ? state.soft->counters[0] : state.relaxation.sweeps);
  writeRecord(out, record);
  if (!together.empty()) out.group(filesGroup);
  std::int64_t files = 0;
  for (const auto& [name, hash] : together)
    out.attribute(filesGroup, std::to_string(files++).c_str(), hash + " " + name);
  if (files > 0) out.attribute(filesGroup, "number", files);
  writeSpecies(out, problem.physics);
  writeLumen(out, *problem.physics.container);
  out.group("/run");
  out.group("/relaxation");
  out.group(engineGroup);
  out.group(ofEngine("best"));
  out.group("/cells");
  const RunTables run = runTablesOf(state);
  forEachRunTable(run, [&](const std::string& path, int columns, const auto& table) {
    out.commonTable(path, columns, table);
  });
  const bool withShapes = problem.physics.hasDeformed();
  const CellTables cells = tablesOf(withShapes, state.cells);
  forEachTable(withShapes, cells, [&](const char* name, int columns, const auto& table) {
    out.table(std::string("/cells/") + name, columns, table);
  });
  writeColumns(out, columnsOf(state.measures, state.cells.size()));
  writeColumns(out, state.columns);
  const auto verticesOf = [&](std::size_t i) -> const std::vector<Vec3>* {
    if (!state.vertices.empty()) return state.vertices[i].empty() ? nullptr : &state.vertices[i];
    const bool isDeformed = withShapes && problem.physics.isDeformed(state.cells[i]);
    return isDeformed ? &problem.physics.shapeOf(state.cells[i]).mesh().vertices : nullptr;
  };
  writeMembranes(out, problem.physics.species.size(), cells.species, verticesOf,
                 problem.execution.communicator);
  // Data of the engine only: the fractions of their last steps that cells took, and the best state of earlier
  // attempts.
  const bool atEngine = state.position.stage == Stage::engine;
  std::vector<double> taken;
  for (const BodyState& cell : state.cells)
    if (atEngine) taken.push_back(cell.stepTaken);
  out.table(ofEngine("taken"), 1, taken);
  const CellTables best = tablesOf(withShapes, state.engine.best);
  forEachTable(withShapes, best, [&](const char* name, int columns, const auto& table) {
    out.table(ofEngine("best/") + name, columns, table);
  });
  if (state.soft) writeSoft(out, *state.soft);
}

}  // namespace

PackingState finalState(std::vector<BodyState> own, const Communicator& ranks,
                        std::vector<std::vector<Vec3>> vertices) {
  std::vector<std::int64_t> ids;
  for (const BodyState& cell : own) ids.push_back(cell.id);
  PackingState state;
  state.position.stage = Stage::certificate;
  state.cellCount = ranks.sum(std::int64_t(own.size()));
  const IdShares shares(state.cellCount, ranks);
  state.cells = shares.collect(std::move(own));
  if (ranks.any(!vertices.empty())) state.vertices = shares.collect(ids, std::move(vertices));
  return state;
}

bool isFinished(const PackingState& state, const Communicator& ranks) {
  return ranks.any(state.measures.size() > 0 &&
                   std::none_of(state.measures.gap.begin(), state.measures.gap.end(),
                                [](double gap) { return std::isnan(gap); }));
}

std::unique_ptr<AtomicFiles> preparedState(const fs::path& file, const PackingProblem& problem,
                                           const StateRecord& record, const PackingState& state,
                                           const FilesOfState& together) {
  const Communicator& ranks = problem.execution.communicator;
  std::unique_ptr<AtomicFiles> files = writtenHdf5(
      file, ranks, sealSize, [&](Hdf5Writer& out) { writeAll(out, problem, record, state, together); });
  writeTogether(ranks, [&] {
    if (ranks.rank() != 0) return;
    const std::string error = seal(files->temporary(), {kind, stateVersion, writer()});
    if (!error.empty()) throw OutputError(file.string() + ": " + error);
    files->end();
  });
  return files;
}

void writeState(const fs::path& file, const PackingProblem& problem, const StateRecord& record,
                const PackingState& state) {
  const std::unique_ptr<AtomicFiles> files = preparedState(file, problem, record, state);
  writeTogether(problem.execution.communicator, [&] { files->commit(); });
}

StateHead readStateHead(const fs::path& file, std::int64_t oldest) {
  requireSealed(file, kind, oldest, stateVersion);
  const Hdf5Reader in(file);
  StateHead head;
  head.stage = in.text("/", "stage");
  head.digest = in.text("/", "problem");
  head.cells = in.size("/cells/id")[0];
  head.deformed = in.has(membraneRows);
  head.record = readStateRecord(in);
  const std::int64_t files = in.has(filesGroup) ? in.integer(filesGroup, "number") : 0;
  for (std::int64_t i = 0; i < files; ++i) {
    const std::string line = in.text(filesGroup, std::to_string(i).c_str());
    const std::size_t space = std::min(line.find(' '), line.size());
    head.files[line.substr(std::min(space + 1, line.size()))] = line.substr(0, space);
  }
  return head;
}

StateRecord readStateRecord(const Hdf5Reader& in) {
  return in.has("/request") ? readRecord(in) : recordOfWords(in);
}

namespace {

/// Of the cells [first, end).
SoftPosition readSoft(const Hdf5Reader& in, const Physics& physics, std::int64_t first, std::int64_t end) {
  constexpr double most = 1e9;  // no length [µm] and no force [pN] is so large
  SoftPosition at;
  at.membranes = in.text(softGroup, "membranes");
  const auto counters = in.table<std::int64_t>(ofSoft("position"), 1, 0, std::int64_t(at.counters.size()));
  const auto numbers = in.table<double>(ofSoft("numbers"), 1, 0, std::int64_t(at.numbers.size()));
  std::copy(counters.begin(), counters.end(), at.counters.begin());
  std::copy(numbers.begin(), numbers.end(), at.numbers.begin());
  std::int64_t before = 0, own = 0;  // vertices
  const auto species = in.table<std::int32_t>("/cells/species", 1, 0, end);
  for (std::int64_t i = 0; i < end; ++i) {
    if (species[i] < 0 || species[i] >= static_cast<std::int32_t>(physics.species.size()))
      in.fail("is damaged: it contains a cell that is not part of the problem");
    const auto& mesh = physics.shapeOf(physics.species[species[i]]).mesh();
    (i < first ? before : own) += static_cast<std::int64_t>(mesh.vertices.size());
  }
  at.cells = in.table<double>(ofSoft("cells"), SoftPosition::perCell, first, end - first);
  at.vertices = in.table<float>(ofSoft("vertices"), SoftPosition::perVertex, before, own);
  const auto possible = [](double x) { return std::abs(x) < most; };  // no NaN
  const auto counts = [](auto x) { return x >= 0 && static_cast<double>(x) < mostPossible; };
  if (!std::all_of(at.counters.begin(), at.counters.end(), counts) ||
      !std::all_of(at.numbers.begin(), at.numbers.end(), counts) ||
      !std::all_of(at.cells.begin(), at.cells.end(), possible) ||
      !std::all_of(at.vertices.begin(), at.vertices.end(), possible))
    in.fail("is damaged: it contains values out of range");
  return at;
}

/// The data of this rank.
PackingState readShare(const Hdf5Reader& in, const PackingProblem& problem) {
  const Communicator& ranks = problem.execution.communicator;
  if (in.text("/", "problem") != digestOf(problem))
    in.fail("is the state of another problem (lumen, cells, counts, clearances or seed differ)");
  RunTables run;
  forEachRunTable(run, [&](const std::string& path, int columns, auto& table) {
    using Number = typename std::decay_t<decltype(table)>::value_type;
    table = in.table<Number>(path, columns);
  });
  const char* const misfit = "is damaged: the sizes of its tables are inconsistent";
  if (!ofTheRightSizes(run, problem.physics.shapes.size())) in.fail(misfit);
  const char* const impossible = "is damaged: it contains values out of range";
  if (!ofPossibleNumbers(run, problem)) in.fail(impossible);
  PackingState state = stateOf(run);
  if (in.size("/cells/id")[0] != state.cellCount) in.fail(misfit);
  const auto [first, end] = IdShares(state.cellCount, ranks).own();
  const bool withShapes = in.has("/cells/shape");
  CellTables cells;
  forEachTable(withShapes, cells,
               [&, from = first, count = end - first](const char* name, int columns, auto& table) {
                 using Number = typename std::decay_t<decltype(table)>::value_type;
                 table = in.table<Number>(std::string("/cells/") + name, columns, from, count);
               });
  for (const CellMeasures::Column& column : CellMeasures::columns)
    state.measures.*column.values =
        in.table<double>(std::string("/cells/") + column.name, 1, first, end - first);
  state.cells = cellsOf(problem.physics, cells);
  if (state.position.stage == Stage::engine) {
    if (in.size(ofEngine("taken"))[0] != state.cellCount) in.fail(misfit);
    const std::vector<double> taken = in.table<double>(ofEngine("taken"), 1, first, end - first);
    for (std::size_t i = 0; i < taken.size(); ++i) state.cells[i].stepTaken = taken[i];
  }
  if (state.position.stage == Stage::soft) state.soft = readSoft(in, problem.physics, first, end);
  const std::int64_t bestCells = in.size(ofEngine("best/id"))[0];
  if (bestCells != 0 && bestCells != state.cellCount) in.fail(misfit);
  CellTables best;
  forEachTable(withShapes, best,
               [&, from = bestCells > 0 ? first : 0, count = bestCells > 0 ? end - first : 0](
                   const char* name, int columns, auto& table) {
                 using Number = typename std::decay_t<decltype(table)>::value_type;
                 table = in.table<Number>(ofEngine("best/") + name, columns, from, count);
               });
  if (!alike(withShapes, best)) in.fail(misfit);
  state.engine.best = cellsOf(problem.physics, best);
  std::int64_t all = state.cellCount;
  if (state.position.stage != Stage::engine)
    for (const Species& species : problem.physics.species) all += species.count;
  const auto unknown = [&](const BodyState& cell) {
    return !problem.physics.areOfCell(cell.species, cell.shape) || cell.id < 0 || cell.id >= all;
  };
  if (std::any_of(state.cells.begin(), state.cells.end(), unknown) ||
      std::any_of(state.engine.best.begin(), state.engine.best.end(), unknown))
    in.fail("is damaged: it contains a cell that is not part of the problem");
  const auto before = [](const BodyState& a, const BodyState& b) { return !(b.id > a.id); };
  if (std::adjacent_find(state.cells.begin(), state.cells.end(), before) != state.cells.end() ||
      !ofPossibleNumbers(state.cells, problem) || !ofPossibleNumbers(state.engine.best, problem))
    in.fail(impossible);
  return state;
}

}  // namespace

PackingState readState(const fs::path& file, const PackingProblem& problem) {
  const Communicator& ranks = problem.execution.communicator;
  PackingState state;
  // No rank reads a file that may be damaged.
  readTogether(file, ranks, [&] {
    if (ranks.rank() == 0) requireSealed(file, kind, stateVersion, stateVersion);
  });
  readTogether(file, ranks, [&] { state = readShare(Hdf5Reader(file), problem); });
  return state;
}

}  // namespace packmesh
