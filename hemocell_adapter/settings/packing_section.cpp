// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/packing_section.h"

// Parser of `<packing>`.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <unordered_set>

#include "hemocell_adapter/base/xml_tags.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

using tinyxml2::XMLElement;
namespace fs = std::filesystem;

std::string didYouMean(const std::string& name, const std::vector<std::string>& known) {
  const auto nearest = nearestName(name, known);
  if (nearest) return fmt::format("did you mean '{}'?", *nearest);
  return fmt::format("expected one of {}", fmt::join(known, ", "));
}

template <typename Table>
std::vector<std::string> names(const Table& table) {
  std::vector<std::string> all;
  for (const auto& row : table) all.emplace_back(row.name);
  return all;
}

/// Applies the attributes of `element` by `table`. @param stated called with the name of each, and its place
template <typename Table, typename Target, typename Stated>
void readAttributes(const XMLElement& element, const Table& table, Target& target, const fs::path& file,
                    const Stated& stated) {
  for (const auto* attribute = element.FirstAttribute(); attribute; attribute = attribute->Next()) {
    bool known = false;
    for (const auto& row : table) {
      if (row.name != attribute->Name()) continue;
      known = true;
      const std::string place = fmt::format("{}, attribute {}", placeOf(element, file), row.name);
      located(place, [&] { row.apply(target, parseValue(row.value, attribute->Value())); });
      stated(row.name, place);
    }
    if (!known) {
      throw InputError(fmt::format("{}: unknown attribute '{}'; {}", placeOf(element, file),
                                   attribute->Name(), didYouMean(attribute->Name(), names(table))));
    }
  }
}

constexpr auto unrecorded = [](const std::string&, const std::string&) {};

void require(const XMLElement& element, const std::string& attribute, const ValueSpec& spec,
             const fs::path& file) {
  if (element.Attribute(attribute.c_str())) return;
  throw InputError(fmt::format("{}: the attribute {} is missing; expected {}", placeOf(element, file),
                               attribute, expectation(spec)));
}

void refuseContent(const XMLElement& element, const fs::path& file) {
  if (element.FirstChildElement() || !trimmed(textOf(element)).empty()) {
    throw InputError(fmt::format("{}: must be empty; its values are attributes: <{} name=\"...\"/>",
                                 placeOf(element, file), element.Name()));
  }
}

/// `hint(name)` states what to write instead of the attribute `name`.
template <typename Hint>
void refuseAttributes(const XMLElement& element, const fs::path& file, Hint&& hint) {
  if (const auto* attribute = element.FirstAttribute()) {
    throw InputError(fmt::format("{}: unknown attribute '{}'; {}", placeOf(element, file), attribute->Name(),
                                 hint(attribute->Name(), attribute->Value())));
  }
}

/// For a tag whose value is its text.
void refuseAttributes(const XMLElement& element, const fs::path& file) {
  refuseAttributes(element, file, [&](const char*, const char* value) {
    return fmt::format("expected <{0}> {1} </{0}>", element.Name(), value);
  });
}

void refuseText(const XMLElement& element, const fs::path& file) {
  const std::string text = trimmed(textOf(element));
  if (!text.empty()) throw InputError(fmt::format("{}: stray text '{}'", placeOf(element, file), text));
}

/// @param request to which the origins of the attributes are added
SpeciesRequest readSpecies(const XMLElement& element, Request& request, const fs::path& file) {
  require(element, "name", speciesAttributes().front().value, file);
  refuseContent(element, file);
  SpeciesRequest species;
  Origins origins;
  readAttributes(element, speciesAttributes(), species, file,
                 [&](const std::string& name, const std::string& place) {
                   origins[name] = {Origin::Kind::section, place};
                 });
  for (const auto& [name, origin] : origins) request.origins[keyOfSpecies(species.name, name)] = origin;
  refuseBoth([&](const char* name) { return element.Attribute(name) != nullptr; }, placeOf(element, file));
  for (auto* const source : {&species.meshFile, &species.fixed, &species.start})
    if (*source) **source = file.parent_path() / (*source)->file;
  return species;
}

