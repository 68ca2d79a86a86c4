// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/construction.h"

namespace packmesh::hemocell {
namespace {

struct NamedConstruction {
  Construction construction;
  const char* name;
};
constexpr NamedConstruction namesOfConstructions[] = {
    {Construction::rbcFromSphere, "RBC_FROM_SPHERE"},
    {Construction::ellipsoidFromSphere, "ELLIPSOID_FROM_SPHERE"},
    {Construction::wbcSphere, "WBC_SPHERE"},
    {Construction::meshFromStl, "MESH_FROM_STL"},
};

}  // namespace

std::string toString(Construction construction) {
  for (const NamedConstruction& entry : namesOfConstructions)
    if (entry.construction == construction) return entry.name;
  return "unknown";
}

std::optional<Construction> constructionFromString(const std::string& text) {
  for (const NamedConstruction& entry : namesOfConstructions)
    if (text == entry.name) return entry.construction;
  return {};
}

std::vector<std::string> constructionNames() {
  std::vector<std::string> names;
  for (const NamedConstruction& entry : namesOfConstructions) names.emplace_back(entry.name);
  return names;
}

std::vector<std::string> meshFrameNames() {
  return {"hemocell", "file"};
}

std::string toString(MeshFrame frame) {
  return frame == MeshFrame::file ? "file" : "hemocell";
}

std::optional<MeshFrame> meshFrameFromString(const std::string& text) {
  if (text == "hemocell") return MeshFrame::hemocell;
  if (text == "file") return MeshFrame::file;
  return {};
}

}  // namespace packmesh::hemocell
