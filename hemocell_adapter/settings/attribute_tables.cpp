// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/attribute_tables.h"

#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {

std::string toText(const Value& value) {
  return std::visit(
      [](const auto& v) -> std::string {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, bool>)
          return v ? "true" : "false";
        else if constexpr (std::is_same_v<T, Vec3>)
          return fmt::format("{} {} {}", v.x(), v.y(), v.z());
        else if constexpr (std::is_same_v<T, std::vector<double>>)
          return fmt::format("{}", fmt::join(v, " "));
        else if constexpr (std::is_same_v<T, std::shared_ptr<const MemoryInput>>)
          return v->what;
        else
          return fmt::format("{}", v);
      },
      value);
}

using namespace specs;

const std::vector<Attribute<SpeciesRequest>>& speciesAttributes() {
  using S = SpeciesRequest;
  const auto named = [](std::string name, auto S::*member, ValueSpec value, std::string help, auto fromText) {
    Attribute<S> made{std::move(name), std::move(value), std::move(help), {}};
    made.apply = [=](S& s, const Value& v) { s.*member = fromText(text(v)); };
    made.get = [=](const S& s) {
      return s.*member ? std::optional<Value>(toString(*(s.*member))) : std::nullopt;
    };
    made.clear = [=](S& s) { (s.*member).reset(); };
    return made;
  };
  static const std::vector<Attribute<S>> table = {
      attribute("name", &S::name, name(), "name of the cell: <name>.xml is read, <name>.pos written")
          .required(),
      attribute("count", &S::count, count(), "number of cells")
          .byDefault("from hematocrit or ratio")
          .replacing({"ratio"}),
      attribute("ratio", &S::ratio, ratio(),
                "number of these cells per red cell of any species; for red cells: their share of all red "
                "cells, below 1")
          .replacing({"count"}),
      named("construction", &S::construction, constructions(),
            "construction of the cell in the C++ code of the case", constructionFromString)
          .byDefault("depends on the name"),
      attribute("minimumDistanceFromSolid", &S::minimumDistanceFromSolid, distanceFromSolid(),
                "value that the C++ code of the case passes to setInitialMinimumDistanceFromSolid; HemoCell "
                "truncates it to whole µm")
          .byDefault("that in the C++ code beside config.xml, or 0"),
      attribute("file", &S::meshFile, file(), "a closed mesh instead of <name>.xml").replacing({"ellipsoid"}),
      attribute("scale", &S::meshScale, meshScale(), "length of a unit of that file in µm").byDefault("1"),
      named("frame", &S::meshFrame, meshFrames(),
            "axes of that file; hemocell: rotated as HemoCell's MESH_FROM_STL does; file: unchanged",
            meshFrameFromString)
          .byDefault("hemocell"),
      attribute("ellipsoid", &S::ellipsoidAxes, vector("e1 e2 d", 0, true),
                "an ellipsoid instead of <name>.xml, full axis lengths")
          .replacing({"file", "scale", "frame"}),
      attribute("redCell", &S::redCell, flag(), "true if its volume counts in the hematocrit")
          .byDefault("true when the name contains RBC"),
      attribute("fixed", &S::fixed, file(), "a .pos file of fixed cells"),
      attribute("start", &S::start, file(),
                "a .pos file of cells to start from; missing cells are added; if the file has more, a random "
                "subset "
                "is kept"),
      attribute("wallClearance", &S::wallClearance, clearance(),
                "minimum gap between these cells and the wall")
          .byDefault("that of all cells"),
      attribute("axis", &S::axis, direction("x y z"), "direction of the symmetry axis of the cells"),
      attribute("spread", &S::spread, spread(), "largest angle to that direction").byDefault("0"),
      attribute("rigid", &S::rigid, flag(), "with soft cells: true if these keep their shape")
          .byDefault("false"),
      attribute("stock", &S::stock, count(), "with escape: number of cells in reserve that can fill gaps")
          .byDefault("0"),
  };
  return table;
}

