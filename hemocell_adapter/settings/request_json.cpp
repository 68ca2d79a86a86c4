// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/request_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {
namespace {

Json jsonOf(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

bool isStated(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found != object.end() && !found->is_null();
}

const Setting* settingOf(const std::string& key) {
  for (const Setting& setting : settingsTable())
    if (setting.isWritten() && setting.key() == key) return &setting;
  return nullptr;
}

/// Applies JSON to a request.
class Statement {
 public:
  Statement(Request& request, const Origin& from, const MemoryInputs& gifts)
      : request_(request), from_(from), gifts_(gifts) {}

  void apply(const Json& json) {
    if (!json.is_object()) refuse("a request", "expected a JSON object");
    for (const char* const* pair : {eitherHematocrit, otherHematocrit})
      if (isStated(json, pair[0]) && !isStated(json, pair[1])) forget(pair[1]);
    // Species come first: files of existing cells add species after those that are stated.
    if (isStated(json, "species")) species(json["species"]);
    for (const auto& [key, value] : json.items())
      if (!value.is_null() && key != "species") member(key, value);
  }

 private:
  static constexpr const char* eitherHematocrit[] = {"hematocrit", "dischargeHematocrit"};
  static constexpr const char* otherHematocrit[] = {"dischargeHematocrit", "hematocrit"};

  void forget(const std::string& key) {
    (key == "hematocrit" ? request_.hematocrit : request_.dischargeHematocrit).reset();
    request_.origins.erase(key);
  }

  [[noreturn]] void refuse(const std::string& where, const std::string& reason) const {
    if (from_.kind == Origin::Kind::state) throw InputError(where + ": " + reason);
    throw UsageError(where + ": " + reason);
  }

  template <class Work>
  auto at(const std::string& where, Work&& work) const {
    if (from_.kind == Origin::Kind::state) return located<InputError>(where, work);
    return located<UsageError>(where, work);
  }

  void member(const std::string& key, const Json& value) {
    if (key == "config") {
      request_.config = textOf(value);
      request_.origins[key] = from_;
    } else if (key == "packCells") {
      request_.packCellsConventions = std::get<bool>(valueIn(specs::flag(), value, key));
    } else if (key == "box") {
      request_.boxSize = std::get<Vec3>(valueIn(specs::vector("", 0, true), value, heading(key)));
    } else if (key == catTag) {
      cat(value);
    } else if (key == "container") {
      container(value);
    } else if (key == "regions") {
      regions(value);
    } else if (const Setting* const known = settingOf(key)) {
      setting(*known, value);
    } else {
      refuse(key, "is no setting");
    }
  }

  Value valueIn(const ValueSpec& spec, const Json& json, const std::string& where) const {
    if (json.is_object() && json.contains("given") && spec.kind == Kind::text) {
      const auto numbers = gifts_.find(textOf(json["given"]));
      if (numbers == gifts_.end()) refuse(where, "its numbers are missing");
      return numbers->second;
    }
    return at(where, [&] { return parseValue(spec, textOf(json)); });
  }

  void setting(const Setting& row, const Json& json) {
    const std::string where = heading(optionOf(row.key()));
    if (!row.repeats) return row.apply(request_, valuesIn(row, json, where), from_);
    if (!json.is_array()) refuse(where, "expected a list, found " + textOf(json));
    for (const Json& one : json) row.apply(request_, valuesIn(row, one, where), from_);
  }

  std::vector<Value> valuesIn(const Setting& row, const Json& json, const std::string& where) const {
    if (row.values.size() == 1) return {valueIn(row.values[0], json, where)};
    if (!json.is_array() || json.size() != row.values.size())
      refuse(where, fmt::format("expected {} values, found {}", row.values.size(), textOf(json)));
    std::vector<Value> values;
    for (std::size_t i = 0; i < json.size(); ++i) values.push_back(valueIn(row.values[i], json[i], where));
    return values;
  }

  /// The attributes of an object by their table. @param name of the attribute for messages
  template <class T, class Name, class Stated>
  void attributes(const std::vector<Attribute<T>>& table, const Json& json, T& target, const Name& name,
                  const Stated& stated) {
    for (const auto& [key, value] : json.items()) {
      const auto row = std::find_if(table.begin(), table.end(),
                                    [&, k = &key](const Attribute<T>& a) { return a.name == *k; });
      if (row == table.end()) refuse(name(key), "is no attribute");
      if (value.is_null()) continue;
      for (const std::string& other : row->replaces)
        if (!isStated(json, other)) {
          const auto replaced = std::find_if(table.begin(), table.end(),
                                             [&](const Attribute<T>& a) { return a.name == other; });
          replaced->clear(target);
        }
      row->apply(target, valueIn(row->value, value, name(key)));
      stated(key);
    }
  }

  void species(const Json& all) {
    if (!all.is_array()) refuse(heading("species"), "expected a list");
    for (const Json& one : all) {
      if (!one.is_object() || !isStated(one, "name")) refuse(heading("species"), "a name is missing");
      const std::string name = std::get<std::string>(valueIn(specs::name(), one["name"], heading("species")));
      const auto attribute = [&](const std::string& key) { return heading("species." + key, name); };
      refuseBoth([&](const char* key) { return isStated(one, key); }, heading("species", name));
      attributes(
          speciesAttributes(), one, speciesNamed(request_, name), attribute, [&](const std::string& key) {
            Origin& origin = request_.origins.try_emplace(keyOfSpecies(name, key), from_).first->second;
            if (key != "name") origin = from_;  // more about a species that is there already
          });
      for (const Attribute<SpeciesRequest>& row : speciesAttributes())  // of values that are replaced
        if (!row.get(*findSpecies(request_, name))) request_.origins.erase(keyOfSpecies(name, row.name));
    }
  }

  void cat(const Json& json) {
    if (!json.is_object()) refuse(heading(catTag), "expected parameters by name");
    attributes(
        catParameters(), json, request_.cat.growth,
        [](const std::string& key) { return heading(catTag, key); },
        [&](const std::string& key) { request_.origins[std::string(catTag) + "." + key] = from_; });
  }

  SolidRequest body(const Json& json, const std::string& where, const std::string& list,
                    const std::string& number) {
    const std::string kind = json.is_object() && isStated(json, "kind") ? textOf(json["kind"]) : "";
    for (const SolidTag& tag : solidTags()) {
      if (kind != tag.name || (tag.ofRegions && list != "regions")) continue;
      SolidRequest solid;
      solid.kind = tag.kind;
      solid.where = where;
      for (const Attribute<SolidRequest>& row : tag.attributes)
        if (row.fallback.empty() && !isStated(json, row.name))
          refuse(where, fmt::format("{} is missing; expected {}", row.name, expectation(row.value)));
      Json stated = json;
      stated.erase("kind");
      attributes(
          tag.attributes, stated, solid,
          [&](const std::string& key) {
            return number.empty() ? where + ", " + key : heading(list + "." + key, number);
          },
          [](const std::string&) {});
      return solid;
    }
    refuse(where, fmt::format("expected a body (box, cylinder, sphere or mesh), found {}", textOf(json)));
  }

  std::vector<SolidRequest> bodies(const Json& json, const std::string& list) {
    if (!json.is_array()) refuse(heading(list), "expected a list");
    std::vector<SolidRequest> all;
    for (const Json& one : json) {
      const std::string number = std::to_string(all.size());
      all.push_back(body(one, heading(list, number), list, number));
    }
    return all;
  }

  void lumen(const Json& json) {
    auto& lumen = request_.container->lumen;
    if (!isStated(json, "kind")) {  // a detail of the one that is known
      if (!lumen) lumen.emplace().kind = SolidRequest::Kind::mesh;
      if (lumen->where.empty()) lumen->where = heading("open-axis");
      if (isStated(json, "openAxis"))
        lumen->openAxis = int(std::get<std::int64_t>(
            valueIn(specs::plain(Kind::axis, ""), json["openAxis"], heading("open-axis"))));
      return;
    }
    const std::string kind = textOf(json["kind"]);
    lumen = body(json, heading(kind == "mesh" ? "vessel" : kind), "", "");
  }

  void container(const Json& json) {
    if (!json.is_object()) refuse("container", "expected an object");
    if (!request_.container) request_.container.emplace();
    for (const auto& [key, value] : json.items()) {
      if (value.is_null()) continue;
      if (key == "lumen")
        lumen(value);
      else if (key == "obstacles")
        request_.container->obstacles = bodies(value, key);
      else if (key == "nodes")
        request_.container->nodes = std::get<Vec3>(valueIn(specs::latticeNodes(), value, "nodes"));
      else
        refuse("container", fmt::format("'{}' is unknown", key));
    }
    request_.origins["container"] = from_;
  }

  void regions(const Json& json) {
    if (!json.is_array()) refuse(heading("regions"), "expected a list");
    request_.regions.clear();
    for (const Json& one : json) {
      const std::string number = std::to_string(request_.regions.size());
      const std::string where = heading("regions", number);
      if (!one.is_object() || !isStated(one, "body")) refuse(where, "expected a body");
      RegionRequest region;
      Json values = one;
      values.erase("body");
      values.erase("species");
      attributes(
          regionAttributes(), values, region,
          [&](const std::string& key) { return heading("regions." + key, number); },
          [](const std::string&) {});
      region.body = body(one["body"], where, "regions", number);
      if (isStated(one, "species")) {
        if (!one["species"].is_array()) refuse(where, "expected a list of species");
        for (const Json& species : one["species"])
          region.species.push_back(regionSpecies(species, heading("regions.species", number)));
      }
      examineRegion(region, where);
      request_.regions.push_back(std::move(region));
    }
    request_.origins["regions"] = from_;
  }

  RegionSpecies regionSpecies(const Json& json, const std::string& where) {
    RegionSpecies species;
    for (const auto& row : regionSpeciesAttributes())
      if (!json.is_object() || !isStated(json, row.name)) refuse(where, "expected a name and a count");
    attributes(
        regionSpeciesAttributes(), json, species,
        [&](const std::string& key) { return fmt::format("{}, {}", where, key); }, [](const std::string&) {});
    return species;
  }

  Request& request_;
  const Origin& from_;
  const MemoryInputs& gifts_;
};

template <class T>
void addAttributes(Json& json, const std::vector<Attribute<T>>& table, const T& of) {
  for (const Attribute<T>& row : table) {
    const std::optional<Value> value = row.get(of);
    json[row.name] = value ? jsonOf(*value, row.value) : Json(nullptr);
  }
}

/// Of all values, those that are stated.
Json stated(const Json& all) {
  Json some = Json::object();
  for (const auto& [key, value] : all.items())
    if (!value.is_null()) some[key] = value;
  return some;
}

/// Not only a detail of one that is stated elsewhere.
bool isBody(const SolidRequest& lumen) {
  return lumen.kind != SolidRequest::Kind::mesh || !lumen.file.empty();
}

Json jsonOfLumen(const SolidRequest& lumen) {
  const Json all = stated(jsonOf(lumen));
  if (isBody(lumen)) return all;
  return lumen.openAxis ? Json{{"openAxis", all["openAxis"]}} : Json::object();
}

Json jsonOf(const ContainerRequest& container) {
  Json json = Json::object();
  if (container.lumen) json["lumen"] = jsonOfLumen(*container.lumen);
  for (const SolidRequest& obstacle : container.obstacles)
    json["obstacles"].push_back(stated(jsonOf(obstacle)));
  if (container.nodes) json["nodes"] = jsonOf(*container.nodes);
  return json;
}

/// Of one entry of a setting.
Json jsonOf(const Setting& setting, const std::vector<Value>& values) {
  if (values.size() == 1) return jsonOf(values[0], setting.values[0]);
  Json all = Json::array();
  for (std::size_t i = 0; i < values.size(); ++i) all.push_back(jsonOf(values[i], setting.values[i]));
  return all;
}

Json jsonOf(const Setting& setting, const Request& request) {
  if (setting.get) {
    const std::optional<Value> value = setting.get(request);
    return value ? jsonOf(*value, setting.values[0]) : Json(nullptr);
  }
  Json all = Json::array();
  for (const std::vector<Value>& entry : setting.getAll(request)) all.push_back(jsonOf(setting, entry));
  if (setting.repeats) return all.empty() ? Json(nullptr) : all;
  return all.front();
}

}  // namespace

std::string textOf(const Json& json) {
  if (json.is_string()) return json.get<std::string>();
  if (json.is_boolean()) return json.get<bool>() ? "true" : "false";
  if (json.is_number_float()) return fmt::format("{}", json.get<double>());
  if (json.is_object() && json.contains("given")) return textOf(json["given"]);
  std::string text;
  if (json.is_array()) {
    for (const Json& one : json) text += (text.empty() ? "" : " ") + textOf(one);
    return text;
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json jsonOf(const Value& value, const ValueSpec& spec) {
  if (spec.kind == Kind::axis) return std::string(1, "xyz"[std::get<std::int64_t>(value)]);
  if (spec.kind == Kind::plane) return toString(NodePlane(std::get<std::int64_t>(value)));
  if (spec.kind == Kind::axes && std::get<std::string>(value).empty()) return "none";
  return std::visit(
      [](const auto& v) -> Json {
        if constexpr (std::is_same_v<std::decay_t<decltype(v)>, Vec3>)
          return jsonOf(v);
        else if constexpr (std::is_same_v<std::decay_t<decltype(v)>, std::shared_ptr<const MemoryInput>>)
          return {{"given", v->key}};
        else
          return v;
      },
      value);
}

Json jsonOf(const SolidRequest& body) {
  Json json;
  for (const SolidTag& tag : solidTags())
    if (tag.kind == body.kind) {
      json["kind"] = tag.name;
      addAttributes(json, tag.attributes, body);
    }
  return json;
}

Json jsonOf(const RegionRequest& region) {
  Json json;
  addAttributes(json, regionAttributes(), region);
  json["body"] = jsonOf(region.body);
  json["species"] = Json::array();
  for (const RegionSpecies& species : region.species) {
    Json one;
    addAttributes(one, regionSpeciesAttributes(), species);
    json["species"].push_back(std::move(one));
  }
  return json;
}

Json toJson(const Request& request) {
  Json json = Json::object();
  if (request.config) json["config"] = request.config->string();
  if (request.boxSize) json["box"] = jsonOf(*request.boxSize);
  if (request.packCellsConventions) json["packCells"] = true;
  if (request.container) json["container"] = jsonOf(*request.container);
  for (const SpeciesRequest& species : request.species) {
    Json attributes;
    addAttributes(attributes, speciesAttributes(), species);
    json["species"].push_back(stated(attributes));
  }
  for (const RegionRequest& region : request.regions) {
    Json one = stated(jsonOf(region));
    one["body"] = stated(one["body"]);
    if (region.species.empty()) one.erase("species");
    json["regions"].push_back(std::move(one));
  }
  for (const auto& row : catParameters())
    if (request.origins.count(std::string(catTag) + "." + row.name) > 0)
      json[catTag][row.name] = jsonOf(*row.get(request.cat.growth), row.value);
  for (const Setting& setting : settingsTable())
    if (setting.isWritten() && request.states(setting.key())) json[setting.key()] = jsonOf(setting, request);
  return stated(json);
}

MemoryInputs memoryInputsOf(const Request& request) {
  MemoryInputs all;
  const auto add = [&](const Source& source) {
    if (source.given) all[source.given->key] = source.given;
  };
  const auto addOptional = [&](const std::optional<Source>& source) {
    if (source) add(*source);
  };
  for (const SpeciesRequest& species : request.species)
    for (const auto* source : {&species.meshFile, &species.fixed, &species.start}) addOptional(*source);
  for (const auto* states : {&request.fixedStates, &request.startStates})
    for (const Source& state : *states) add(state);
  addOptional(request.blood);
  addOptional(request.profile);
  for (const RegionRequest& region : request.regions) add(region.body.file);
  if (!request.container) return all;
  if (request.container->lumen) add(request.container->lumen->file);
  for (const SolidRequest& obstacle : request.container->obstacles) add(obstacle.file);
  return all;
}

Request withJson(Request base, const Json& json, const Origin& from, const MemoryInputs& gifts) {
  Statement(base, from, gifts).apply(json);
  return base;
}

Request overridden(Request base, const Request& by) {
  base = withJson(std::move(base), toJson(by), {}, memoryInputsOf(by));
  for (const auto& [key, origin] : by.origins) base.origins[key] = origin;
  const auto keepPlaces = [](const std::optional<ContainerRequest>& from,
                             std::optional<ContainerRequest>& to) {
    if (!from) return;
    if (from->lumen && isBody(*from->lumen)) to->lumen->where = from->lumen->where;
    for (std::size_t i = 0; i < from->obstacles.size(); ++i)
      to->obstacles[i].where = from->obstacles[i].where;
  };
  keepPlaces(by.container, base.container);
  for (std::size_t i = 0; i < by.regions.size(); ++i) base.regions[i].body.where = by.regions[i].body.where;
  base.remarks.insert(base.remarks.end(), by.remarks.begin(), by.remarks.end());
  base.words = by.words;
  return base;
}

}  // namespace packmesh::hemocell
