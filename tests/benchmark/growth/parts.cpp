// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What one iteration of growth costs, part by part (thesis table 4.1, figures 4.5 and 4.6), and the
/// number and cost of CAT faces against those of the tetrahedra (thesis 4.2).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/cat_engine.h"
#include "packMesh/cat/cat_face_planes.h"
#include "packMesh/cat/growth.h"
#include "packMesh/cat/tetrahedra.h"
#include "tests/benchmark/growth/cases.h"
#include "tests/support/packings.h"

namespace packmesh::benchmark {
namespace {

constexpr double lastScale = 0.95;

/// Red cells at full detail in a sphere, as in thesis 4.2: 30 % of its volume when grown.
struct Spheres {
  std::shared_ptr<const Shape> shape = test::redCellShape();
  PackingProblem problem;
  std::vector<Pose> poses;  ///< at `scale`
  std::unique_ptr<MeshHierarchy> wall;
  TetrahedraInput input;

  Spheres(int count, double scale) {
    problem.physics.container =
        makeSphere(Vec3::Zero(), std::cbrt(0.75 * count * shape->volume() / (0.3 * M_PI)));
    problem.physics.add("RBC", shape, count);
    wall = std::make_unique<MeshHierarchy>(problem.physics.container->surface());
    poses = pack(problem).poses;
    for (Pose& pose : poses) {
      pose.scale = scale;
      input.objects.push_back({&shape->hierarchy(), pose.placement()});
    }
    input.container = wall.get();
    input.kept = TetrahedraKept::joining;
    input.valid = true;
  }
  std::size_t vertices() const { return input.objects.size() * shape->mesh().vertices.size(); }
};

double medianOf(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Seconds of some functions in interleaved runs, as ratios to those of the first one.
class Timings {
 public:
  static constexpr int cells = 128, repeats = 5;

  void add(const std::string& name, double seconds) {
    const auto row =
        std::find_if(rows_.begin(), rows_.end(), [&](const Row& known) { return known.name == name; });
    (row == rows_.end() ? rows_.emplace_back(Row{name, {}}) : *row).seconds.push_back(seconds);
  }
  void print(const std::string& what) const {
    fmt::print(
        "{} red cells in a sphere, coverage 0.30, {}; median of {} interleaved runs, CPU.\n\n"
        "| function | time (s) | / {} |\n| --- | ---: | ---: |\n",
        cells, what, repeats, rows_[0].name);
    for (const Row& row : rows_) {
      std::vector<double> ratios;
      for (std::size_t k = 0; k < row.seconds.size(); ++k)
        ratios.push_back(row.seconds[k] / rows_[0].seconds[k]);
      fmt::print("| {} | {:.4f} | {:.4f} |\n", row.name, medianOf(row.seconds), medianOf(ratios));
    }
    fmt::print("\nThesis: CAT faces 329, growth 6, validation 181.\n");
  }

 private:
  struct Row {
    std::string name;
    std::vector<double> seconds;
  };
  std::vector<Row> rows_;
};

struct Parts {
  double planes, tetrahedra, faces, programmes, validation;
  double all() const { return planes + programmes + validation; }
};

/// One iteration from the state of `spheres` up to the barrier.
Parts iterationOf(const Spheres& spheres, PlaneSource planeSource, double barrier) {
  const Physics& physics = spheres.problem.physics;
  const Execution& execution = spheres.problem.execution;
  std::vector<Body> state;
  for (const Pose& pose : spheres.poses) state.push_back(makeBody(std::int64_t(state.size()), 0, 0, pose));
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

void table41(const Options&) {
  const Spheres spheres(Timings::cells, lastScale);
  Timings timings;
  for (int repeat = 0; repeat < Timings::repeats; ++repeat) {
    timings.add("plain `tetgen -p`", plainTetgenSeconds(spheres.input));
    for (const PlaneSource planeSource : {PlaneSource::catFaces, PlaneSource::chords}) {
      const Parts parts = iterationOf(spheres, planeSource, 1.0);
      const std::string of = fmt::format(" ({})", nameOf(planeSource));
      if (planeSource == PlaneSource::catFaces) {
        timings.add("tetrahedra" + of, parts.tetrahedra);
        timings.add("CAT faces and their planes" + of, parts.faces);
      }
      timings.add("all planes" + of, parts.planes);
      timings.add("growth" + of, parts.programmes);
      timings.add("validation" + of, parts.validation);
      timings.add("whole iteration" + of, parts.all());
    }
  }
  timings.print(fmt::format("last step (scale {} to 1)", lastScale));
}

void table41Cat(const Options&) {
  const Spheres spheres(Timings::cells, 1.0);
  Timings timings;
  ChordalFaces used;
  for (int repeat = 0; repeat < Timings::repeats; ++repeat) {
    TetrahedraInput input = spheres.input;
    Tetrahedra tetrahedra;
    timings.add("plain `tetgen -p`", plainTetgenSeconds(input));
    timings.add("CDT as growth calls it", timeOf([&] { tetrahedra = tetrahedralise(input); }));
    ChordalFaces fresh;
    timings.add("CAT faces, fresh memory",
                timeOf([&] { splitChordally(tetrahedra, WallFaces::atWall, fresh); }));
    timings.add("CAT faces, memory used again",
                timeOf([&] { splitChordally(tetrahedra, WallFaces::atWall, used); }));
    input.kind = TetrahedraKind::delaunay;
    timings.add("plain Delaunay", timeOf([&] { tetrahedra = tetrahedralise(input); }));
  }
  timings.print("full scale");
}

void figures4546(const Options&) {
  fmt::print(
      "Red cells in a sphere, coverage 0.30 at full scale; CPU time per cell and iteration [ms]. First step: "
      "scale 0.1 to 0.3, with a quarter of the vertices; last step: {} to 1.\n\n"
      "| step | builder | cells | tetrahedra | planes | growth | validation | iteration |\n"
      "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      lastScale);
  for (const bool last : {false, true})
    for (const PlaneSource planeSource : {PlaneSource::catFaces, PlaneSource::chords})
      for (int count = 8; count <= 512; count *= 2) {
        const Spheres spheres(count, last ? lastScale : 0.1);
        const Parts p = iterationOf(spheres, planeSource, last ? 1.0 : 0.3);
        const double each = 1e3 / count;
        fmt::print("| {} | {} | {} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} |\n", last ? "last" : "first",
                   nameOf(planeSource), count, each * p.tetrahedra, each * (p.planes - p.tetrahedra),
                   each * p.programmes, each * p.validation, each * p.all());
        std::fflush(stdout);
      }
}

void figures4748(const Options&) {
  fmt::print(
      "Red cells at full detail in a sphere, coverage 0.30 at full scale. Thesis: 2.9 relevant tetrahedra "
      "per vertex, about 1.2 faces per tetrahedron.\n\n"
      "| scale | cells | vertices | relevant tetrahedra | per vertex | CAT faces | per tetrahedron | 3-1 | "
      "2-2 | 2-1-1 | 1-1-1-1 | CDT ms/cell | CAT ms/cell |\n"
      "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  for (const double scale : {0.1, 1.0})
    for (int count = 8; count <= 512; count *= 2) {
      const Spheres spheres(count, scale);
      Tetrahedra tetrahedra;
      ChordalFaces split;
      const double cdt = timeOf([&] { tetrahedra = tetrahedralise(spheres.input); });
      std::vector<double> cat;
      for (int repeat = 0; repeat < 5; ++repeat)
        cat.push_back(timeOf([&] { splitChordally(tetrahedra, WallFaces::atWall, split); }));
      const auto& cases = split.tetrahedra;
      const double relevant = double(cases[1] + cases[2] + cases[3] + cases[4]);
      const double vertices = double(spheres.vertices()), faces = double(split.faces.size());
      fmt::print(
          "| {} | {} | {:.0f} | {:.0f} | {:.3f} | {:.0f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.4f} | "
          "{:.2f} | {:.3f} |\n",
          scale, count, vertices, relevant, relevant / vertices, faces, faces / relevant, cases[1] / relevant,
          cases[2] / relevant, cases[3] / relevant, cases[4] / relevant, 1e3 * cdt / count,
          1e3 * medianOf(cat) / count);
      std::fflush(stdout);
    }
}

}  // namespace

std::vector<Case> partCases() {
  return {
      {"table-4.1", "one iteration of growth against one plain `tetgen -p` run (thesis table 4.1)", table41},
      {"table-4.1-cat", "time of the CAT faces against one plain `tetgen -p` run (thesis table 4.1)",
       table41Cat},
      {"figures-4.5-4.6", "time per cell of the parts of an iteration, N = 8 ... 512", figures4546},
      {"figures-4.7-4.8", "relevant tetrahedra per vertex and CAT faces per tetrahedron, N = 8 ... 512",
       figures4748},
  };
}

}  // namespace packmesh::benchmark