void refuseBoth(const std::function<bool(const char*)>& has, const std::string& where) {
  if (has("count") && has("ratio")) throw InputError(where + ": has both a count and a ratio; give only one");
  if (has("file") && has("ellipsoid"))
    throw InputError(where + ": has both a mesh file and an ellipsoid; give only one");
}

const std::vector<Attribute<RegionRequest>>& regionAttributes() {
  using R = RegionRequest;
  static const std::vector<Attribute<R>> table = {
      attribute("hematocrit", &R::hematocrit, regionHematocrit(), "of the region, all its red cells together")
          .byDefault("that of the rest"),
      attribute("count", &R::count, count(), "instead: number of red cells in it, of all species"),
  };
  return table;
}

const std::vector<Attribute<RegionSpecies>>& regionSpeciesAttributes() {
  using S = RegionSpecies;
  static const std::vector<Attribute<S>> table = {
      attribute("name", &S::name, name(), "name of the cell").required(),
      attribute("count", &S::count, count(), "number of these cells in the region").required(),
  };
  return table;
}

void examineRegion(const RegionRequest& region, const std::string& where) {
  if (region.hematocrit && region.count)
    throw InputError(where + ": has both a hematocrit and a count of red cells; give only one");
  if (!region.statesRedCells() && region.species.empty())
    throw InputError(
        where +
        ": the attribute hematocrit is missing; a region has a hematocrit, a count of red cells, "
        "or species of its own");
  for (auto one = region.species.begin(); one != region.species.end(); ++one)
    if (std::any_of(region.species.begin(), one, [&](const RegionSpecies& s) { return s.name == one->name; }))
      throw InputError(fmt::format("{}: a second species called '{}'", where, one->name));
  const SolidRequest& body = region.body;
  const bool isDirected =
      body.kind == SolidRequest::Kind::halfSpace || body.kind == SolidRequest::Kind::beyond;
  if (isDirected && !(body.direction.norm() > 0.0))
    throw InputError(fmt::format("{}: its {} 0 0 0 is not a direction", body.where,
                                 body.kind == SolidRequest::Kind::beyond ? "direction" : "normal"));
}

const std::vector<SolidTag>& solidTags() {
  using S = SolidRequest;
  const auto radius = attribute("radius", &S::radius, length("r"), "radius").required();
  const auto center = attribute("center", &S::center, vector("x y z", -largestLength, false), "centre")
                          .byDefault("low corner at the origin");
  const auto origin = [](const char* name, const char* help) {
    return attribute(name, &S::origin, vector("x y z", -largestLength, false), help);
  };
  const auto axis = plain(Kind::axis, "axis");
  const auto point = [](const char* help) {
    return attribute("point", &S::point, vector("x y z", -largestLength, false), help).required();
  };
  const auto into = [](const char* name, const char* help) {
    return attribute(name, &S::direction, direction("x y z"), help).required();
  };
  static const std::vector<SolidTag> table = {
      {"box",
       S::Kind::box,
       {attribute("size", &S::size, vector("x y z", 0, true), "edge lengths").required(),
        origin("origin", "low corner")}},
      {"cylinder",
       S::Kind::cylinder,
       {attribute("axis", &S::axis, axis, "axis").byDefault("x"), radius,
        attribute("length", &S::length, length("l"), "length").required(), center}},
      {"sphere", S::Kind::sphere, {radius, center}},
      {"mesh",
       S::Kind::mesh,
       {attribute("file", &S::file, file(), "closed mesh (STL, OFF, PLY, OBJ)").required(),
        attribute("scale", &S::scale, meshScale(), "length of a unit of the file in µm"),
        origin("offset", "added to the scaled coordinates"),
        attribute("openAxis", &S::openAxis, axis, "axis along which the lumen is open")
            .byDefault("closed on all sides")}},
      {"halfSpace",
       S::Kind::halfSpace,
       {point("on the plane"), into("normal", "of the plane, into the region")},
       true},
      {"beyond",
       S::Kind::beyond,
       {point("in the lumen, through which it is cut"),
        into("direction", "across the section, into the region")},
       true},
  };
  return table;
}

}  // namespace packmesh::hemocell
