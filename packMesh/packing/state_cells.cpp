// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/state_cells.h"

#include <cmath>
#include <optional>
#include <utility>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/io/hdf5_reader.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/read_together.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/packing/stored_membranes.h"

namespace packmesh {
namespace {

/// "RBC" of "RBC, region 1", as parts are named.
std::string kindOf(const std::string& part) {
  return part.substr(0, part.find(','));
}

/// The kinds of cells, and for each part of the file that of which it is.
std::vector<std::int32_t> readKinds(const Hdf5Reader& in, std::int64_t parts, StateCells& state) {
  std::vector<std::int32_t> kindOfPart;
  for (std::int64_t p = 0; p < parts; ++p) {
    const std::string path = pathOfSpecies(p), name = kindOf(in.text(path, "name"));
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
    for (std::size_t i = 0; i + 2 < triangles.size(); i += 3)
      kind.mesh.triangles.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    state.species.push_back(std::move(kind));
  }
  return kindOfPart;
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
  std::int32_t last = -1;
  for (const std::int32_t s : in.table<std::int32_t>("/cells/species", 1)) last = std::max(last, s);
  const std::vector<std::int32_t> kinds = readKinds(in, last + 1, state);
  if (in.has("/lumen")) {
    const std::vector<double> box = in.table<double>("/lumen/box", 3, 0, 3);
    const auto row = [&](int i) { return Vec3(box[3 * i], box[3 * i + 1], box[3 * i + 2]); };
    state.box = {row(0), row(1)};
    state.period = row(2);
  }
  std::optional<StoredMembranes> membranes;
  state.deformed = StoredMembranes::areIn(in);
  if (state.deformed && withMeshes) membranes.emplace(in, species, first, count);
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
    if (membranes) cell.vertices = membranes->of(i);
    ++state.species[cell.species].count;
    state.cells.push_back(std::move(cell));
    state.certified = state.certified && !std::isnan(gap[i]);
  }
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
