// SPDX-License-Identifier: AGPL-3.0-or-later
// How cells are packed, and when to give up.
#include <fmt/format.h>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/setting_groups.h"
#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {
namespace {

using namespace specs;

std::vector<std::string> growthNames() {
  std::vector<std::string> names;
  for (const Attribute<GrowthSettings>& parameter : growthParameters()) names.emplace_back(parameter.name);
  return names;
}

void setGrowth(Settings& settings, const std::string& name, const std::string& value) {
  for (const Attribute<GrowthSettings>& parameter : growthParameters()) {
    if (parameter.name != name) continue;
    try {
      parameter.apply(settings.growth, parseValue(parameter.value, value));
    } catch (const InputError& error) {
      throw UsageError(fmt::format("option '--growth' {}: {}", name, error.what()));
    }
  }
}

}  // namespace

std::vector<Setting> methodSettings() {
  using R = RunSettings;
  return {
      choiceSetting("method", &R::method, "name", {{"relaxation", Method::relaxation}, {"cat", Method::cat}},
                    "push full-size cells apart, or grow small ones in cells of the chordal axis transform"),
      choiceSetting(
          "builder", &R::builder, "name",
          {{"chords", Builder::chords}, {"tetgen", Builder::tetgen}, {"cat-faces", Builder::catFaces}},
          "with --method cat: where the planes between cells come from")
          .onlyFor(Method::cat),
      flagSetting("escape", &R::escape,
                  "with --method cat: cells that stay small change places and grow into their neighbours' "
                  "gaps")
          .onlyFor(Method::cat),
      setting("stock", {name(), count()}, "with --escape: so many more of that cell may fill gaps",
              [](Settings& s, const Values& v) { speciesNamed(s, text(v[0])).stock = whole(v[1]); })
          .byDefault("0"),
      setting("growth", {choice("parameter", growthNames()), plain(Kind::text, "value")},
              "with --method cat: an attribute of <growth> (--reference lists them)",
              [](Settings& s, const Values& v) { setGrowth(s, text(v[0]), text(v[1])); })
          .onlyFor(Method::cat),
      setting("clearance", {clearance({"auto", "max"})},
              "least gap between membranes; auto: a tenth of dx, or as much of it as the hematocrit allows; "
              "max: the largest that is found within --max-time, or 60 s",
              [](Settings& s, const Values& v) {
                s.clearance = numberIn(v[0]);
                s.largestClearance = isWord(v[0], "max");
              })
          .byDefault("auto")
          .withTag("clearance"),
      setting("wall-clearance", {clearance({"auto"})},
              "least gap between membrane and wall; auto: dx, or as much of it as the hematocrit allows",
              [](Settings& s, const Values& v) { s.wallClearance = numberIn(v[0]); })
          .byDefault("auto")
          .withTag("wallClearance"),
      setting("cell-free-layer", &R::cellFreeLayer, clearance(), "red cells keep this far from the wall")
          .byDefault("none"),
      setting("seed", &R::seed, seed(), "another seed, another packing; same seed, same bytes"),
      [] {
        Setting no = setting("noRotate", {flag()}, "keep every orientation at 0 0 0 (thin axis y)",
                             [](Settings& s, const Values& v) { s.rotate = !yes(v[0]); })
                         .byDefault("no")
                         .alsoOfPackCells();
        no.flag = true;
        return no;
      }(),
      flagSetting("", &R::rotate, "no keeps every orientation at 0 0 0 (thin axis y)").withTag("rotate"),
      choiceSetting("order", &R::inColumns, "kind", {{"random", false}, {"columns", true}},
                    "columns: the cells with most volume stand in columns, like rolls of coins, where no "
                    "random packing is as dense; in periodic boxes"),
  };
}

std::vector<Setting> limitSettings() {
  using R = RunSettings;
  const ValueSpec sweeps = integer("n", "sweeps", 1, 1e15);
  return {
      setting("max-time", &R::maxSeconds, number("s", "s", 0, true, 1e9),
              "give up after this time; when not all cells fit at once, fewer are packed first, which may "
              "take as long again. Then the run ends within 5 s, or 2 s for every 100,000 cells if that is "
              "more")
          .byDefault("no limit"),
      setting("max-iterations", &R::maxIterations, sweeps,
              "give up after so many relaxation sweeps or iterations of growth (the search for the densest "
              "packing takes more)")
          .byDefault("100000"),
      setting("maxiter", &R::maxIterations, sweeps, "packCells' name of --max-iterations")
          .withoutTag()
          .alsoOfPackCells(),
      flagSetting("best-effort", &R::bestEffort,
                  "out of reach? write the densest certified packing that was found"),
      flagSetting("dry-run", &R::dryRun,
                  "pack nothing: tell volumes, numbers, memory, time, and whether the hematocrit is within "
                  "reach")
          .withoutTag()
          .notForCheck(),
      flagSetting("validate", &R::validate,
                  "pack nothing: only read all there is to read and say what is wrong")
          .withoutTag()
          .notForCheck(),
  };
}

}  // namespace packmesh::hemocell
