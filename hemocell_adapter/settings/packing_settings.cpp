// SPDX-License-Identifier: AGPL-3.0-or-later
// Request of the method and its limits.
#include <utility>

#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/settings/setting_groups.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/problem/execution.h"

namespace packmesh::hemocell {

namespace {

using namespace specs;

Value numberOrAuto(const std::optional<double>& number) {
  return number ? Value(*number) : Value(std::string("auto"));
}

std::vector<Setting> softSettings() {
  using R = Request;
  return {
      setting("soft", {flag({"auto"})},
              "cells deform by HemoCell's membrane laws where undeformed ones cannot be packed easily: in "
              "capillaries, and up to a hematocrit of 0.9; the result is a state. auto (=auto): only where "
              "undeformed ones cannot be packed at all",
              [](Request& s, const Values& v) {
                s.softIfNeeded = isWord(v[0], "auto");
                s.soft = s.softIfNeeded || yes(v[0]);
              })
          .readBy([](const R& r) { return r.softIfNeeded ? Value(std::string("auto")) : Value(r.soft); })
          .byDefault("false")
          .withTag("soft")
          .onlyFor(Method::relaxation)
          .notForCheck(),
      setting("max-force", &R::maxForce, number("f", "pN", 0, true, 1e6),
              "largest force on a vertex of a soft cell when HemoCell starts")
          .byDefault("10")
          .onlyFor(Method::relaxation)
          .notForCheck(),
      setting("max-volume-change", &R::maxVolumeChange, number("f", "fraction", 0, true, 1),
              "largest change of the volume of a soft cell")
          .byDefault("0.05")
          .onlyFor(Method::relaxation)
          .notForCheck(),
      setting("max-area-change", &R::maxAreaChange, number("f", "fraction", 0, true, 1),
              "largest change of the area of a soft cell")
          .byDefault("0.15")
          .onlyFor(Method::relaxation)
          .notForCheck(),
  };
}

}  // namespace

std::vector<Setting> methodSettings() {
  using R = Request;
  std::vector<Setting> all = {
      setting(
          "clearance", {clearance({"auto", "max"})},
          "minimum gap between membranes; auto: a tenth of dx, or as much of it as the hematocrit allows; "
          "max: the largest found within --max-time, or 60 s",
          [](Request& s, const Values& v) {
            s.clearance = numberIn(v[0]);
            s.largestClearance = isWord(v[0], "max");
          })
          .writtenBy([](const R& r) {
            return std::vector<Values>{
                {r.largestClearance ? Value(std::string("max")) : numberOrAuto(r.clearance)}};
          })
          .byDefault("auto")
          .withTag("clearance"),
      setting("wall-clearance", {clearance({"auto"})},
              "minimum gap between membrane and wall; auto: dx, or as much of it as the hematocrit allows",
              [](Request& s, const Values& v) { s.wallClearance = numberIn(v[0]); })
          .writtenBy([](const R& r) { return std::vector<Values>{{numberOrAuto(r.wallClearance)}}; })
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
          .statesKey("rotate")
          .byDefault("false")
          .alsoOfPackCells(),
      setting("", &R::rotate, flag(), "false: keep every orientation at 0 0 0 (symmetry axis along y)")
          .withTag("rotate"),
      choiceSetting(
          "order", &R::inColumns, "kind", {{"random", false}, {"columns", true}},
          "initial arrangement; columns: rouleaux of the species with the largest volume, denser than any "
          "random packing, in periodic boxes"),
  };
  for (Setting& setting : softSettings()) all.push_back(std::move(setting));
  return all;
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
          .statesKey("maxIterations")
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
