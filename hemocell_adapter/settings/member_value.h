// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Conversion between values of options or attributes and members of settings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/source.h"

namespace packmesh::hemocell {

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

inline Source sourceIn(const Value& value) {
  if (const auto* numbers = std::get_if<std::shared_ptr<const Given>>(&value)) return Source(*numbers);
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

}  // namespace packmesh::hemocell
