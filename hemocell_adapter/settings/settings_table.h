// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The one declaration of every option and every tag of `<packing>`: it drives parsing, range checks,
/// error messages, `--help` and the reference.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/settings.h"

namespace packmesh::hemocell {

enum class Topic { cells, lumen, packing, limits, output, ignored };

/// A setting, its option and its tag (either may be empty).
struct Setting {
  const char* option;  ///< without dashes
  char letter;         ///< short option, 0: none
  const char* tag;     ///< child of `<packing>`
  bool flag;           ///< as an option it needs no value; `values` is one boolean
  std::vector<ValueSpec> values;
  const char* fallback;  ///< the default, in words
  const char* help;
  Topic topic;
  bool packCells;  ///< packCells has it too: its prefixes come first
  std::function<void(Settings&, const std::vector<Value>&)> apply;
  bool repeats = false;      ///< the tag may stand there several times
  bool packingOnly = false;  ///< `check` refuses the option
};

/// All settings, in the order of the help text.
const std::vector<Setting>& settingsTable();

/// An attribute of `<species>`.
struct SpeciesAttribute {
  const char* name;
  ValueSpec value;
  const char* fallback;
  const char* help;
  std::function<void(SpeciesRequest&, const Value&)> apply;
};
const std::vector<SpeciesAttribute>& speciesAttributes();

/// A parameter of growth: an attribute of `<growth>`, and `--growth name value`.
struct GrowthParameter {
  const char* name;
  ValueSpec value;
  const char* fallback;
  const char* help;
  std::function<void(GrowthSettings&, const Value&)> apply;
};
const std::vector<GrowthParameter>& growthParameters();

/// An attribute of a body in `<container>` or `<obstacles>`.
struct SolidAttribute {
  const char* name;
  ValueSpec value;
  const char* fallback;  ///< "": required
  const char* help;
  std::function<void(SolidRequest&, const Value&)> apply;
};

/// `<box>`, `<cylinder>`, `<sphere>`, `<mesh>`.
struct SolidTag {
  const char* name;
  SolidRequest::Kind kind;
  std::vector<SolidAttribute> attributes;
};
const std::vector<SolidTag>& solidTags();

}  // namespace packmesh::hemocell
