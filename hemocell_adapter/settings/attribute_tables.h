// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Tables of the attributes of tags, used for parsing, the reference and reports.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/member_value.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

/// An attribute of a tag whose value is stored in a T.
template <class T>
struct Attribute {
  std::string name;
  ValueSpec value;
  std::string help;
  std::function<void(T&, const Value&)> apply;
  std::function<std::optional<Value>(const T&)> get = {};
  std::string fallback = {};           ///< the default as text; for bodies "" means required
  std::function<void(T&)> clear = {};  ///< back to the default
  /// Attributes that a later statement of this one replaces, with the other way to state the same.
  std::vector<std::string> replaces = {};

  Attribute& byDefault(std::string words) {
    fallback = std::move(words);
    return *this;
  }
  Attribute& required() { return byDefault(""); }
  Attribute& replacing(std::vector<std::string> others) {
    replaces = std::move(others);
    return *this;
  }
};

/// An attribute stored in a member; its default is that of the member.
template <class T, class M>
Attribute<T> attribute(std::string name, M T::*member, ValueSpec value, std::string help) {
  Attribute<T> made = {std::move(name), std::move(value), std::move(help),
                       [member](T& target, const Value& v) { target.*member = fromValue<M>(v); },
                       [member](const T& target) { return toValue(target.*member); }};
  if (const auto byDefault = made.get({})) made.fallback = toText(*byDefault);
  made.clear = [member](T& target) { target.*member = T().*member; };
  return made;
}

/// Attributes of `<species>`.
const std::vector<Attribute<SpeciesRequest>>& speciesAttributes();

/// Refuses two ways to state the same of a species. @param has whether an attribute is stated @param where
/// @throws InputError
void refuseBoth(const std::function<bool(const char*)>& has, const std::string& where);

/// Tag with the parameters of Method::cat as attributes; the option of this name sets one of them.
inline constexpr const char* catTag = "growth";
const std::vector<Attribute<GrowthSettings>>& catParameters();

/// Attributes of `<region>`, of which there is at most one, and of `<species>` in it.
const std::vector<Attribute<RegionRequest>>& regionAttributes();
const std::vector<Attribute<RegionSpecies>>& regionSpeciesAttributes();

/// Refuses a region that states nothing or contradicts itself. @throws InputError
void examineRegion(const RegionRequest& region, const std::string& where);

/// `<box>`, `<cylinder>`, `<sphere>`, `<mesh>` in `<container>`, `<obstacles>` or `<region>`; others in
/// `<region>` alone.
struct SolidTag {
  const char* name;
  SolidRequest::Kind kind;
  std::vector<Attribute<SolidRequest>> attributes;
  bool ofRegions = false;
};
const std::vector<SolidTag>& solidTags();

}  // namespace packmesh::hemocell
