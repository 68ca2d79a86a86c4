// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What one iteration of growth costs, part by part (thesis table 4.1, figures 4.5 and 4.6).
#include <fmt/format.h>

#include <cstdio>

#include "packMesh/cat/cat_engine.h"
#include "packMesh/cat/cat_face_planes.h"
#include "packMesh/cat/growth.h"
#include "tests/benchmark/growth/spheres.h"
#include "tests/benchmark/growth/svg_plot.h"

namespace packmesh::benchmark {
namespace {

struct Parts {
  double planes, tetrahedra, faces, programmes, validation;
  double all() const { return planes + programmes + validation; }
};

/// One iteration from the state of `spheres` up to the barrier.
Parts iterationOf(const Spheres& spheres, PlaneSource planeSource, double barrier) {
  const Physics& physics = spheres.problem.physics;
  const Execution& execution = spheres.problem.execution;
  std::vector<Body> state;
  for (const Pose& pose : spheres.poses)
    state.push_back(makeBody(static_cast<std::int64_t>(state.size()), 0, 0, pose));
  GrowthSettings settings;
  settings.barriers = {barrier};
  settings.maxIterations = 1;
  settings.initialScale = std::min(settings.initialScale, 0.5 * barrier);
  TetrahedraSums sums;
  const std::unique_ptr<PlaneFunction> planes = makePlaneFunction(planeSource, physics, execution, sums);
  GrowthStatistics statistics;
  grow(physics, execution, settings, *planes, {}, state, statistics);
  return {statistics.planeSeconds, sums.tetrahedraSeconds, sums.faceSeconds, statistics.programSeconds,
          statistics.stepHalvingSeconds};
}

const char* nameOf(PlaneSource planeSource) {
  return planeSource == PlaneSource::chords ? "chords" : "cat-faces";
}

constexpr double lastScale = 0.95;

void table41(const Options&) {
  constexpr int count = 128, repeats = 5;
  const Spheres spheres(count, lastScale);
  fmt::print(
      "{} red cells of {} vertices in a sphere, coverage 0.30, last step (scale {} to 1); median of {} "
      "interleaved "
      "runs, CPU; ratios to one plain `tetgen -p` run on the same meshes.\n\n",
      count, spheres.shape->mesh().vertices.size(), lastScale, repeats);
  std::vector<double> plain;
  struct Row {
    std::string name;
    std::vector<double> seconds;
  };
  std::vector<Row> rows;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    plain.push_back(plainTetgenSeconds(spheres.input));
    std::size_t row = 0;
    const auto add = [&](const std::string& name, double seconds) {
      if (row == rows.size()) rows.push_back({name, {}});
      rows[row++].seconds.push_back(seconds);
    };
    for (const PlaneSource planeSource : {PlaneSource::catFaces, PlaneSource::chords}) {
      const Parts parts = iterationOf(spheres, planeSource, 1.0);
      const std::string of = fmt::format(" ({})", nameOf(planeSource));
      if (planeSource == PlaneSource::catFaces) {
        add("tetrahedra" + of, parts.tetrahedra);
        add("CAT faces and their planes" + of, parts.faces);
      }
      add("all planes" + of, parts.planes);
      add("growth" + of, parts.programmes);
      add("validation" + of, parts.validation);
      add("whole iteration" + of, parts.all());
    }
  }
  fmt::print("| function | time (s) | / plain `tetgen -p` |\n| --- | ---: | ---: |\n");
  fmt::print("| plain `tetgen -p` | {:.4f} | 1 |\n", medianOf(plain));
  for (const Row& row : rows) {
    std::vector<double> ratios;
    for (int repeat = 0; repeat < repeats; ++repeat) ratios.push_back(row.seconds[repeat] / plain[repeat]);
    fmt::print("| {} | {:.4f} | {:.4f} |\n", row.name, medianOf(row.seconds), medianOf(ratios));
  }
  fmt::print("\nThesis: CAT faces 329, growth 6, validation 181.\n");
}

void figures4546(const Options& options) {
  fmt::print(
      "Red cells in a sphere, coverage 0.30 at full scale; CPU time per cell and iteration [ms]. First step: "
      "scale "
      "0.1 to 0.3, with a quarter of the vertices; last step: {} to 1.\n\n"
      "| step | builder | cells | tetrahedra | planes | growth | validation | iteration |\n"
      "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      lastScale);
  for (const bool last : {false, true}) {
    Plot plot{last ? "Figure 4.5, last step" : "Figure 4.5, first step",
              "red cells",
              "CPU time per cell [ms]",
              true,
              true,
              {}};
    for (const PlaneSource planeSource : {PlaneSource::catFaces, PlaneSource::chords}) {
      const std::size_t first = plot.lines.size();
      for (const char* part : {"planes", "growth", "validation"})
        plot.lines.push_back({fmt::format("{}, {}", part, nameOf(planeSource)), {}});
      for (int count = 8; count <= 512; count *= 2) {
        const Spheres spheres(count, last ? lastScale : 0.1);
        const Parts p = iterationOf(spheres, planeSource, last ? 1.0 : 0.3);
        const double each = 1e3 / count;
        fmt::print("| {} | {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} |\n", last ? "last" : "first",
                   nameOf(planeSource), count, each * p.tetrahedra, each * (p.planes - p.tetrahedra),
                   each * p.programmes, each * p.validation, each * p.all());
        std::fflush(stdout);
        const double values[] = {p.planes, p.programmes, p.validation};
        for (std::size_t k = 0; k < 3; ++k)
          plot.lines[first + k].points.emplace_back(count, std::max(1e-6, each * values[k]));
      }
    }
    if (!options.folder.empty())
      plot.write(options.folder / (last ? "figure_4_5_last.svg" : "figure_4_5_first.svg"));
  }
}

const AddCases cases({
    {"table-4.1", "one iteration of growth against one plain `tetgen -p` run (thesis table 4.1)", table41},
    {"figures-4.5-4.6", "time per cell of the parts of an iteration, N = 8 ... 512", figures4546},
});

}  // namespace
}  // namespace packmesh::benchmark
