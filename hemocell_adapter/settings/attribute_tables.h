// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Tables of the attributes of tags, used for parsing, the reference and reports.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell {

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

inline Source sourceIn(const Value& value) {
  if (const auto* numbers = std::get_if<std::shared_ptr<const MemoryInput>>(&value)) return Source(*numbers);
  return Source(std::get<std::string>(value));
}

/// Converts a value to the type of a member.
template <class T>
T fromValue(const Value& value) {
  if constexpr (IsOptional<T>::value)
    return fromValue<typename T::value_type>(value);
  else if constexpr (std::is_same_v<T, bool> || std::is_same_v<T, double> || std::is_same_v<T, Vec3> ||
                     std::is_same_v<T, std::vector<double>>)
    return std::get<T>(value);
  else if constexpr (std::is_integral_v<T>)
    return static_cast<T>(std::get<std::int64_t>(value));
  else if constexpr (std::is_same_v<T, Source>)
    return sourceIn(value);
  else
    return T(std::get<std::string>(value));
}

/// The value of a member; empty if it has none.
template <class T>
std::optional<Value> toValue(const T& member) {
  if constexpr (IsOptional<T>::value) {
    if (!member) return {};
    return toValue(*member);
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return Value(member.string());
  } else if constexpr (std::is_same_v<T, Source>) {
    return member.given ? Value(member.given) : Value(member.string());
  } else if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
    return Value(static_cast<std::int64_t>(member));
  } else {
    return Value(member);
  }
}

/// Readable text: "true", "0.07", "0.3 0.5 1".
std::string toText(const Value& value);

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