SolidRequest readSolid(const XMLElement& element, bool ofRegion, const std::vector<std::string>& alsoKnown,
                       const fs::path& file) {
  std::vector<std::string> known;
  for (const SolidTag& tag : solidTags()) {
    if (tag.ofRegions && !ofRegion) continue;
    known.emplace_back(tag.name);
    if (std::string(tag.name) != element.Name()) continue;
    SolidRequest solid;
    solid.kind = tag.kind;
    solid.where = placeOf(element, file);
    for (const auto& attribute : tag.attributes) {
      if (attribute.fallback.empty()) require(element, attribute.name, attribute.value, file);
    }
    refuseContent(element, file);
    readAttributes(element, tag.attributes, solid, file, unrecorded);
    if (solid.kind == SolidRequest::Kind::mesh) solid.file = file.parent_path() / solid.file.file;
    return solid;
  }
  known.insert(known.end(), alsoKnown.begin(), alsoKnown.end());
  throw InputError(
      fmt::format("{}: unknown tag; {}", placeOf(element, file), didYouMean(element.Name(), known)));
}

ContainerRequest readContainer(const XMLElement& element, const fs::path& file) {
  ContainerRequest container;
  const auto bodiesHaveAttributes = [](const char*, const char*) {
    return "expected <box>, <cylinder>, <sphere> or <mesh> inside, with attributes";
  };
  refuseAttributes(element, file, bodiesHaveAttributes);
  refuseText(element, file);
  for (const XMLElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    if (name == "obstacles") {
      refuseAttributes(*child, file, bodiesHaveAttributes);
      refuseText(*child, file);
      for (const XMLElement* solid = child->FirstChildElement(); solid; solid = solid->NextSiblingElement()) {
        container.obstacles.push_back(readSolid(*solid, false, {}, file));
      }
    } else if (name == "nodes") {
      refuseAttributes(*child, file);
      container.nodes = std::get<Vec3>(valueOf(*child, specs::latticeNodes(), file));
    } else if (container.lumen) {
      throw InputError(
          fmt::format("{}: second body; a container has one body, from which <obstacles> are subtracted",
                      placeOf(*child, file)));
    } else {
      container.lumen = readSolid(*child, false, {"obstacles", "nodes"}, file);
    }
  }
  return container;
}

/// The value of a tag, or several values separated by blanks.
std::vector<Value> valuesOf(const XMLElement& element, const std::vector<ValueSpec>& specs,
                            const fs::path& file) {
  if (specs.size() == 1) return {valueOf(element, specs[0], file)};
  std::istringstream text(textOf(element));
  std::vector<std::string> words;
  for (std::string word; text >> word;) words.push_back(word);
  return located(placeOf(element, file), [&] {
    std::vector<Value> values;
    for (std::size_t i = 0; i < specs.size(); ++i)
      values.push_back(parseValue(specs[i], i < words.size() ? words[i] : ""));
    if (words.size() > specs.size())
      throw InputError(fmt::format("expected {} values, found {}", specs.size(), words.size()));
    return values;
  });
}

RegionSpecies readRegionSpecies(const XMLElement& element, const fs::path& file) {
  for (const auto& row : regionSpeciesAttributes()) require(element, row.name, row.value, file);
  refuseContent(element, file);
  RegionSpecies species;
  readAttributes(element, regionSpeciesAttributes(), species, file, unrecorded);
  return species;
}

