// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The single declaration of all options and tags of `<packing>`: parsing, range checks, error
/// messages, `--help` and the reference are derived from it.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

enum class Topic { cells, lumen, packing, limits, output, ignored };

/// A setting: its option and its tag (either can be empty), its values, and where they are stored.
///
/// Parsing, JSON, ranges, messages, `--help`, the manual page, completion, the reference and the
/// configuration in reports are derived from it.
struct Setting {
  std::string option;  ///< without dashes
  std::string tag;     ///< child of `<packing>`
  std::vector<ValueSpec> values;
  std::string help;
  std::function<void(Request&, const std::vector<Value>&)> store;
  /// Current value of the setting; empty function if it is not a single value.
  std::function<std::optional<Value>(const Request&)> get = {};
  /// The values as they would be stated, once or (mayRepeat) several times; empty function: `get` has them,
  /// or the setting is another way to state values of other keys.
  std::function<std::vector<std::vector<Value>>(const Request&)> getAll = {};
  std::string otherKey = {};  ///< the key of what it states, if that is not its own
  std::vector<std::string> attributes =
      {};                     ///< that it states of the cell of `countOf` or of its first value
  std::string fallback = {};  ///< the default as text
  std::string countOf = {};   ///< the cell whose number it is
  Topic topic = Topic::cells;
  char letter = 0;                          ///< short option, 0: none
  bool packCells = false;                   ///< packCells has this option, too: its prefixes take precedence
  bool repeats = false;                     ///< the tag can occur several times
  bool packingOnly = false;                 ///< `check` rejects the option
  std::optional<Method::Kind> method = {};  ///< the only method it applies to; empty: all

  const std::string& name() const { return option.empty() ? tag : option; }
  /// What its value is called in JSON and in Request::origins: its tag, or as one would be called.
  std::string key() const;
  /// Whether the value of its key is written by this setting.
  bool isWritten() const { return otherKey.empty() && attributes.empty() && (get || getAll); }
  bool isFlag() const { return values[0].kind == Kind::boolean; }  ///< the option needs no value
  /// Stores the values, and where they are from.
  void apply(Request& settings, const std::vector<Value>& given, const Origin& from) const;

  Setting& byDefault(std::string words) {
    fallback = std::move(words);
    return *this;
  }
  Setting& withTag(std::string name) {
    tag = std::move(name);
    return *this;
  }
  Setting& withoutTag() { return withTag(""); }
  Setting& withLetter(char shortOption) {
    letter = shortOption;
    return *this;
  }
  Setting& alsoOfPackCells() {
    packCells = true;
    return *this;
  }
  Setting& mayRepeat() {
    repeats = true;
    return *this;
  }
  Setting& writtenBy(std::function<std::vector<std::vector<Value>>(const Request&)> all) {
    getAll = std::move(all);
    return *this;
  }
  Setting& readBy(std::function<std::optional<Value>(const Request&)> value) {
    get = std::move(value);
    return *this;
  }
  /// It is another way to state the value of this key.
  Setting& statesKey(std::string key) {
    otherKey = std::move(key);
    return *this;
  }
  Setting& ofCell(std::vector<std::string> names) {
    attributes = std::move(names);
    return *this;
  }
  /// `check` rejects this option, because it requests something that check does not do. All other options of
  /// packing are accepted and ignored, so that a command can be repeated with `check`.
  Setting& notForCheck() {
    packingOnly = true;
    return *this;
  }
  Setting& onlyFor(Method::Kind one) {
    method = one;
    return *this;
  }
};

/// Name of the tag that belongs to an option: "maxTime" for "max-time".
std::string tagOf(const std::string& option);

/// A setting without tag, with one or more values that `store` saves.
inline Setting setting(std::string option, std::vector<ValueSpec> values, std::string help,
                       std::function<void(Request&, const std::vector<Value>&)> store) {
  return {std::move(option), "", std::move(values), std::move(help), std::move(store)};
}

/// The part of a request that has the members of class Part.
template <class Part, class Whole>
auto& partOf(Whole& request) {
  if constexpr (std::is_same_v<Part, OutputRequest>)
    return request.output;
  else if constexpr (std::is_same_v<Part, CatSettings>)
    return request.cat;
  else
    return request;
}

/// A setting stored in a member, with an option and a tag; its default is that of the member.
template <class Part, class T>
Setting setting(const std::string& option, T Part::*member, ValueSpec value, std::string help) {
  Setting made = setting(option, {std::move(value)}, std::move(help), [member](Request& r, const auto& v) {
    partOf<Part>(r).*member = fromValue<T>(v[0]);
  });
  made.tag = tagOf(option);
  made.get = [member](const Request& r) { return toValue(partOf<Part>(r).*member); };
  if (const auto byDefault = made.get({})) made.fallback = toText(*byDefault);
  return made;
}

/// A member with one of several named values.
template <class Part, class T>
Setting choiceSetting(const std::string& option, T Part::*member, const char* placeholder,
                      std::vector<std::pair<const char*, T>> choices, std::string help) {
  ValueSpec spec;
  spec.kind = Kind::choice;
  spec.placeholder = placeholder;
  for (const auto& [name, value] : choices) spec.choices.emplace_back(name);
  Setting made = setting(option, {spec}, std::move(help), [member, choices](Request& s, const auto& v) {
    for (const auto& [name, value] : choices)
      if (std::get<std::string>(v[0]) == name) partOf<Part>(s).*member = value;
  });
  made.tag = tagOf(option);
  made.get = [member, choices](const Request& s) -> std::optional<Value> {
    for (const auto& [name, value] : choices)
      if (partOf<Part>(s).*member == value) return std::string(name);
    return {};
  };
  made.fallback = toText(*made.get({}));
  return made;
}

std::vector<Setting> cellSettings();
std::vector<Setting> lumenSettings();
std::vector<Setting> methodSettings();
/// Of Method::cat, and the choice of the method.
std::vector<Setting> catSettings();
/// Of Method::cat, among those of the output.
Setting framesSetting();
std::vector<Setting> limitSettings();
std::vector<Setting> outputSettings();
/// Options of packCells that packMesh accepts and ignores.
std::vector<Setting> ignoredSettings();

/// All settings, in the order of the help.
const std::vector<Setting>& settingsTable();

/// The option that states a key, as messages name it; of keys without option the key.
std::string optionOf(const std::string& key);

/// Where a key was stated, with which messages begin: "config.xml:12: <walls>", "option '--walls'".
std::string whereStated(const Request& request, const std::string& key);

/// Refuses a value that is stated. @throws InputError if a section states it, else UsageError
[[noreturn]] void refuseStated(const Request& request, const std::string& key, const std::string& reason);

/// @throws UsageError for settings that exclude each other, or the lumen
void requireConsistent(const Request& request);

}  // namespace packmesh::hemocell
