// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/settings/attribute_tables.h"

#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {

using namespace specs;

const std::vector<Attribute<SpeciesRequest>>& speciesAttributes() {
  using S = SpeciesRequest;
  const auto named = [](std::string name, ValueSpec value, std::string help,
                        std::function<void(S&, const Value&)> apply) {
    return Attribute<S>{std::move(name), std::move(value), std::move(help), std::move(apply)};
  };
  static const std::vector<Attribute<S>> table = {
      attribute("name", &S::name, name(), "name of the cell: <name>.xml is read, <name>.pos written")
          .required(),
      attribute("count", &S::count, count(), "number of cells").byDefault("from hematocrit or ratio"),
      attribute("ratio", &S::ratio, ratio(),
                "number of these cells per red cell of any species; for red cells: their share of all red "
                "cells, below 1"),
      named("construction", constructions(), "construction of the cell in the C++ code of the case",
            [](S& s, const Value& v) { s.construction = constructionFromString(text(v)); })
          .byDefault("depends on the name"),
      attribute("minimumDistanceFromSolid", &S::minimumDistanceFromSolid, distanceFromSolid(),
                "value that the C++ code of the case passes to setInitialMinimumDistanceFromSolid; HemoCell "
                "truncates it to whole µm")
          .byDefault("that in the C++ code beside config.xml, or 0"),
      attribute("file", &S::meshFile, file(), "a closed mesh instead of <name>.xml"),
      attribute("scale", &S::meshScale, meshScale(), "length of a unit of that file in µm").byDefault("1"),
      named("frame", meshFrames(),
            "axes of that file; hemocell: rotated as HemoCell's MESH_FROM_STL does; file: unchanged",
            [](S& s, const Value& v) { s.meshFrame = meshFrameFromString(text(v)); })
          .byDefault("hemocell"),
      attribute("ellipsoid", &S::ellipsoidAxes, vector("e1 e2 d", 0, true),
                "an ellipsoid instead of <name>.xml, full axis lengths"),
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
      attribute("stock", &S::stock, count(), "with escape: number of cells in reserve that can fill gaps")
          .byDefault("0"),
  };
  return table;
}

const std::vector<Attribute<GrowthSettings>>& growthParameters() {
  using G = GrowthSettings;
  constexpr double endless = 1e9;
  const auto positive = [](const char* unit, double high) { return number("", unit, 0, true, high); };
  const auto nonNegative = [](const char* unit, double high) { return number("", unit, 0, false, high); };
  const auto integerFrom = [](double low) { return integer("", "", low, endless); };
  ValueSpec scales = number("", "fractions", 0, true, 1);
  scales.kind = Kind::numbers;
  static const std::vector<Attribute<G>> table = {
      attribute("initialScale", &G::initialScale, number("", "fraction", G::smallestScale, false, 1),
                "f_init, initial scale of cells"),
      attribute("barriers", &G::barriers, scales,
                "b_i, increasing to 1: no cell grows beyond a barrier before all have reached it"),
      attribute("iterations", &G::maxIterations, integerFrom(1),
                "itn_max, largest number of iterations per barrier"),
      attribute("rotationBound", &G::rotationBound, positive("rad", 3.14159),
                "theta_max, largest rotation in an iteration"),
      attribute("translationBound", &G::translationBound, positive("cube roots of the volume", 1e3),
                "t_max, largest translation in an iteration"),
      attribute("padding", &G::padding, nonNegative("roots of a triangle's area", 1e3),
                "p, distance kept from the planes"),
      attribute("linearisations", &G::linearisations, integerFrom(1),
                "number of linearisations of the rotation per iteration"),
      attribute("alpha", &G::alpha, positive("", 1), "alpha of the resampling (Bos 2023, eq. 3.4)"),
      attribute("beta", &G::beta, positive("", 1e3), "beta of the resampling (Bos 2023, eq. 3.4)"),
      attribute("centring", &G::centring, flag(),
                "move cells that reached the barrier to the centre of their planes"),
      attribute("shaking", &G::shaking, nonNegative("", 1), "random displacements relative to growth"),
      attribute("patience", &G::patience, integerFrom(1),
                "number of iterations over which stalling is judged"),
      attribute("stalledGrowth", &G::stalledGrowth, nonNegative("fraction of the missing growth", 1e3),
                "mean growth below which cells count as stalled"),
      attribute(
          "relaxationSweeps", &G::relaxationSweeps, integerFrom(0),
          "sweeps of the relaxation after growth stalls or its iterations end; 0: none, as in Bos 2023"),
      attribute("giveUpAfter", &G::giveUpAfter, integerFrom(0),
                "give up after this many stalls at one barrier despite relaxation; 0: never"),
      attribute("attempts", &G::attempts, integerFrom(1),
                "with few cells: largest number of random starts times number of cells"),
  };
  return table;
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
  };
  return table;
}

}  // namespace packmesh::hemocell
