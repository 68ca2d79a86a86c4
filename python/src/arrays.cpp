// SPDX-License-Identifier: AGPL-3.0-or-later
#include "arrays.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/settings/command_line.h"
#include "hemocell_adapter/settings/request_json.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace py = pybind11;
using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

using Table = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Bytes of file names that are not UTF-8 are kept (surrogateescape).
std::string bytesOf(const py::handle& text) {
  const auto encoded = py::reinterpret_steal<py::bytes>(PyUnicode_EncodeFSDefault(text.ptr()));
  if (!encoded) throw py::error_already_set();
  return encoded;
}

/// The package gives plain numbers, texts, lists and dicts, and PythonNumbers.
Json jsonOf(const py::handle& value, MemoryInputs& gifts) {
  if (value.is_none()) return nullptr;
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::int_>(value)) {
    int overflow = 0;
    const long long number = PyLong_AsLongLongAndOverflow(value.ptr(), &overflow);
    return overflow == 0 ? Json(number) : Json(std::string(py::str(value)));
  }
  if (py::isinstance<py::float_>(value)) return value.cast<double>();
  if (py::isinstance<py::str>(value)) return bytesOf(value);
  if (py::isinstance<py::dict>(value)) {
    Json all = Json::object();
    for (const auto& [key, one] : py::reinterpret_borrow<py::dict>(value))
      all[bytesOf(key)] = jsonOf(one, gifts);
    return all;
  }
  if (py::isinstance<py::list>(value)) {
    Json all = Json::array();
    for (const py::handle& one : py::reinterpret_borrow<py::list>(value)) all.push_back(jsonOf(one, gifts));
    return all;
  }
  const PythonNumbers numbers = value.cast<PythonNumbers>();
  gifts[numbers.given->key] = numbers.given;
  return {{"given", numbers.given->key}};
}

py::object objectOf(const Json& json) {
  if (json.is_boolean()) return py::bool_(json.get<bool>());
  if (json.is_number_float()) return py::float_(json.get<double>());
  if (json.is_number()) return py::int_(json.get<long long>());
  if (json.is_string()) {
    const std::string text = json.get<std::string>();
    return py::reinterpret_steal<py::object>(
        PyUnicode_DecodeFSDefaultAndSize(text.data(), py::ssize_t(text.size())));
  }
  if (json.is_array()) {
    py::list all;
    for (const Json& one : json) all.append(objectOf(one));
    return all;
  }
  if (!json.is_object()) return py::none();
  py::dict all;
  for (const auto& [key, one] : json.items()) all[py::str(key)] = objectOf(one);
  return all;
}

