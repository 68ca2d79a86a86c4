// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/attribute_tables.h"

#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {

using namespace specs;

const std::vector<SpeciesAttribute>& speciesAttributes() {
  static const std::vector<SpeciesAttribute> table = {
      {"name", name(), "", "name of the cell: <name>.xml is read, <name>.pos written",
       [](SpeciesRequest& s, const Value& v) { s.name = text(v); }},
      {"count", count(), "by hematocrit or ratio", "how many",
       [](SpeciesRequest& s, const Value& v) { s.count = whole(v); }},
      {"ratio", ratio(), "",
       "so many per red cell, those of all species counted; of red cells: their share of all red cells, "
       "below 1",
       [](SpeciesRequest& s, const Value& v) { s.ratio = real(v); }},
      {"construction", constructions(), "by the name", "how the case's C++ code builds the cell",
       [](SpeciesRequest& s, const Value& v) { s.construction = constructionFromString(text(v)); }},
      {"minimumDistanceFromSolid", distanceFromSolid(), "of the C++ code beside config.xml, or 0",
       "what the case's C++ code passes to setInitialMinimumDistanceFromSolid, truncated as HemoCell does",
       [](SpeciesRequest& s, const Value& v) { s.minimumDistanceFromSolid = real(v); }},
      {"file", file(), "", "a closed mesh instead of <name>.xml",
       [](SpeciesRequest& s, const Value& v) { s.meshFile = text(v); }},
      {"scale", meshScale(), "1", "unit of that file",
       [](SpeciesRequest& s, const Value& v) { s.meshScale = real(v); }},
      {"frame", meshFrames(), "hemocell",
       "axes of that file: turned as HemoCell's MESH_FROM_STL does, or as they are",
       [](SpeciesRequest& s, const Value& v) { s.meshFrame = meshFrameFromString(text(v)); }},
      {"ellipsoid", vector("e1 e2 d", 0, true), "", "an ellipsoid instead of <name>.xml, full axis lengths",
       [](SpeciesRequest& s, const Value& v) { s.ellipsoidAxes = std::get<Vec3>(v); }},
      {"redCell", flag(), "true when the name contains RBC", "whether its volume counts as hematocrit",
       [](SpeciesRequest& s, const Value& v) { s.redCell = yes(v); }},
      {"fixed", file(), "", "a .pos file of cells that stay where they are",
       [](SpeciesRequest& s, const Value& v) { s.fixed = text(v); }},
      {"start", file(), "", "a .pos file of cells to begin with: more are added, of too many some are drawn",
       [](SpeciesRequest& s, const Value& v) { s.start = text(v); }},
      {"wallClearance", clearance(), "that of all cells", "least gap between these cells and the wall",
       [](SpeciesRequest& s, const Value& v) { s.wallClearance = real(v); }},
      {"axis", direction("x y z"), "", "direction of the cells' thin axis",
       [](SpeciesRequest& s, const Value& v) { s.axis = std::get<Vec3>(v); }},
      {"spread", spread(), "0", "largest angle to that direction",
       [](SpeciesRequest& s, const Value& v) { s.spread = real(v); }},
      {"stock", count(), "0", "so many more may fill gaps; with escape",
       [](SpeciesRequest& s, const Value& v) { s.stock = whole(v); }},
  };
  return table;
}

const std::vector<GrowthParameter>& growthParameters() {
  using G = GrowthSettings;
  constexpr double endless = 1e9;
  const auto positive = [](const char* unit, double high) { return number("", unit, 0, true, high); };
  const auto nonNegative = [](const char* unit, double high) { return number("", unit, 0, false, high); };
  const auto integerFrom = [](double low) { return integer("", "", low, endless); };
  ValueSpec scales = number("", "fractions", 0, true, 1);
  scales.kind = Kind::numbers;
  static const std::vector<GrowthParameter> table = {
      {"initialScale", number("", "fraction", G::smallestScale, false, 1), "0.1",
       "f_init, at which cells start", [](G& g, const Value& v) { g.initialScale = real(v); }},
      {"spreadRounds", integerFrom(0), "10", "rounds in which cells of different sizes are spread",
       [](G& g, const Value& v) { g.spreadRounds = int(whole(v)); }},
      {"barriers", scales, "0.3 0.5 0.7 0.8 0.9 1",
       "b_i, increasing to 1: none grows beyond before all are there",
       [](G& g, const Value& v) { g.barriers = std::get<std::vector<double>>(v); }},
      {"iterations", integerFrom(1), "60", "itn_max, for each barrier",
       [](G& g, const Value& v) { g.maxIterations = int(whole(v)); }},
      {"rotationBound", positive("rad", 3.14159), "0.05", "theta_max, largest turn in an iteration",
       [](G& g, const Value& v) { g.rotationBound = real(v); }},
      {"translationBound", positive("cube roots of the volume", 1e3), "0.035",
       "t_max, largest translation in an iteration",
       [](G& g, const Value& v) { g.translationBound = real(v); }},
      {"padding", nonNegative("roots of a triangle's area", 1e3), "0.04", "p, kept from the planes",
       [](G& g, const Value& v) { g.padding = real(v); }},
      {"linearisations", integerFrom(1), "2", "of the rotation in an iteration",
       [](G& g, const Value& v) { g.linearisations = int(whole(v)); }},
      {"alpha", positive("", 1), "0.25", "of the resampling (eq. 3.4)",
       [](G& g, const Value& v) { g.alpha = real(v); }},
      {"beta", positive("", 1e3), "0.5", "of the resampling (eq. 3.4)",
       [](G& g, const Value& v) { g.beta = real(v); }},
      {"centring", flag(), "true", "cells at the barrier move to the middle of their planes",
       [](G& g, const Value& v) { g.centring = yes(v); }},
      {"shaking", nonNegative("", 1), "0.001", "random pushes relative to growth",
       [](G& g, const Value& v) { g.shaking = real(v); }},
      {"patience", integerFrom(1), "5", "iterations over which growth is judged stalled",
       [](G& g, const Value& v) { g.patience = int(whole(v)); }},
      {"stalledGrowth", nonNegative("fraction of what was missing", 1e3), "0.2", "less than this is stalled",
       [](G& g, const Value& v) { g.stalledGrowth = real(v); }},
      {"relaxationSweeps", integerFrom(0), "400", "of a relaxation when stalled; 0: none, as in the thesis",
       [](G& g, const Value& v) { g.relaxationSweeps = int(whole(v)); }},
      {"giveUpAfter", integerFrom(0), "0", "stalls at one barrier that no relaxation helped; 0: never",
       [](G& g, const Value& v) { g.giveUpAfter = int(whole(v)); }},
      {"attempts", integerFrom(1), "64", "random starts times cells, when few cells get nowhere",
       [](G& g, const Value& v) { g.attempts = int(whole(v)); }},
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
