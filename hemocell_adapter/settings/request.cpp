// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/request.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "hemocell_adapter/base/interruption.h"
#include "hemocell_adapter/base/python_command.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/poll.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/packing/id_shares.h"
#include "packMesh/packing/state_file.h"

namespace packmesh::hemocell {
namespace {

struct NamedConstruction {
  Construction construction;
  const char* name;
};
constexpr NamedConstruction namesOfConstructions[] = {
    {Construction::rbcFromSphere, "RBC_FROM_SPHERE"},
    {Construction::ellipsoidFromSphere, "ELLIPSOID_FROM_SPHERE"},
    {Construction::wbcSphere, "WBC_SPHERE"},
    {Construction::meshFromStl, "MESH_FROM_STL"},
};

}  // namespace

std::filesystem::path currentFolder() {
  std::error_code ignored;
  return std::filesystem::current_path(ignored);
}

std::string toString(Construction construction) {
  for (const NamedConstruction& entry : namesOfConstructions)
    if (entry.construction == construction) return entry.name;
  return "unknown";
}

std::optional<Construction> constructionFromString(const std::string& text) {
  for (const NamedConstruction& entry : namesOfConstructions)
    if (text == entry.name) return entry.construction;
  return {};
}

std::vector<std::string> constructionNames() {
  std::vector<std::string> names;
  for (const NamedConstruction& entry : namesOfConstructions) names.emplace_back(entry.name);
  return names;
}

std::vector<std::string> meshFrameNames() {
  return {"hemocell", "file"};
}

std::string toString(MeshFrame frame) {
  return frame == MeshFrame::file ? "file" : "hemocell";
}

std::optional<MeshFrame> meshFrameFromString(const std::string& text) {
  if (text == "hemocell") return MeshFrame::hemocell;
  if (text == "file") return MeshFrame::file;
  return {};
}

namespace {

// Tables of cells of a state: "box", and of each kind those with its name and these endings.
constexpr const char *boxTable = "/box", *verticesTable = "/vertices", *trianglesTable = "/triangles",
                     *posesTable = "/poses", *membranesTable = "/membranes", *rowsTable = "/membrane";

Vec3 rowOf(const StateTable& table, std::size_t row, int from = 0) {
  const double* const v = &table.values[row * table.columns + from];
  return {v[0], v[1], v[2]};
}

std::size_t rowsOf(const StateTable& table) {
  return table.values.size() / table.columns;
}

TriangleMesh meshOf(const MemoryInput& given, const std::string& vertices, const std::string& triangles) {
  TriangleMesh mesh;
  const StateTable& points = given.table(vertices, 3);
  for (std::size_t i = 0; i < rowsOf(points); ++i) {
    mesh.vertices.push_back(rowOf(points, i));
    const Vec3& v = mesh.vertices.back();
    if (!v.allFinite())
      throw InputError(fmt::format("{}: vertices[{}]: expected finite numbers, found {} {} {}", given.what, i,
                                   v[0], v[1], v[2]));
    if (const std::string fault = coordinateFault(v); !fault.empty())
      throw InputError(fmt::format("{}: vertices[{}]{}", given.what, i, fault));
  }
  const StateTable& corners = given.table(triangles, 3);
  for (std::size_t i = 0; i < rowsOf(corners); ++i) {
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      const double corner = corners.values[3 * i + k];
      if (!(corner >= 0.0 && corner < double(mesh.vertices.size())))
        throw InputError(
            fmt::format("{}: triangles[{}]: vertex {} of {}", given.what, i, corner, mesh.vertices.size()));
      triangle[k] = static_cast<int>(corner);
    }
    mesh.triangles.push_back(triangle);
  }
  if (mesh.triangles.empty()) throw InputError(given.what + ": expected triangles, found none");
  return mesh;
}

StateCells cellsOf(const MemoryInput& given) {
  StateCells state;
  const StateTable& box = given.table(boxTable, 3);
  const auto require = [&](bool good, const std::string& table) {
    if (!good) throw InputError(fmt::format("{}: the table {} is not one of the cells", given.what, table));
  };
  require(rowsOf(box) == 3, box.name);
  state.box = {rowOf(box, 0), rowOf(box, 1)};
  state.period = rowOf(box, 2);
  for (const StateTable& table : given.tables) {
    const std::size_t end = table.name.rfind(posesTable);
    if (end == std::string::npos || end + std::string(posesTable).size() != table.name.size()) continue;
    given.table(table.name, table.columns == 10 ? 10 : 7);  // with angles or, of earlier versions, without
    StateCells::Kind kind;
    kind.name = table.name.substr(0, end);
    kind.mesh = meshOf(given, kind.name + verticesTable, kind.name + trianglesTable);
    kind.count = std::int64_t(rowsOf(table));
    const StateTable* const membranes = given.find(kind.name + membranesTable);
    const StateTable* const rows = given.find(kind.name + rowsTable);
    const std::size_t size = kind.mesh.vertices.size();
    require(!rows || (rows->columns == 1 && rows->values.size() == rowsOf(table)), kind.name + rowsTable);
    const double mostRows = membranes && membranes->columns == 3 ? double(rowsOf(*membranes) / size) : 0.0;
    for (std::size_t i = 0; i < rowsOf(table); ++i) {
      require(!rows || rows->values[i] <= mostRows - 1.0, kind.name + membranesTable);
      Cell cell;
      cell.id = std::int64_t(state.cells.size());
      cell.species = std::int32_t(state.species.size());
      cell.pose.position = rowOf(table, i);
      const double* const q = &table.values[table.columns * i + 3];
      cell.pose.orientation = Quaternion(q[0], q[1], q[2], q[3]);
      if (table.columns >= 10) cell.angles = Vec3(q + 4);  // earlier versions have none
      if (const double row = rows ? rows->values[i] : -1.0; row >= 0.0)
        for (std::size_t v = 0; v < size; ++v)
          cell.vertices.push_back(rowOf(*membranes, std::size_t(row) * size + v));
      state.deformed = state.deformed || !cell.vertices.empty();
      state.cells.push_back(std::move(cell));
    }
    state.species.push_back(std::move(kind));
  }
  return state;
}

void add(std::vector<double>& values, const Vec3& v) {
  values.insert(values.end(), {v[0], v[1], v[2]});
}

/// Of the formats that the Python package reads (python/packmesh/surface.py).
bool isReadByPython(const std::filesystem::path& file) {
  const std::string ending = file.extension().string();
  return ending == ".vtp" || ending == ".vtu" || ending == ".vtk" || ending == ".msh";
}

TriangleMesh meshByPython(const std::filesystem::path& file) {
  requireFile(file, "a mesh file");
  recordInput(file);
  const CommandEnd end = runPackmesh({"surface", "--", file.string()}, interrupted);
  poll();  // ends the run if it is to end
  using End = CommandEnd::Kind;
  if (end.kind == End::unusable)
    throw InputError(
        fmt::format("{}: meshes in this format are read by the Python package packmesh, which {}; "
                    "install that, or convert the surface to STL",
                    file.string(), end.message));
  if (end.kind == End::refused) throw InputError(end.message);
  if (end.kind != End::done) throw InputError(fmt::format("{}: packmesh: {}", file.string(), end.message));
  return meshInOff(fmt::format("{}\n", fmt::join(end.lines, "\n")), file);
}

}  // namespace

