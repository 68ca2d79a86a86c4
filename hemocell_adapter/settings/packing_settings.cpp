// SPDX-License-Identifier: AGPL-3.0-or-later
// Request of the method and its limits.
#include <fmt/format.h>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/settings/attribute_tables.h"
#include "hemocell_adapter/settings/setting_groups.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/problem/execution.h"

namespace packmesh::hemocell {
namespace {

using namespace specs;

std::vector<std::string> growthNames() {
  std::vector<std::string> names;
  for (const Attribute<GrowthSettings>& parameter : growthParameters()) names.emplace_back(parameter.name);
  return names;
}

void setGrowth(Request& settings, const std::string& name, const std::string& value) {
  for (const Attribute<GrowthSettings>& parameter : growthParameters()) {
    if (parameter.name != name) continue;
    located<UsageError>("option '--growth' " + name,
                        [&] { parameter.apply(settings.growth, parseValue(parameter.value, value)); });
  }
}

}  // namespace

std::vector<Setting> methodSettings() {
  using R = Request;
  return {
      choiceSetting("method", &R::method, "name", {{"relaxation", Method::relaxation}, {"cat", Method::cat}},
                    "relaxation: separate overlapping cells of full size; cat: grow small cells in the cells "
                    "of the chordal axis transform"),
      choiceSetting("builder", &R::planeSource, "name",
                    {{"chords", PlaneSource::chords}, {"cat-faces", PlaneSource::catFaces}},
                    "with --method cat: source of the planes between cells")
          .onlyFor(Method::cat),
      setting("escape", &R::escape, flag(),
              "with --method cat: cells that remain small exchange places and grow into gaps")
          .onlyFor(Method::cat),
      setting("stock", {name(), count()},
              "with --escape: number of cells of that kind in reserve that can fill gaps",
              [](Request& s, const Values& v) { speciesNamed(s, text(v[0])).stock = whole(v[1]); })
          .byDefault("0"),
      setting("growth", {choice("parameter", growthNames()), plain(Kind::text, "value")},
              "with --method cat: set an attribute of <growth> (--reference lists them)",
              [](Request& s, const Values& v) { setGrowth(s, text(v[0]), text(v[1])); })
          .onlyFor(Method::cat),
      setting(
          "clearance", {clearance({"auto", "max"})},
          "minimum gap between membranes; auto: a tenth of dx, or as much of it as the hematocrit allows; "
          "max: the largest found within --max-time, or 60 s",
          [](Request& s, const Values& v) {
            s.clearance = numberIn(v[0]);
            s.largestClearance = isWord(v[0], "max");
          })
          .byDefault("auto")
          .withTag("clearance"),
      setting("wall-clearance", {clearance({"auto"})},
              "minimum gap between membrane and wall; auto: dx, or as much of it as the hematocrit allows",
              [](Request& s, const Values& v) { s.wallClearance = numberIn(v[0]); })
          .byDefault("auto")
          .withTag("wallClearance"),
      setting("cell-free-layer", &R::cellFreeLayer, clearance(),
              "minimum distance between red cells and the wall")
          .byDefault("none"),
      setting("profile", &R::profile, plain(Kind::text, "file"),
              "distribution of the cells over the distance from the wall: a table, or 'developed' for a "
              "cell-free layer with platelets in it, as blood has after flowing for a while")
          .byDefault("none: random positions")
          .onlyFor(Method::relaxation),
      setting("seed", &R::seed, seed(), "seed of the random numbers; the same seed gives the same bytes"),
      setting("noRotate", {flag()}, "keep every orientation at 0 0 0 (symmetry axis along y)",
              [](Request& s, const Values& v) { s.rotate = !yes(v[0]); })
          .byDefault("false")
          .alsoOfPackCells(),
      setting("", &R::rotate, flag(), "false: keep every orientation at 0 0 0 (symmetry axis along y)")
          .withTag("rotate"),
      choiceSetting(
          "order", &R::inColumns, "kind", {{"random", false}, {"columns", true}},
          "initial arrangement; columns: rouleaux of the species with the largest volume, denser than any "
          "random packing, in periodic boxes"),
  };
}

std::vector<Setting> limitSettings() {
  using R = Request;
  const ValueSpec sweeps = integer("n", "sweeps", 1, 1e15);
  return {
      setting(
          "max-time", &R::maxSeconds, number("s", "s", 0, true, 1e9),
          "time limit; if not all cells fit at once, fewer are packed first, which can take as long again. "
          "Then the run ends within 5 s, or within 2 s per 100,000 cells if that is more")
          .byDefault("no limit"),
      setting("max-iterations", &R::maxIterations, sweeps,
              "maximum number of relaxation sweeps or growth iterations (the search for the densest packing "
              "takes more)")
          .byDefault(std::to_string(Limits().maxSweeps)),
      setting("maxiter", &R::maxIterations, sweeps,
              "the same as --max-iterations, under the name it has in packCells")
          .withoutTag()
          .alsoOfPackCells(),
      setting("threads", &R::threads, integer("n", "threads", 1, maxThreads),
              "threads of each rank; the packing does not depend on their number")
          .byDefault("OMP_NUM_THREADS, SLURM_CPUS_PER_TASK, or all cores; with several ranks one")
          .withoutTag(),
      setting("best-effort", &R::bestEffort, flag(),
              "if the request is not feasible, write the densest certified packing that was found"),
      setting(
          "dry-run", &R::dryRun, flag(),
          "pack nothing; print volumes, numbers of cells, memory, time, and whether the request is feasible")
          .withoutTag()
          .notForCheck(),
      setting("validate", &R::validate, flag(), "pack nothing; only read the input and report errors")
          .withoutTag()
          .notForCheck(),
  };
}

}  // namespace packmesh::hemocell
