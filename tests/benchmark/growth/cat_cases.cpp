// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cost and number of CAT faces against that of the tetrahedra (thesis 4.2).
#include <cmath>
#include <cstdio>

#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/tetrahedra.h"
#include "tests/benchmark/growth/spheres.h"
#include "tests/benchmark/growth/svg_plot.h"

namespace packmesh::benchmark {
namespace {

void table41(const Options&) {
  constexpr int count = 128, repeats = 5;
  const Spheres spheres(count, 1.0);
  struct Row {
    const char* name;
    std::vector<double> seconds;
  };
  std::vector<Row> rows = {{"plain `tetgen -p`", {}},
                           {"CDT as growth calls it", {}},
                           {"plain Delaunay", {}},
                           {"CAT faces, fresh memory", {}},
                           {"CAT faces, memory used again", {}}};
  ChordalFaces used;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    TetrahedraInput input = spheres.input;
    Tetrahedra tetrahedra;
    rows[0].seconds.push_back(plainTetgenSeconds(input));
    rows[1].seconds.push_back(timeOf([&] { tetrahedra = tetrahedralise(input); }));
    ChordalFaces fresh;
    rows[3].seconds.push_back(timeOf([&] { splitChordally(tetrahedra, WallFaces::atWall, fresh); }));
    rows[4].seconds.push_back(timeOf([&] { splitChordally(tetrahedra, WallFaces::atWall, used); }));
    input.kind = TetrahedraKind::delaunay;
    rows[2].seconds.push_back(timeOf([&] { tetrahedra = tetrahedralise(input); }));
  }
  fmt::print(
      "{} red cells of {} vertices in a sphere, coverage 0.30, full scale; median of {} interleaved runs, "
      "CPU.\n\n",
      count, spheres.shape->mesh().vertices.size(), repeats);
  fmt::print(
      "| function | time (s) | / plain `tetgen -p` | thesis (table 4.1) |\n| --- | ---: | ---: | ---: |\n");
  for (const Row& row : rows) {
    std::vector<double> ratios;
    for (int repeat = 0; repeat < repeats; ++repeat)
      ratios.push_back(row.seconds[repeat] / rows[0].seconds[repeat]);
    fmt::print("| {} | {:.4f} | {:.4f} | {} |\n", row.name, medianOf(row.seconds), medianOf(ratios),
               &row == &rows[0]          ? "1"
               : &row - rows.data() >= 3 ? "329"
                                         : "");
  }
}

void figures4748(const Options& options) {
  fmt::print(
      "Red cells at full detail in a sphere, coverage 0.30 at full scale. Thesis: 2.9 relevant tetrahedra "
      "per vertex, "
      "about 1.2 faces per tetrahedron.\n\n");
  fmt::print(
      "| scale | cells | vertices | relevant tetrahedra | per vertex | CAT faces | per tetrahedron | 3-1 | "
      "2-2 | 2-1-1 | "
      "1-1-1-1 | CDT ms/cell | CAT ms/cell |\n"
      "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  Plot tetrahedraPlot{
      "Figure 4.7: tetrahedra that join objects", "vertices", "relevant tetrahedra", false, false, {}};
  Plot facesPlot{"Figure 4.8: CAT faces per relevant tetrahedron",
                 "red cells",
                 "faces per tetrahedron",
                 true,
                 false,
                 {}};
  Plot costPlot{"Cost per cell", "red cells", "CPU time per cell [ms]", true, true, {}};
  for (const double scale : {0.1, 1.0}) {
    const std::string name = fmt::format("scale {}", scale);
    tetrahedraPlot.lines.push_back({name, {}});
    facesPlot.lines.push_back({name, {}});
    costPlot.lines.push_back({"CDT, " + name, {}});
    costPlot.lines.push_back({"CAT faces, " + name, {}});
    for (int count = 8; count <= 512; count *= 2) {
      const Spheres spheres(count, scale);
      Tetrahedra tetrahedra;
      ChordalFaces split;
      const double cdt = timeOf([&] { tetrahedra = tetrahedralise(spheres.input); });
      std::vector<double> cat;
      for (int repeat = 0; repeat < 5; ++repeat)
        cat.push_back(timeOf([&] { splitChordally(tetrahedra, WallFaces::atWall, split); }));
      const auto& cases = split.tetrahedra;
      const double relevant = static_cast<double>(cases[1] + cases[2] + cases[3] + cases[4]);
      const double vertices = static_cast<double>(spheres.vertices()),
                   faces = static_cast<double>(split.faces.size());
      fmt::print(
          "| {} | {} | {:.0f} | {:.0f} | {:.3f} | {:.0f} | {:.3f} | {:.3f} | {:.3f} | {:.3f} | {:.4f} | "
          "{:.2f} | {:.3f} |\n",
          scale, count, vertices, relevant, relevant / vertices, faces, faces / relevant, cases[1] / relevant,
          cases[2] / relevant, cases[3] / relevant, cases[4] / relevant, 1e3 * cdt / count,
          1e3 * medianOf(cat) / count);
      std::fflush(stdout);
      tetrahedraPlot.lines.back().points.emplace_back(vertices, relevant);
      facesPlot.lines.back().points.emplace_back(count, faces / relevant);
      costPlot.lines[costPlot.lines.size() - 2].points.emplace_back(count, 1e3 * cdt / count);
      costPlot.lines.back().points.emplace_back(count, 1e3 * medianOf(cat) / count);
    }
  }
  const std::vector<std::pair<double, double>>& last = tetrahedraPlot.lines.back().points;
  tetrahedraPlot.lines.push_back(
      {"thesis: 2.9 per vertex", {{0.0, 0.0}, {last.back().first, 2.9 * last.back().first}}});
  facesPlot.lines.push_back({"thesis: about 1.2", {{8.0, 1.2}, {512.0, 1.2}}});
  if (options.folder.empty()) return;
  tetrahedraPlot.write(options.folder / "figure_4_7.svg");
  facesPlot.write(options.folder / "figure_4_8.svg");
  costPlot.write(options.folder / "cat_cost_per_cell.svg");
}

const AddCases cases({
    {"table-4.1-cat", "time of the CAT faces against one plain `tetgen -p` run (thesis table 4.1)", table41},
    {"figures-4.7-4.8", "relevant tetrahedra per vertex and CAT faces per tetrahedron, N = 8 ... 512",
     figures4748},
});

}  // namespace
}  // namespace packmesh::benchmark