const StateTable* MemoryInput::find(std::string_view name) const {
  for (const StateTable& table : tables)
    if (table.name == name) return &table;
  return nullptr;
}

const StateTable& MemoryInput::table(std::string_view name, int columns) const {
  const StateTable* const found = find(name);
  if (!found || found->columns != columns || found->values.size() % std::size_t(columns) != 0)
    throw InputError(fmt::format("{}: expected a table {} with {} columns", what, name, columns));
  return *found;
}

bool isState(const Source& source) {
  if (source.given) return source.given->find(boxTable) != nullptr;
  return source.file.extension() == ".h5";
}

TriangleMesh meshFrom(const Source& source, std::vector<std::string>* notes) {
  if (!source.given)
    return isReadByPython(source.file) ? meshByPython(source.file) : readMesh(source.file, notes);
  TriangleMesh mesh = meshOf(*source.given, "vertices", "triangles");
  mergeEqualVertices(mesh);
  return mesh;
}

StateCells cellsFrom(const Source& source, const Communicator& ranks, bool withMeshes) {
  if (!source.given) return readStateCells(source.file, ranks, withMeshes);
  StateCells state = cellsOf(*source.given);
  const auto [first, end] = IdShares(std::int64_t(state.cells.size()), ranks).own();
  state.cells.erase(state.cells.begin() + end, state.cells.end());
  state.cells.erase(state.cells.begin(), state.cells.begin() + first);
  return state;
}

std::vector<StateTable> storedCells(const StateCells& state) {
  std::vector<StateTable> tables = {{boxTable, 3, {}}};
  for (const Vec3& row : {state.box.lo, state.box.hi, state.period}) add(tables[0].values, row);
  for (std::size_t k = 0; k < state.species.size(); ++k) {
    const StateCells::Kind& kind = state.species[k];
    StateTable vertices{kind.name + verticesTable, 3, {}}, triangles{kind.name + trianglesTable, 3, {}};
    StateTable poses{kind.name + posesTable, 10, {}}, membranes{kind.name + membranesTable, 3, {}};
    StateTable rows{kind.name + rowsTable, 1, {}};
    for (const Vec3& v : kind.mesh.vertices) add(vertices.values, v);
    for (const Triangle& t : kind.mesh.triangles)
      triangles.values.insert(triangles.values.end(), {double(t[0]), double(t[1]), double(t[2])});
    double deformed = 0.0;
    for (const Cell& cell : state.cells) {
      if (cell.species != std::int32_t(k)) continue;
      const Quaternion& q = cell.pose.orientation;
      add(poses.values, cell.pose.position);
      poses.values.insert(poses.values.end(), {q.w(), q.x(), q.y(), q.z()});
      add(poses.values, cell.angles);
      rows.values.push_back(cell.vertices.empty() ? -1.0 : deformed++);
      for (const Vec3& v : cell.vertices) add(membranes.values, v);
    }
    for (StateTable* const table : {&vertices, &triangles, &poses, &membranes, &rows})
      tables.push_back(std::move(*table));
  }
  return tables;
}

const Origin* Request::originOf(const std::string& key) const {
  for (auto found = origins.lower_bound(key); found != origins.end(); ++found) {
    if (found->first.compare(0, key.size(), key) != 0) return nullptr;
    if (found->first.size() == key.size() || found->first[key.size()] == '.') return &found->second;
  }
  return nullptr;
}

std::string keyOfSpecies(const std::string& name, const std::string& attribute) {
  return "species." + name + "." + attribute;
}

SpeciesRequest& speciesNamed(Request& request, const std::string& name) {
  for (SpeciesRequest& species : request.species) {
    if (species.name == name) return species;
  }
  if (request.species.size() >= mostSpecies)
    throw InputError("more than " + std::to_string(mostSpecies) + " species");
  request.species.emplace_back().name = name;
  return request.species.back();
}

const SpeciesRequest* findSpecies(const Request& request, const std::string& name) {
  const auto found = std::find_if(request.species.begin(), request.species.end(),
                                  [&](const SpeciesRequest& s) { return s.name == name; });
  return found == request.species.end() ? nullptr : &*found;
}

}  // namespace packmesh::hemocell