/// "wall_clearance" of "wallClearance".
std::string snakeCase(const std::string& name) {
  std::string text;
  for (const char c : name) {
    if (std::isupper(static_cast<unsigned char>(c))) text += '_';
    text += c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return text;
}

/// What Python calls attributes of species and bodies.
std::string attributeOf(const std::string& list, const std::string& name) {
  static const std::map<std::string, std::string> ofSpecies = {
      {"file", "mesh"}, {"scale", "mesh_scale"}, {"frame", "mesh_frame"}};
  if (list == "species")
    if (const auto found = ofSpecies.find(name); found != ofSpecies.end()) return found->second;
  if (list != "species" && name == "file") return "source";
  const bool ofBody = list == "regions" && name != "hematocrit" && name != "count" && name != "species";
  return (ofBody ? "body." : "") + snakeCase(name);
}

/// Of what has no argument of its own: species["RBC"].wall_clearance, obstacles[0].radius.
std::string pathOf(const SettingName& setting) {
  const std::size_t dot = std::min(setting.name.find('.'), setting.name.size());
  const std::string list = setting.name.substr(0, dot);
  const bool isNumber = setting.of.find_first_not_of("0123456789") == std::string::npos;
  std::string text = list;
  if (!setting.of.empty()) text += isNumber ? "[" + setting.of + "]" : "[\"" + setting.of + "\"]";
  return dot < setting.name.size() ? text + "." + attributeOf(list, setting.name.substr(dot + 1)) : text;
}

std::string termOfPython(const SettingName& setting) {
  static const std::map<std::string, std::string> others = {
      {"plt_ratio", "platelets"},
      {"noRotate", "rotate=False"},
      {"pre-inlet-range", "pre_inlet_ranges"},
      {"cell", "Species(ellipsoid)"},
      {"cell-mesh", "Species(mesh)"},
      {"mesh-scale", "Species(mesh_scale)"},
      {"mesh-frame", "Species(mesh_frame)"},
      {"minimum-distance-from-solid", "Species(minimum_distance_from_solid)"}};
  if (!setting.of.empty() || setting.name.find('.') != std::string::npos) return pathOf(setting);
  if (setting.name == "box") return setting.begins ? "box" : "box=(x, y, z)";
  for (const Setting& row : settingsTable())
    if (row.option == setting.name && !row.countOf.empty())
      return fmt::format("species={{\"{}\": {}}}", row.countOf,
                         setting.value.empty() ? "..." : setting.value);
  if (const auto found = others.find(setting.name); found != others.end()) return found->second;
  const std::string name = snakeCase(setting.name);
  if (setting.value.empty()) return name;
  return setting.value.size() == 1 ? name + "=" + setting.value
                                   : fmt::format("{}=\"{}\"", name, setting.value);
}

/// @param tables names and arrays of shape (n, k)
PythonNumbers numbers(const std::string& setting, const std::string& of,
                      const std::vector<std::pair<std::string, Table>>& tables) {
  std::vector<StateTable> all;
  for (const auto& [name, values] : tables) {
    const int columns = values.ndim() == 2 ? int(values.shape(1)) : 1;
    all.push_back({name, columns, {values.data(), values.data() + values.size()}});
  }
  return numbersOf(setting, of, std::move(all));
}

}  // namespace

PythonNumbers numbersOf(const std::string& setting, const std::string& of, std::vector<StateTable> tables) {
  auto given = std::make_shared<MemoryInput>();
  given->key = of.empty() ? setting : setting + " " + of;
  given->what = heading(setting, of);
  given->tables = std::move(tables);
  return {std::move(given)};
}

Request requestOf(const py::dict& stated) {
  MemoryInputs gifts;
  const Json json = jsonOf(stated, gifts);
  return withJson({}, json, {Origin::Kind::keyword, ""}, gifts);
}

py::object dictOf(const Request& request) {
  return objectOf(toJson(request));
}

py::object wordsIn(const Request& request) {
  return memoryInputsOf(request).empty() ? objectOf(wordsOf(request)) : py::object(py::none());
}

void addRequests(py::module_& module) {
  setTerms(termOfPython);
  py::class_<PythonNumbers>(module, "Numbers").def(py::init(&numbers));
}

namespace py = pybind11;

namespace {

/// Views of what the packing holds, which it keeps alive, are not written to.
py::array readOnly(py::array array) {
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// Keeps a packing for as long as an array that is part of it exists.
py::capsule keepAlive(const Held& held) {
  return {new Held(held), [](void* kept) { delete static_cast<Held*>(kept); }};
}

}  // namespace

py::tuple vectorOf(const Vec3& v) {
  return py::make_tuple(v[0], v[1], v[2]);
}

py::tuple arraysOf(const TriangleMesh& mesh) {
  py::array_t<double> vertices({py::ssize_t(mesh.vertices.size()), py::ssize_t(3)});
  double* place = vertices.mutable_data();
  for (const Vec3& vertex : mesh.vertices)
    for (const double x : vertex) *place++ = x;
  py::array_t<std::int32_t> triangles({py::ssize_t(mesh.triangles.size()), py::ssize_t(3)});
  std::int32_t* out = triangles.mutable_data();
  for (const Triangle& triangle : mesh.triangles)
    for (const int corner : triangle) *out++ = corner;
  return py::make_tuple(vertices, triangles);
}

py::array_t<double> arrayOf(const std::vector<PosLine>& lines) {
  py::array_t<double> array({py::ssize_t(lines.size()), py::ssize_t(6)});
  auto out = array.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < out.shape(0); ++i)
    for (int k = 0; k < 3; ++k) {
      out(i, k) = lines[i].position[k];
      out(i, k + 3) = lines[i].angles[k];
    }
  return array;
}

