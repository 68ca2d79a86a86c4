// SPDX-License-Identifier: AGPL-3.0-or-later
#include "requests.h"

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
Json jsonOf(const py::handle& value, Gifts& gifts) {
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
    return std::move(all);
  }
  if (!json.is_object()) return py::none();
  py::dict all;
  for (const auto& [key, one] : json.items()) all[py::str(key)] = objectOf(one);
  return std::move(all);
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
  auto given = std::make_shared<Given>();
  given->key = of.empty() ? setting : setting + " " + of;
  given->what = heading(setting, of);
  given->tables = std::move(tables);
  return {std::move(given)};
}

Request requestOf(const py::dict& stated) {
  Gifts gifts;
  const Json json = jsonOf(stated, gifts);
  return withJson({}, json, {Origin::Kind::keyword, ""}, gifts);
}

py::object dictOf(const Request& request) {
  return objectOf(toJson(request));
}

py::object wordsIn(const Request& request) {
  return giftsOf(request).empty() ? objectOf(wordsOf(request)) : py::object(py::none());
}

void addRequests(py::module_& module) {
  setTerms(termOfPython);
  py::class_<PythonNumbers>(module, "Numbers").def(py::init(&numbers));
}
