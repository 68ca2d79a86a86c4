// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/state_request.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/settings/request_json.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// The folder of a state with "/" at its end.
std::string folderOf(const fs::path& state) {
  return (fs::absolute(state).lexically_normal().parent_path() / "").string();
}

bool isUtf8(const Json& text) {
  try {
    static_cast<void>(text.dump());
    return true;
  } catch (const Json::type_error&) {
    return false;
  }
}

/// Replaces texts in JSON.
template <class Replace>
Json mapped(const Json& json, const Replace& replace) {
  if (auto replaced = replace(json)) return *replaced;
  if (!json.is_structured()) return json;
  Json all = json.is_array() ? Json::array() : Json::object();
  for (const auto& [key, value] : json.items()) {
    if (json.is_array())
      all.push_back(mapped(value, replace));
    else
      all[key] = mapped(value, replace);
  }
  return all;
}

std::optional<Json> stored(const Json& json, const std::string& folder) {
  if (!json.is_string()) return {};
  const std::string text = json.get<std::string>();
  if (text.size() > folder.size() && text.compare(0, folder.size(), folder) == 0)
    return Json{
        {"beside", stored(Json(text.substr(folder.size())), folder).value_or(text.substr(folder.size()))}};
  if (isUtf8(json)) return {};
  return Json{{"bytes", std::vector<unsigned char>(text.begin(), text.end())}};
}

std::optional<Json> now(const Json& json, const std::string& folder) {
  if (!json.is_object() || json.size() != 1) return {};
  if (const auto bytes = json.find("bytes"); bytes != json.end() && bytes->is_array()) {
    std::string text;
    for (const Json& byte : *bytes)
      if (byte.is_number_unsigned()) text += static_cast<char>(byte.get<unsigned>());
    return Json(text);
  }
  const auto beside = json.find("beside");
  if (beside == json.end()) return {};
  const Json path = now(*beside, folder).value_or(*beside);
  return path.is_string() ? std::optional<Json>(folder + path.get<std::string>()) : std::nullopt;
}

/// The numbers of a record. Those of a table are "<key>\n<name>".
Gifts giftsIn(const StateRecord& record) {
  std::map<std::string, Given> all;
  for (const StateTable& input : record.inputs) {
    const std::size_t end = input.name.find('\n');
    if (end == std::string::npos) continue;
    Given& given = all[input.name.substr(0, end)];
    given.tables.push_back({input.name.substr(end + 1), input.columns, input.values});
  }
  Gifts gifts;
  for (auto& [key, given] : all) {
    given.key = "of the state: " + key;  // unlike those of a request that overrides that of the state
    given.what = key;
    gifts[key] = std::make_shared<const Given>(std::move(given));
  }
  return gifts;
}

}  // namespace

StateRecord recordOf(const Request& request, const fs::path& state) {
  StateRecord record;
  Json json = toJson(request);
  json.erase("restart");
  const std::string folder = folderOf(state);
  record.request = mapped(json, [&](const Json& one) { return stored(one, folder); }).dump();
  for (const auto& [key, given] : giftsOf(request))
    for (const StateTable& table : given->tables)
      record.inputs.push_back({key + "\n" + table.name, table.columns, table.values});
  return record;
}

Request requestIn(const StateRecord& record, const fs::path& state) {
  if (!record.origin.empty())
    throw InputError(
        fmt::format("{}: has the cells of a simulation, and no packing to continue: {}, {} and {} take them",
                    state.string(), named("start"), named("fixed"), named("blood")));
  if (record.request.empty())
    throw InputError(
        state.string() +
        ": is of an earlier version of packMesh, which reads what was asked for; this version reads "
        "its cells and templates");
  const Json json = Json::parse(record.request, nullptr, false);
  if (json.is_discarded()) throw InputError(state.string() + ": is damaged: its request is not JSON");
  const std::string folder = folderOf(state);
  return located(state.string(), [&] {
    return withJson({}, mapped(json, [&](const Json& one) { return now(one, folder); }),
                    {Origin::Kind::state, ""}, giftsIn(record));
  });
}

}  // namespace packmesh::hemocell
