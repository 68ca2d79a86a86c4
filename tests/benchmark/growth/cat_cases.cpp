// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Cost and number of CAT faces against that of the tetrahedra (thesis 4.2).
#include <cmath>
#include <cstdio>

#define TETLIBRARY
#include <tetgen.h>

#include "hemocell_adapter/cell_model.h"
#include "packMesh/container/primitives.h"
#include "packMesh/packing/pack.h"
#include "packMesh/stages/growth/chordal_split.h"
#include "tests/benchmark/growth/cases.h"
#include "tests/benchmark/growth/svg_plot.h"

namespace packmesh::benchmark {
namespace {

/// Red cells at full detail in a sphere, as in thesis 4.2: 30 % of its volume when grown.
struct Spheres {
  std::shared_ptr<const Shape> shape = hemocell::makeShape(*hemocell::defaultModel("RBC"), 0.5);
  std::unique_ptr<MeshHierarchy> wall;
  TetrahedraInput input;

  Spheres(int count, double scale) {
    PackingProblem problem;
    problem.container = makeSphere(Vec3::Zero(), std::cbrt(0.75 * count * shape->volume() / (0.3 * M_PI)));
    problem.species = {{"RBC", shape, count, nullptr}};
    wall = std::make_unique<MeshHierarchy>(problem.container->surface());
    for (const PlacedCell& cell : pack(problem).cells)
      input.objects.push_back(
          {&shape->hierarchy(), {scale * cell.placement.linear, cell.placement.translation}});
    input.container = wall.get();
    input.kept = TetrahedraKept::joining;
    input.valid = true;
  }
  std::size_t vertices() const { return input.objects.size() * shape->mesh().vertices.size(); }
};

/// One plain `tetgen -p` run: TetGen's own program does just this between reading and writing files.
double plainTetgenSeconds(const TetrahedraInput& input) {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  const auto add = [&](const TriangleMesh& mesh, const Placement& placement) {
    const int first = static_cast<int>(points.size());
    for (const Vec3& v : mesh.vertices) points.push_back(placement(v));
    for (const Triangle& t : mesh.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  };
  for (const PlacedMesh& object : input.objects) add(object.mesh->mesh(), object.placement);
  add(input.container->mesh(), Placement());
  tetgenio in, out;
  in.numberofpoints = static_cast<int>(points.size());
  in.pointlist = new double[3 * points.size()];
  for (std::size_t p = 0; p < points.size(); ++p)
    for (int k = 0; k < 3; ++k) in.pointlist[3 * p + k] = points[p][k];
  in.numberoffacets = static_cast<int>(triangles.size());
  in.facetlist = new tetgenio::facet[triangles.size()];
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    tetgenio::facet& facet = in.facetlist[t];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3]{triangles[t][0], triangles[t][1], triangles[t][2]};
  }
  char switches[] = "pQ";
  return timeOf([&] { tetrahedralize(switches, &in, &out); });
}

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
