// SPDX-License-Identifier: AGPL-3.0-or-later
// Settings of Method::cat.
#include <optional>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/settings_table.h"
#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {

using namespace specs;

const std::vector<Attribute<GrowthSettings>>& catParameters() {
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

namespace {

std::vector<std::string> growthNames() {
  std::vector<std::string> names;
  for (const Attribute<GrowthSettings>& parameter : catParameters()) names.emplace_back(parameter.name);
  return names;
}

void setGrowth(Request& settings, const std::string& name, const std::string& value) {
  for (const Attribute<GrowthSettings>& parameter : catParameters()) {
    if (parameter.name != name) continue;
    located<UsageError>(heading(catTag, name),
                        [&] { parameter.apply(settings.cat.growth, parseValue(parameter.value, value)); });
  }
}

Setting escapeSetting() {
  Setting made = setting(
      "escape", {flag()}, "with --method cat: cells that remain small exchange places and grow into gaps",
      [](Request& r, const Values& v) {
        r.cat.escape = yes(v[0]) ? std::optional<EscapeSettings>(EscapeSettings()) : std::nullopt;
      });
  made.get = [](const Request& r) { return Value(r.cat.escape.has_value()); };
  return made.byDefault("false").withTag("escape").onlyFor(Method::cat);
}

}  // namespace

std::vector<Setting> catSettings() {
  using R = Request;
  using C = CatSettings;
  return {
      choiceSetting("method", &R::method, "name", {{"relaxation", Method::relaxation}, {"cat", Method::cat}},
                    "relaxation: separate overlapping cells of full size; cat: grow small cells in the cells "
                    "of the chordal axis transform"),
      choiceSetting("builder", &C::planeSource, "name",
                    {{"chords", PlaneSource::chords}, {"cat-faces", PlaneSource::catFaces}},
                    "with --method cat: source of the planes between cells")
          .onlyFor(Method::cat),
      escapeSetting(),
      setting("stock", {name(), count()},
              "with --escape: number of cells of that kind in reserve that can fill gaps",
              [](Request& s, const Values& v) { speciesNamed(s, text(v[0])).stock = whole(v[1]); })
          .ofCell({"stock"})
          .byDefault("0"),
      setting("growth", {choice("parameter", growthNames()), plain(Kind::text, "value")},
              "with --method cat: set an attribute of <growth> (--reference lists them)",
              [](Request& s, const Values& v) { setGrowth(s, text(v[0]), text(v[1])); })
          .statesKey(catTag)
          .onlyFor(Method::cat),
  };
}

Setting framesSetting() {
  return setting(
             "growth-frames", &OutputRequest::frames, integer("n", "states", 1, 1e9),
             "with --method cat: write every n-th state of growth to the folder growth_frames, as series of "
             "membranes and CAT cells for ParaView (about 60 kB per red cell and state)")
      .byDefault("none")
      .onlyFor(Method::cat)
      .notForCheck();
}

}  // namespace packmesh::hemocell