RegionRequest readRegion(const XMLElement& element, const fs::path& file) {
  RegionRequest region;
  readAttributes(element, regionAttributes(), region, file, unrecorded);
  refuseText(element, file);
  int bodies = 0;
  for (const XMLElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (std::string(child->Name()) == "species") {
      region.species.push_back(readRegionSpecies(*child, file));
      continue;
    }
    region.body = readSolid(*child, true, {"species"}, file);
    ++bodies;
  }
  if (bodies != 1) {
    std::vector<std::string> tags;
    for (const SolidTag& tag : solidTags()) tags.push_back(fmt::format("<{}>", tag.name));
    throw InputError(fmt::format("{}: expected one body inside: {} or {}", placeOf(element, file),
                                 fmt::join(tags.begin(), tags.end() - 1, ", "), tags.back()));
  }
  examineRegion(region, placeOf(element, file));
  return region;
}

/// Applies a setting that a tag states. Paths of input files are relative to the section's.
void apply(const Setting& setting, const XMLElement& tag, Request& settings, const fs::path& file) {
  refuseAttributes(tag, file);
  std::vector<Value> values = valuesOf(tag, setting.values, file);
  if (setting.tag == "fixed" || setting.tag == "start" ||
      (setting.tag == "profile" && std::get<std::string>(values[0]) != developedProfile))
    values[0] = (file.parent_path() / std::get<std::string>(values[0])).string();
  setting.apply(settings, values, {Origin::Kind::section, placeOf(tag, file)});
}

}  // namespace

Request readPackingSection(const XMLElement& packing, const fs::path& file) {
  Request settings;
  std::unordered_set<std::string> named;  // species
  std::vector<std::string> known = {"species", "container", catTag, "region"};
  for (const Setting& setting : settingsTable()) {
    if (!setting.tag.empty()) known.push_back(setting.tag);
  }
  refuseText(packing, file);
  refuseAttributes(packing, file, [&](const char* name, const char* value) {
    if (std::find(known.begin(), known.end(), name) == known.end()) return didYouMean(name, known);
    return fmt::format("write it as a tag inside: <{0}> {1} </{0}>", name, value);
  });
  for (const XMLElement* child = packing.FirstChildElement(); child; child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    if (name == "species") {
      const SpeciesRequest species = readSpecies(*child, settings, file);
      if (!named.insert(species.name).second) {
        throw InputError(
            fmt::format("{}: a second species called '{}' (<fixed> and <start> must come after <species>)",
                        placeOf(*child, file), species.name));
      }
      speciesNamed(settings, species.name) = species;
      continue;
    }
    if (name == "region") {
      settings.regions.push_back(readRegion(*child, file));
      settings.origins.insert({"regions", {Origin::Kind::section, placeOf(*child, file)}});
      continue;
    }
    const Setting* found = nullptr;
    for (const Setting& setting : settingsTable()) {
      if (!setting.tag.empty() && name == setting.tag) found = &setting;
    }
    if (!found || !found->repeats) onlyChild(packing, child->Name(), file);
    if (name == "container") {
      settings.container = readContainer(*child, file);
      settings.origins[name] = {Origin::Kind::section, placeOf(*child, file)};
      continue;
    }
    if (name == catTag) {
      refuseContent(*child, file);
      settings.origins[name] = {Origin::Kind::section, placeOf(*child, file)};
      readAttributes(*child, catParameters(), settings.cat.growth, file,
                     [&](const std::string& parameter, const std::string& place) {
                       settings.origins[name + "." + parameter] = {Origin::Kind::section, place};
                     });
      continue;
    }
    if (!found) {
      throw InputError(
          fmt::format("{}: unknown tag in <packing>; {}", placeOf(*child, file), didYouMean(name, known)));
    }
    apply(*found, *child, settings, file);
    if ((name == "fixed" || name == "start") && !isState(trimmed(textOf(*child))))
      named.insert(settings.species.back().name);
  }
  if (settings.output.stateFile) *settings.output.stateFile = file.parent_path() / *settings.output.stateFile;
  if (!settings.output.folder.empty()) settings.output.folder = file.parent_path() / settings.output.folder;
  return settings;
}

}  // namespace packmesh::hemocell
