// SPDX-License-Identifier: AGPL-3.0-or-later
// The attributes of <species> and of the bodies of <container>.
#include "hemocell_adapter/settings_table.h"
#include "hemocell_adapter/value_specs.h"

namespace packmesh::hemocell {

using namespace specs;

const std::vector<SpeciesAttribute>& speciesAttributes() {
  static const std::vector<SpeciesAttribute> table = {
      {"name", name(), "", "name of the cell: <name>.xml is read, <name>.pos written",
       [](SpeciesRequest& s, const Value& v) { s.name = text(v); }},
      {"count", count(), "by hematocrit or ratio", "how many",
       [](SpeciesRequest& s, const Value& v) { s.count = whole(v); }},
      {"ratio", ratio(), "", "so many per red cell",
       [](SpeciesRequest& s, const Value& v) { s.ratio = real(v); }},
      {"construction", constructions(), "by the name", "how the case's C++ code builds the cell",
       [](SpeciesRequest& s, const Value& v) { s.construction = constructionFromString(text(v)); }},
      {"minimumDistanceFromSolid", distanceFromSolid(), "0",
       "what the case's C++ code passes to setInitialMinimumDistanceFromSolid",
       [](SpeciesRequest& s, const Value& v) { s.minimumDistanceFromSolid = int(whole(v)); }},
      {"file", file(), "", "a closed mesh instead of <name>.xml",
       [](SpeciesRequest& s, const Value& v) { s.meshFile = text(v); }},
      {"scale", meshScale(), "1", "unit of that file",
       [](SpeciesRequest& s, const Value& v) { s.meshScale = real(v); }},
      {"ellipsoid", vector("e1 e2 d", 0, true), "", "an ellipsoid instead of <name>.xml, full axis lengths",
       [](SpeciesRequest& s, const Value& v) { s.ellipsoidAxes = std::get<Vec3>(v); }},
      {"redCell", flag(), "true when the name contains RBC", "whether its volume counts as hematocrit",
       [](SpeciesRequest& s, const Value& v) { s.redCell = yes(v); }},
  };
  return table;
}

const std::vector<SolidTag>& solidTags() {
  const auto radius = SolidAttribute{"radius", length("r"), "", "radius",
                                     [](SolidRequest& s, const Value& v) { s.radius = real(v); }};
  const auto center =
      SolidAttribute{"center", vector("x y z", -largestLength, false), "low corner at the origin", "centre",
                     [](SolidRequest& s, const Value& v) { s.center = std::get<Vec3>(v); }};
  const auto origin = [](const char* name, const char* help) {
    return SolidAttribute{name, vector("x y z", -largestLength, false), "0 0 0", help,
                          [](SolidRequest& s, const Value& v) { s.origin = std::get<Vec3>(v); }};
  };
  static const std::vector<SolidTag> table = {
      {"box",
       SolidRequest::Kind::box,
       {{"size", vector("x y z", 0, true), "", "edge lengths",
         [](SolidRequest& s, const Value& v) { s.size = std::get<Vec3>(v); }},
        origin("origin", "low corner")}},
      {"cylinder",
       SolidRequest::Kind::cylinder,
       {{"axis", plain(Kind::axis, "axis"), "x", "axis",
         [](SolidRequest& s, const Value& v) { s.axis = int(whole(v)); }},
        radius,
        {"length", length("l"), "", "length", [](SolidRequest& s, const Value& v) { s.length = real(v); }},
        center}},
      {"sphere", SolidRequest::Kind::sphere, {radius, center}},
      {"mesh",
       SolidRequest::Kind::mesh,
       {{"file", file(), "", "closed mesh (STL, OFF, PLY, OBJ)",
         [](SolidRequest& s, const Value& v) { s.file = text(v); }},
        {"scale", meshScale(), "1", "unit of the file",
         [](SolidRequest& s, const Value& v) { s.scale = real(v); }},
        origin("offset", "added to the scaled coordinates"),
        {"openAxis", plain(Kind::axis, "axis"), "closed all around", "axis along which the lumen is open",
         [](SolidRequest& s, const Value& v) { s.openAxis = int(whole(v)); }}}},
  };
  return table;
}

}  // namespace packmesh::hemocell
