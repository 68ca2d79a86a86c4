// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Abbreviations for the tables of settings.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/request.h"

namespace packmesh::hemocell::specs {

// Ranges that detect wrong units and typing errors without excluding useful values.
inline constexpr double largestLength = 1e5;  // [µm]; coordinates must stay below it (tolerances.h, culling)
inline constexpr double largestCount = 1e8;

inline ValueSpec number(const char* placeholder, const char* unit, double low, bool lowExcluded,
                        double high) {
  ValueSpec spec;
  spec.kind = Kind::number;
  spec.placeholder = placeholder;
  spec.unit = unit;
  spec.low = low;
  spec.lowExcluded = lowExcluded;
  spec.high = high;
  return spec;
}

inline ValueSpec length(const char* placeholder) {
  return number(placeholder, "µm", 0, true, largestLength);
}

inline ValueSpec integer(const char* placeholder, const char* unit, double low, double high) {
  ValueSpec spec = number(placeholder, unit, low, false, high);
  spec.kind = Kind::integer;
  return spec;
}

inline ValueSpec count() {
  return integer("n", "cells", 0, largestCount);
}

inline ValueSpec plain(Kind kind, const char* placeholder) {
  ValueSpec spec;
  spec.kind = kind;
  spec.placeholder = placeholder;
  return spec;
}

inline ValueSpec choice(const char* placeholder, std::vector<std::string> choices) {
  ValueSpec spec = plain(Kind::choice, placeholder);
  spec.choices = std::move(choices);
  return spec;
}

inline ValueSpec vector(const char* placeholder, double low, bool lowExcluded) {
  ValueSpec spec = number(placeholder, "µm", low, lowExcluded, largestLength);
  spec.kind = Kind::vector;
  return spec;
}

inline ValueSpec hematocrit() {
  ValueSpec spec = number("h", "fraction", 0, true, 1);
  spec.highExcluded = true;
  return spec;
}

inline ValueSpec regionHematocrit() {
  ValueSpec spec = hematocrit();
  spec.lowExcluded = false;
  return spec;
}

inline ValueSpec latticeNodes() {
  ValueSpec spec = plain(Kind::vector, "");
  spec.unit = "lattice nodes";
  spec.low = 1;
  return spec;
}

inline ValueSpec ratio() {
  return number("r", "per red cell", 0, false, 1e4);
}
/// @param words alternatives to the number
inline ValueSpec clearance(std::vector<std::string> words = {}) {
  ValueSpec spec = number("d", "µm", 0, false, 100);
  spec.choices = std::move(words);
  return spec;
}
inline ValueSpec direction(const char* placeholder) {
  ValueSpec spec = vector(placeholder, -1e6, false);
  spec.unit = "";
  spec.high = 1e6;
  return spec;
}
inline ValueSpec spread() {
  return number("angle", "degrees", 0, false, 90);
}
/// @param words alternatives to true and false
inline ValueSpec flag(std::vector<std::string> words = {}) {
  ValueSpec spec = plain(Kind::boolean, "");
  spec.choices = std::move(words);
  return spec;
}
inline ValueSpec name() {
  return plain(Kind::name, "name");
}
inline ValueSpec file() {
  return plain(Kind::text, "file");
}
inline ValueSpec meshScale() {
  return number("factor", "µm per unit of the file", 0, true, 1e9);
}
inline ValueSpec seed() {
  return integer("n", "", 0, double(std::numeric_limits<std::int64_t>::max()));
}
inline ValueSpec distanceFromSolid() {
  return number("d", "µm", 0, false, 1000);
}
inline ValueSpec meshFrames() {
  return choice("frame", meshFrameNames());
}
inline ValueSpec constructions() {
  return choice("kind", constructionNames());
}

using Values = std::vector<Value>;
inline double real(const Value& v) {
  return std::get<double>(v);
}
/// Empty if the value is a word.
inline std::optional<double> numberIn(const Value& v) {
  const double* number = std::get_if<double>(&v);
  return number ? std::optional<double>(*number) : std::nullopt;
}
inline bool isWord(const Value& v, const char* word) {
  const std::string* text = std::get_if<std::string>(&v);
  return text && *text == word;
}
inline std::int64_t whole(const Value& v) {
  return std::get<std::int64_t>(v);
}
inline bool yes(const Value& v) {
  return std::get<bool>(v);
}
inline const std::string& text(const Value& v) {
  return std::get<std::string>(v);
}

}  // namespace packmesh::hemocell::specs
