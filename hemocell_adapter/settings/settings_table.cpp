// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/settings_table.h"

#include <fmt/format.h>

#include <cctype>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/settings/attribute_tables.h"

namespace packmesh::hemocell {

std::string tagOf(const std::string& option) {
  std::string tag;
  for (std::size_t i = 0; i < option.size(); ++i) {
    if (option[i] == '-' && i + 1 < option.size())
      tag += static_cast<char>(std::toupper(static_cast<unsigned char>(option[++i])));
    else
      tag += option[i];
  }
  return tag;
}

std::string Setting::key() const {
  if (!otherKey.empty()) return otherKey;
  return tag.empty() ? tagOf(option) : tag;
}

void Setting::apply(Request& settings, const std::vector<Value>& given, const Origin& from) const {
  store(settings, given);
  if (attributes.empty()) {
    std::string stated = key();
    if (stated == catTag) stated += "." + std::get<std::string>(given[0]);
    if (stated == "fixed" || stated == "start")
      if (const Source source = sourceIn(given[0]); !isState(source) && !source.given)
        stated = keyOfSpecies(source.file.stem().string(), stated);
    settings.origins[stated] = from;
    return;
  }
  const std::string& cell = countOf.empty() ? std::get<std::string>(given[0]) : countOf;
  for (const std::string& attribute : attributes) settings.origins[keyOfSpecies(cell, attribute)] = from;
}

const std::vector<Setting>& settingsTable() {
  static const std::vector<Setting> table = [] {
    const std::pair<Topic, std::vector<Setting>> groups[] = {
        {Topic::cells, cellSettings()},     {Topic::lumen, lumenSettings()},
        {Topic::packing, catSettings()},    {Topic::packing, methodSettings()},
        {Topic::limits, limitSettings()},   {Topic::output, outputSettings()},
        {Topic::ignored, ignoredSettings()}};
    std::vector<Setting> all;
    for (const auto& [topic, settings] : groups)
      for (Setting setting : settings) {
        setting.topic = topic;
        all.push_back(std::move(setting));
      }
    return all;
  }();
  return table;
}

std::string optionOf(const std::string& key) {
  for (const Setting& setting : settingsTable())
    if (setting.key() == key && !setting.option.empty()) return setting.option;
  return key;
}

std::string whereStated(const Request& request, const std::string& key) {
  const Origin* const origin = request.originOf(key);
  return origin && !origin->place.empty() ? origin->place : heading(optionOf(key));
}

void refuseStated(const Request& request, const std::string& key, const std::string& reason) {
  const std::string text = whereStated(request, key) + ": " + reason;
  if (const Origin* const origin = request.originOf(key); origin && origin->isSection())
    throw InputError(text);
  throw UsageError(text);
}

void requireConsistent(const Request& request) {
  const bool ownBody = request.container && request.container->lumen;
  if (request.boxSize && ownBody)
    throw UsageError(fmt::format("{} excludes {}, {} and {}", named("box"), named("cylinder"),
                                 named("sphere"), named("vessel")));
  if (request.boxSize && request.config)
    throw UsageError(fmt::format("sizes {} exclude a case", named("box")));
  if (!request.config)
    for (const SpeciesRequest& species : request.species)
      if (species.minimumDistanceFromSolid)
        throw UsageError(fmt::format("{} requires a case: without a config.xml there are no solid nodes",
                                     heading("minimum-distance-from-solid")));
  if (!request.config) return;
  for (const char* boxOnly : {"dx", "keep-all"})
    if (request.states(tagOf(boxOnly)))
      throw UsageError(fmt::format("{} is for boxes; a case specifies this in config.xml", heading(boxOnly)));
}

}  // namespace packmesh::hemocell
