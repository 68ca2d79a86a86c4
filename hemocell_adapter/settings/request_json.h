// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Requests as JSON: what front ends exchange, and states store. By the tables of settings_table.h and
/// attribute_tables.h, as the reader of `<packing>`.
///
/// Members are named by Setting::key(), the tags of `<packing>` where there are some, and have the values
/// that a tag or an option would have: {"hematocrit": 0.3, "walls": "yz", "alsoDx": [0.25, 1]}. Besides:
/// "config" (file), "box" (three sizes [µm]), "packCells" (true: its conventions),
/// "species": [{"name": "RBC", and attributes of `<species>`}, ...],
/// catTag: {attributes of its tag},
/// "container": {"lumen": body, "obstacles": [bodies], "nodes": [three numbers]},
/// "regions": [{"hematocrit": 0.3, "body": body}, ...]; body: {"kind": "sphere", and attributes of its tag}.
/// Instead of a file, {"given": key} stands for numbers in memory.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

using Json = nlohmann::ordered_json;

/// All that the request states, and nothing else.
Json toJson(const Request& request);
/// The numbers that stand in it instead of files.
MemoryInputs memoryInputsOf(const Request& request);

/// The same request with other names of the files that it reads, but for that from which it continues.
Request withFiles(Request request,
                  const std::function<std::filesystem::path(const std::filesystem::path&)>& renamed);

/// `base`, overridden by what JSON states: a value replaces that of its key, and a value of another key that
/// says the same in another way (a hematocrit the discharge hematocrit, the count of a species its ratio).
/// Species are those of their names or added; a body or a list of bodies replaces that of `base`; files of
/// existing cells and exports are added to those of `base`.
/// @throws UsageError, or InputError if the origin is a state: for unknown keys and invalid values
Request withJson(Request base, const Json& json, const Origin& from, const MemoryInputs& gifts = {});

/// `base`, overridden by what the other request states, which keeps its origins.
Request overridden(Request base, const Request& by);

/// The text of a value, as an option or a tag has it. Numbers keep all digits.
std::string textOf(const Json& json);
/// A value as JSON. @param spec of it
Json jsonOf(const Value& value, const ValueSpec& spec);
/// A body with all its attributes; null: not stated.
Json jsonOf(const SolidRequest& body);
Json jsonOf(const RegionRequest& region);

}  // namespace packmesh::hemocell
