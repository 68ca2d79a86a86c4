// SPDX-License-Identifier: AGPL-3.0-or-later
// Request of the output, and ignored options of packCells.
#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/settings/setting_groups.h"
#include "hemocell_adapter/settings/value_specs.h"

namespace packmesh::hemocell {

using namespace specs;

std::vector<Setting> outputSettings() {
  using R = Request;
  using O = OutputRequest;
  const auto times = [](const char* axis) { return integer(axis, "", 1, 1e4); };
  return {
      setting("output-dir", &O::folder, plain(Kind::text, "folder"),
              "folder of the .pos files (with check: to read them from)")
          .byDefault("that of config.xml; without one the working directory")
          .withTag("outputDirectory"),
      setting("realisations", &R::realisations, times("n"),
              "number of packings, with consecutive seeds from --seed on, in folders realisation_1, "
              "realisation_2 ...")
          .notForCheck(),
      setting("tile", {times("nx"), times("ny"), times("nz")},
              "numbers of copies of the periodic box along each axis, in a larger box",
              [](Request& s, const Values& v) {
                s.tiles = {int(whole(v[0])), int(whole(v[1])), int(whole(v[2]))};
              })
          .writtenBy([](const R& r) {
            return std::vector<Values>{{Value(std::int64_t(r.tiles[0])), Value(std::int64_t(r.tiles[1])),
                                        Value(std::int64_t(r.tiles[2]))}};
          })
          .notForCheck(),
      setting(
          "export", {choice("format", {std::begin(exportFormats), std::end(exportFormats)})},
          fmt::format("also write the cells, with the meshes they need, for other programs: {} (vtk: same "
                      "as --vtp, vtk-meshes: --vtp-meshes)",
                      fmt::join(exportFormats, ", ")),
          [](Request& s, const Values& v) {
            if (std::find(s.output.exports.begin(), s.output.exports.end(), text(v[0])) ==
                s.output.exports.end())
              s.output.exports.push_back(text(v[0]));
          })
          .writtenBy([](const R& r) {
            std::vector<Values> all;
            for (const std::string& format : r.output.exports) all.push_back({format});
            return all;
          })
          .withTag("export")
          .mayRepeat(),
      setting(
          "checkpoint-every", &O::checkpointEvery, number("s", "s", 0, true, 1e9),
          "interval at which a checkpoint is saved beside the state file, to continue after an interruption")
          .byDefault("only at signals and at the end of a run that failed, with --state")
          .notForCheck(),
      setting("state", &O::stateFile, file(),
              "file of the state of the result, written with the .pos files; until then what is reached is "
              "saved in "
              "<name>.checkpoint.h5 at SIGUSR1, when interrupted, and if the run fails")
          .byDefault("state.h5 beside the .pos files, with --checkpoint-every")
          .withTag("stateFile")
          .notForCheck(),
      setting("restart", &R::restart, file(),
              "continue from a checkpoint, or a state; alone: with the command that started the run")
          .withoutTag()
          .notForCheck(),
      setting("pov", &O::povScene, flag(), "same as --vtp").withTag("povScene"),
      setting("vtp", &O::vtp, flag(),
              "write <Cell>.vtp for ParaView: the cells as points with their measurements, their meshes, "
              "and lumen.vtp"),
      setting("vtp-meshes", &O::vtpMeshes, flag(),
              "write <Cell>_cells.vtp: all membranes (about 65 kB per red cell)"),
      framesSetting(),
      setting("report", &O::reportFile, file(),
              "write a report: file.json, or file.html with an interactive view (and file.json beside it)"),
      setting("quiet", &R::quiet, flag(), "print only warnings and errors").withoutTag(),
      setting("verbose", &R::verbose, flag(), "print progress, and every violation that a check finds")
          .withoutTag(),
  };
}

std::vector<Setting> ignoredSettings() {
  return {
      setting("allowRotate", {flag()}, "orientations are random by default", [](Request&, const Values&) {})
          .withLetter('r')
          .alsoOfPackCells(),
      setting("scale", &Request::ignoredScale, number("s", "", 0, false, 1e9),
              "neighbour grid of packCells; packMesh has none")
          .withoutTag()
          .withLetter('s')
          .alsoOfPackCells()};
}

}  // namespace packmesh::hemocell
