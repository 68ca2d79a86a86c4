// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/state_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/io/hdf5_file.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/packing_file.h"

namespace packmesh {
namespace {

/// The kind of cell of a part. Version 2 names parts: "RBC, region 1".
std::string kindOf(const Hdf5Reader& in, const std::string& part) {
  const std::string name = in.text(part, "name");
  return in.has("/request") ? name : name.substr(0, name.find(','));
}

/// The kinds of cells, and for each part of the file that of which it is.
std::vector<std::int32_t> readKinds(const Hdf5Reader& in, std::int64_t parts, StateCells& state) {
  std::vector<std::int32_t> kindOfPart;
  for (std::int64_t p = 0; p < parts; ++p) {
    const std::string path = pathOfSpecies(p), name = kindOf(in, path);
    std::size_t k = 0;
    while (k < state.species.size() && state.species[k].name != name) ++k;
    kindOfPart.push_back(static_cast<std::int32_t>(k));
    if (k < state.species.size()) continue;
    StateCells::Kind kind;
    kind.name = name;
    const std::vector<double> vertices = in.table<double>(path + "/vertices", 3);
    const std::vector<std::int32_t> triangles = in.table<std::int32_t>(path + "/triangles", 3);
    for (std::size_t i = 0; i + 2 < vertices.size(); i += 3)
      kind.mesh.vertices.emplace_back(vertices[i], vertices[i + 1], vertices[i + 2]);
    const auto isVertex = [size = std::int64_t(kind.mesh.vertices.size())](std::int32_t v) {
      return v >= 0 && v < size;
    };
    if (!std::all_of(triangles.begin(), triangles.end(), isVertex))
      in.fail("is damaged: a triangle refers to no vertex");
    for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
      kind.mesh.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    state.species.push_back(std::move(kind));
  }
  return kindOfPart;
}

/// Reads the vertices of those of these cells that have meshes of their own.
/// @param species of the file @param first number of the first cell
void readMembranes(const Hdf5Reader& in, const std::vector<std::int32_t>& species, std::int64_t first,
                   std::vector<Cell>& cells) {
  const auto rows = in.table<std::int32_t>(membraneRows, 1, first, std::int64_t(cells.size()));
  std::map<std::int32_t, std::pair<std::int64_t, std::int64_t>> ranges;  // of rows, by species
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] < 0) continue;
    const std::int64_t row = rows[i];
    auto& [begin, end] = ranges.try_emplace(species[i], row, row).first->second;
    begin = std::min(begin, row);
    end = std::max(end, row + 1);
  }
  for (const auto& [s, range] : ranges) {
    const std::int64_t size = in.size(pathOfSpecies(s) + "/vertices")[0];
    const auto values = in.table<double>(pathOfSpecies(s) + "/membranes", int(3 * size), range.first,
                                         range.second - range.first);
    if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
      in.fail("is damaged: it contains values out of range");
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i] < 0 || species[i] != s) continue;
      const double* const own = &values[(rows[i] - range.first) * 3 * size];
      cells[i].vertices.reserve(size);
      for (std::int64_t v = 0; v < size; ++v) cells[i].vertices.emplace_back(own + 3 * v);
    }
  }
}

StateCells readShare(const std::filesystem::path& file, const Communicator& ranks, bool withMeshes) {
  recordInput(file);
  const Hdf5Reader in(file);
  StateCells state;
  state.record = readStateRecord(in);
  const std::int64_t cells = in.size("/cells/id")[0];
  const auto [first, end] = IdShares(cells, ranks).own();
  const std::int64_t count = end - first;
  const auto species = in.table<std::int32_t>("/cells/species", 1, first, count);
  const auto position = in.table<double>("/cells/position", 3, first, count);
  const auto orientation = in.table<double>("/cells/orientation", 4, first, count);
  const auto scale = in.table<double>("/cells/scale", 1, first, count);
  const auto gap = in.table<double>("/cells/gap", 1, first, count);
  std::int64_t last = -1;
  for (const std::int64_t s : in.table<std::int32_t>("/cells/species", 1)) last = std::max(last, s);
  const std::vector<std::int32_t> kinds = readKinds(in, last + 1, state);
  if (in.has("/lumen")) {
    const std::vector<double> box = in.table<double>("/lumen/box", 3, 0, 3);
    const auto row = [&](int i) { return Vec3(box[3 * i], box[3 * i + 1], box[3 * i + 2]); };
    state.box = {row(0), row(1)};
    state.period = row(2);
  }
  std::vector<std::int32_t> shapes;
  std::vector<double> angles;
  if (in.has("/cells/shape")) shapes = in.table<std::int32_t>("/cells/shape", 1, first, count);
  if (in.has("/cells/angles")) angles = in.table<double>("/cells/angles", 3, first, count);
  state.deformed = in.has(membraneRows);
  state.certified = true;
  for (std::int64_t i = 0; i < count; ++i) {
    constexpr double rounding = 1e-6;  // of unit quaternions and scales
    const double* p = &position[3 * i];
    const double* q = &orientation[4 * i];
    Cell cell;
    cell.id = first + i;
    cell.pose.position = {p[0], p[1], p[2]};
    cell.pose.orientation = Quaternion(q[0], q[1], q[2], q[3]);
    if (species[i] < 0 || !cell.pose.position.allFinite() ||
        !(std::abs(cell.pose.orientation.norm() - 1.0) < rounding))
      in.fail("is damaged: it contains values out of range");
    if (std::abs(scale[i] - 1.0) > rounding) in.fail("has cells that still grow: continue that run first");
    cell.species = kinds[species[i]];
    if (!shapes.empty()) cell.shape = shapes[i];
    if (!angles.empty()) cell.angles = Vec3(&angles[3 * i]);
    ++state.species[cell.species].count;
    state.cells.push_back(std::move(cell));
    state.certified = state.certified && !std::isnan(gap[i]);
  }
  if (state.deformed && withMeshes) readMembranes(in, species, first, state.cells);
  return state;
}

}  // namespace

StateCells readStateCells(const std::filesystem::path& file, const Communicator& ranks, bool withMeshes) {
  StateCells state;
  // No rank reads a file that may be damaged.
  readTogether(file, ranks, [&] {
    if (ranks.rank() == 0) readStateHead(file, oldestStateVersion);
  });
  readTogether(file, ranks, [&] { state = readShare(file, ranks, withMeshes); });
  for (StateCells::Kind& kind : state.species) kind.count = ranks.sum(kind.count);
  state.certified = !ranks.any(!state.certified);
  return state;
}

}  // namespace packmesh
