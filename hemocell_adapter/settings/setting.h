// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is known of an option and its tag.
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

}  // namespace packmesh::hemocell
