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
#include "packMesh/packing/engine.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/packing_file.h"
#include "packMesh/packing/problem_digest.h"

namespace packmesh {
namespace {

namespace fs = std::filesystem;

constexpr char kind[] = "state";

/// The group of EngineTables.
const std::string engineGroup = "/growth";

/// Bounds of plausible values: no number of a run is so large, no cell so far outside the lumen's bounds,
/// even if the lumen is small [µm].
constexpr double mostPossible = 1e17, farthest = 100.0;

/// Engines begin far above this scale.
constexpr double smallestScale = 1e-12;

/// Whether all numbers are so, none of them NaN.
template <class Numbers>
bool areFrom0To(double most, const Numbers& numbers) {
  return std::all_of(numbers.begin(), numbers.end(),
                     [most](auto x) { return x >= 0 && static_cast<double>(x) < most; });
}

/// No length except that of a path is as large [µm].
double longestPossible(const PackingProblem& problem) {
  return problem.physics.container->bounds().size().norm() + farthest;
}

const char* stageOf(const PackingProblem& problem, const PackingState& state) {
  if (isFinished(state, problem.execution.communicator)) return finishedStage;
  switch (state.position.stage) {
    case Stage::relaxation:
      return "relaxation";
    case Stage::certificate:
      return "certificate";
    case Stage::repair:
      return "repair";
    case Stage::engine:
      return problem.engine->stage().name;
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

void writeCells(Hdf5Writer& out, const std::string& group, bool withShapes,
                const std::vector<BodyState>& cells) {
  const CellTables tables = tablesOf(withShapes, cells);
  forEachTable(withShapes, tables, [&](const char* name, int columns, const auto& table) {
    out.table(group + name, columns, table);
  });
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
  std::vector<double> lengths, wallDemands;
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
}

RunTables runTablesOf(const PackingProblem& problem, const PackingState& state) {
  RunTables t;
  const RunPosition& at = state.position;
  t.position = {
      at.stage == Stage::engine ? problem.engine->stage().number : static_cast<std::int32_t>(at.stage),
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
  return t;
}

/// Pre: tables of the sizes that runTablesOf() gives.
PackingState stateOf(const RunTables& t) {
  PackingState state;
  const Stage stage = t.position[0] < std::int64_t(Stage::engine) ? Stage(t.position[0]) : Stage::engine;
  state.position = {stage, t.position[1] != 0, t.position[2], {t.position[3], t.position[4]}};
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
  return state;
}

bool ofTheRightSizes(const RunTables& t, std::size_t shapes) {
  return t.position.size() == 7 && t.counters.size() == 9 && t.lengths.size() == 3 &&
         (t.counts.empty() || t.counts.size() == shapes) &&
         t.clearedPairs.size() == 2 * t.clearances.size() && t.failedPairs.size() == 2 * t.failures.size() &&
         t.wallCells.size() == t.wallDemands.size() && t.position[0] >= 0;
}

/// Whether the values are possible in a run: the following code does not check them.
bool ofPossibleNumbers(const RunTables& run, const PackingProblem& problem) {
  const auto count = [](const auto& table) { return areFrom0To(mostPossible, table); };
  const auto length = [&](const auto& table) { return areFrom0To(longestPossible(problem), table); };
  return count(run.position) && count(run.counters) && length(run.lengths) && count(run.counts) &&
         count(run.failures) && length(run.clearances) && length(run.wallDemands);
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
                    cell.moved >= 0.0 && cell.moved < mostPossible;
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

/// The group with the files that were written with a state.
constexpr char filesGroup[] = "/files";

void writeAll(Hdf5Writer& out, const PackingProblem& problem, const StateRecord& record,
              const PackingState& state, const FilesOfState& together) {
  out.attribute("/", "unit", std::string("µm"));
  out.attribute("/", "problem", digestOf(problem));
  out.attribute("/", "lumen", problem.physics.container->describe());
  out.attribute("/", "seed", static_cast<std::int64_t>(problem.physics.seed));
  out.attribute("/", "stage", std::string(stageOf(problem, state)));
  const bool atEngine = state.position.stage == Stage::engine && state.engine;
  out.attribute("/", "iteration", atEngine ? state.engine->iterationInFiles() : state.relaxation.sweeps);
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
  out.group("/cells");
  const RunTables run = runTablesOf(problem, state);
  forEachRunTable(run, [&](const std::string& path, int columns, const auto& table) {
    out.commonTable(path, columns, table);
  });
  const bool withShapes = problem.physics.hasDeformed();
  writeCells(out, "/cells/", withShapes, state.cells);
  std::vector<std::int32_t> species;
  for (const BodyState& cell : state.cells) species.push_back(cell.species);
  writeColumns(out, columnsOf(state.measures, state.cells.size()));
  writeColumns(out, state.columns);
  const auto verticesOf = [&](std::size_t i) -> const std::vector<Vec3>* {
    if (!state.vertices.empty()) return state.vertices[i].empty() ? nullptr : &state.vertices[i];
    const bool isDeformed = withShapes && problem.physics.isDeformed(state.cells[i]);
    return isDeformed ? &problem.physics.shapeOf(state.cells[i]).mesh().vertices : nullptr;
  };
  writeMembranes(out, problem.physics.species.size(), species, verticesOf, problem.execution.communicator);
  const PastEngine idle(0);
  (state.engine ? *state.engine : idle).write(out, problem.physics, state.cells);
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

const char* const misfit = "is damaged: the sizes of its tables are inconsistent";
const char* const impossible = "is damaged: it contains values out of range";

/// Cells of a group, whose species, shapes and numbers are possible.
/// @param ids they are less than this
std::vector<BodyState> readCells(const Hdf5Reader& in, const std::string& group,
                                 const PackingProblem& problem, std::int64_t first, std::int64_t count,
                                 std::int64_t ids) {
  const bool withShapes = in.has("/cells/shape");
  CellTables tables;
  forEachTable(withShapes, tables, [&](const char* name, int columns, auto& table) {
    using Number = typename std::decay_t<decltype(table)>::value_type;
    table = in.table<Number>(group + name, columns, first, count);
  });
  if (!alike(withShapes, tables)) in.fail(misfit);
  std::vector<BodyState> cells = cellsOf(problem.physics, tables);
  const auto unknown = [&](const BodyState& cell) {
    return !problem.physics.areOfCell(cell.species, cell.shape) || cell.id < 0 || cell.id >= ids;
  };
  if (std::any_of(cells.begin(), cells.end(), unknown))
    in.fail("is damaged: it contains a cell that is not part of the problem");
  if (!ofPossibleNumbers(cells, problem)) in.fail(impossible);
  return cells;
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
  if (!ofTheRightSizes(run, problem.physics.shapes.size())) in.fail(misfit);
  const std::int64_t stage = run.position[0];
  if (stage >= std::int64_t(Stage::engine) && !(problem.engine && problem.engine->stage().number == stage))
    in.fail("is at the stage of an engine that this run does not have");
  if (!ofPossibleNumbers(run, problem)) in.fail(impossible);
  PackingState state = stateOf(run);
  if (in.size("/cells/id")[0] != state.cellCount) in.fail(misfit);
  const auto [first, end] = IdShares(state.cellCount, ranks).own();
  const bool atEngine = state.position.stage == Stage::engine;
  const std::int64_t ids = state.cellCount + (atEngine ? 0 : problem.physics.cellCount());
  state.cells = readCells(in, "/cells/", problem, first, end - first, ids);
  const auto before = [](const BodyState& a, const BodyState& b) { return !(b.id > a.id); };
  if (std::adjacent_find(state.cells.begin(), state.cells.end(), before) != state.cells.end())
    in.fail(impossible);
  for (const CellMeasures::Column& column : CellMeasures::columns)
    state.measures.*column.values =
        in.table<double>(std::string("/cells/") + column.name, 1, first, end - first);
  if (atEngine)
    state.engine = problem.engine->readState(in, problem, first, state.cells);
  else if (const std::int64_t iterations = EngineTables::read(in, problem, 0, 0).position[1]; iterations > 0)
    state.engine = std::make_shared<const PastEngine>(iterations);
  return state;
}

}  // namespace

void EngineTables::write(Hdf5Writer& out, const Physics& physics) const {
  out.group(engineGroup);
  out.group(engineGroup + "/best");
  out.commonTable(engineGroup + "/position", 1, std::vector<std::int64_t>(position.begin(), position.end()));
  out.commonTable(engineGroup + "/numbers", 1, std::vector<double>(numbers.begin(), numbers.end()));
  out.table(engineGroup + "/taken", 1, taken);
  writeCells(out, engineGroup + "/best/", physics.hasDeformed(), best);
}

EngineTables EngineTables::read(const Hdf5Reader& in, const PackingProblem& problem, std::int64_t first,
                                std::int64_t count) {
  EngineTables tables;
  const auto position = in.table<std::int64_t>(engineGroup + "/position", 1);
  const auto numbers = in.table<double>(engineGroup + "/numbers", 1);
  const std::int64_t cells = in.size("/cells/id")[0], best = in.size(engineGroup + "/best/id")[0];
  if (position.size() != tables.position.size() || numbers.size() != tables.numbers.size() ||
      (best != 0 && best != cells))
    in.fail(misfit);
  if (!areFrom0To(mostPossible, position) || !areFrom0To(mostPossible, numbers)) in.fail(impossible);
  std::copy(position.begin(), position.end(), tables.position.begin());
  std::copy(numbers.begin(), numbers.end(), tables.numbers.begin());
  if (count == 0) return tables;
  if (in.size(engineGroup + "/taken")[0] != cells) in.fail(misfit);
  tables.taken = in.table<double>(engineGroup + "/taken", 1, first, count);
  const auto isShare = [](double x) { return x >= 0.0 && x <= 1.0; };
  if (!std::all_of(tables.taken.begin(), tables.taken.end(), isShare)) in.fail(impossible);
  if (best > 0) tables.best = readCells(in, engineGroup + "/best/", problem, first, count, cells);
  return tables;
}

void PastEngine::write(Hdf5Writer& out, const Physics& physics, const std::vector<BodyState>&) const {
  EngineTables tables;
  tables.position[1] = iterations_;
  tables.write(out, physics);
}

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