std::string cellName(const std::string& text) {
  return std::get<std::string>(parseValue(specs::name(), text));
}

std::vector<PosLine> linesOf(const std::string& name, const Rows& rows) {
  if (rows.ndim() != 2 || rows.shape(1) != 6)
    throw InputError("the cells '" + name + "': expected an array of shape (n, 6)");
  std::vector<PosLine> lines(rows.shape(0));
  const auto in = rows.unchecked<2>();
  for (py::ssize_t i = 0; i < in.shape(0); ++i)
    for (int k = 0; k < 3; ++k) {
      lines[i].position[k] = in(i, k);
      lines[i].angles[k] = in(i, k + 3);
    }
  for (const PosLine& line : lines)
    if (!line.position.allFinite() || !line.angles.allFinite())
      throw InputError("the cells '" + name + "': expected finite numbers");
  return lines;
}

const std::vector<Vec3>* HeldCells::ownVertices(std::size_t cell) const {
  if (packing) {
    const PlacedCell& placed = packing->cells[cell];
    const Problem& problem = *packing->problem;
    return problem.isDeformed(placed) ? &problem.shapes[placed.shape]->mesh().vertices : nullptr;
  }
  const std::vector<Vec3>& own = loaded->cells[cell].vertices;
  return own.empty() ? nullptr : &own;
}

Placement HeldCells::placement(std::size_t cell) const {
  return packing ? packing->cells[cell].placement : placementOf(lineOf(loaded->cells[cell]));
}

std::shared_ptr<const Request> HeldCells::request() const {
  return packing ? packing->problem->request.asked : requestOfCells(*loaded, file);
}

py::array positionsOf(const PythonPacking& packing) {
  const Held& held = packing.held;
  const auto stride = held->packing ? sizeof(Pose) : sizeof(Cell);
  return readOnly(py::array_t<double>({py::ssize_t(held->size()), py::ssize_t(3)}, {stride, sizeof(double)},
                                      held->size() == 0 ? nullptr : held->pose(0).position.data(),
                                      keepAlive(held)));
}

py::array rotationsOf(const PythonPacking& packing) {
  const Held& held = packing.held;
  const auto stride = held->packing ? sizeof(Pose) : sizeof(Cell);
  return readOnly(py::array_t<double>({py::ssize_t(held->size()), py::ssize_t(4)}, {stride, sizeof(double)},
                                      held->size() == 0 ? nullptr : held->pose(0).orientation.coeffs().data(),
                                      keepAlive(held)));
}

py::array_t<std::int32_t> speciesOf(const PythonPacking& packing) {
  const Held held = packing.held;
  py::array_t<std::int32_t> array(py::ssize_t(held->size()));
  std::int32_t* out = array.mutable_data();
  for (std::size_t i = 0; i < held->size(); ++i) *out++ = held->kind(i);
  return array;
}

py::array_t<double> verticesOf(const PythonPacking& packing, int species) {
  const Held held = packing.held;
  const std::vector<Vec3>& body = held->kinds.at(species).mesh.vertices;
  py::ssize_t count = 0;
  for (std::size_t i = 0; i < held->size(); ++i) count += held->kind(i) == species;
  py::array_t<double> array({count, py::ssize_t(body.size()), py::ssize_t(3)});
  double* out = array.mutable_data();
  for (std::size_t i = 0; i < held->size(); ++i) {
    if (held->kind(i) != species) continue;
    const std::vector<Vec3>* const own = held->ownVertices(i);
    const Placement placement = held->placement(i);
    for (const Vec3& vertex : own ? *own : body)
      for (const double x : Vec3(placement(vertex))) *out++ = x;
  }
  return array;
}

py::tuple templateOf(const PythonPacking& packing, int species) {
  const Held held = packing.held;
  return arraysOf(held->kinds.at(species).mesh);
}
