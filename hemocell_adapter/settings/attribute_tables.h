// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Attributes of tags, by which they are parsed and told of.
#pragma once

#include <functional>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/settings/settings.h"

namespace packmesh::hemocell {

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
