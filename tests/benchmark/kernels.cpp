// SPDX-License-Identifier: AGPL-3.0-or-later
#include "tests/benchmark/kernels.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <optional>
#include <random>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/growth_program.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/mesh/convex_hull.h"
#include "packMesh/mesh/mesh_intersection.h"
#include "packMesh/mesh/mesh_tree.h"
#include "packMesh/mesh/triangle_pair.h"
#include "packMesh/relaxation/contact_solver.h"
#include "packMesh/relaxation/neighbor_list.h"
#include "tests/benchmark/growth/spheres.h"
#include "tests/packMesh/mesh/test_meshes.h"

namespace packmesh::benchmark {
namespace {

using ::benchmark::DoNotOptimize;
using ::benchmark::State;

constexpr int examples = 2000;

struct Pair {
  Placement first, second;
};

const Shape& redCell() {
  static const std::shared_ptr<const Shape> shape = hemocell::makeShape(*hemocell::defaultModel("RBC"), 0.5);
  return *shape;
}

/// A mesh without a closed form: its surface is a sampled distance.
const Shape& redCellOnGrid() {
  static const Shape shape(redCell().mesh());
  return shape;
}

/// Random pairs of red cells with their centres `nearest` to `furthest` apart [µm].
std::vector<Pair> pairsAt(double nearest, double furthest) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0), distance(nearest, furthest);
  std::vector<Pair> pairs;
  for (int i = 0; i < examples; ++i) {
    const Vec3 at(coordinate(random), coordinate(random), coordinate(random));
    const Mat3 one = test::randomRotation(random), other = test::randomRotation(random);
    pairs.push_back({{one, at}, {other, at + distance(random) * test::randomDirection(random)}});
  }
  return pairs;
}

/// Of these, those that lie apart, with a gap below `below` [µm].
std::vector<Pair> apartPairs(double nearest, double furthest, double below) {
  std::vector<Pair> pairs;
  for (const Pair& pair : pairsAt(nearest, furthest)) {
    const MeshPairResult result =
        relate(redCell().hierarchy(), pair.first, redCell().hierarchy(), pair.second, below);
    if (result.relation == MeshRelation::apart && result.gap < below) pairs.push_back(pair);
  }
  return pairs;
}

/// Runs `work(example)` for one example after the other.
template <class Examples, class Work>
void forEach(State& state, const Examples& all, Work work) {
  std::size_t i = 0;
  for (auto _ : state) work(all[i++ % all.size()]);
}

// The exact test.

void relatePairs(State& state, double nearest, double furthest, double gapBelow, double interest) {
  const MeshHierarchy& cell = redCell().hierarchy();
  forEach(state, apartPairs(nearest, furthest, gapBelow),
          [&](const Pair& p) { DoNotOptimize(relate(cell, p.first, cell, p.second, interest)); });
}

void cullByHulls(State& state) {
  const ConvexHull& hull = redCell().hierarchy().tree().hull;
  forEach(state, pairsAt(2.5, 7.5), [&](const Pair& p) {
    const Mat3 inverse = p.first.linear.inverse();
    const Vec3 translation = inverse * (p.second.translation - p.first.translation);
    DoNotOptimize(hullsApart(hull, hull, inverse * p.second.linear, translation, -translation, 0.02, 1e-9));
  });
}

/// Pairs of triangles of two red cells that are near each other.
std::vector<std::array<Vec3, 6>> trianglePairs() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> offset(-0.4, 0.4);
  std::vector<std::array<Vec3, 6>> pairs;
  const TriangleMesh& mesh = redCell().mesh();
  for (int i = 0; i < examples; ++i) {
    const int t = static_cast<int>(random() % mesh.triangles.size());
    const Placement turned{test::randomRotation(random), Vec3::Zero()};
    const Vec3 to =
        mesh.corner(t, 0) + Vec3(offset(random), offset(random), offset(random)) - turned(mesh.corner(t, 1));
    pairs.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), turned(mesh.corner(t, 0)) + to,
                     turned(mesh.corner(t, 1)) + to, turned(mesh.corner(t, 2)) + to});
  }
  return pairs;
}

void triangleTest(State& state) {
  forEach(state, trianglePairs(),
          [](const auto& p) { DoNotOptimize(trianglesMeet(p[0], p[1], p[2], p[3], p[4], p[5])); });
}

void distanceOfTriangles(State& state) {
  forEach(state, trianglePairs(),
          [](const auto& p) { DoNotOptimize(triangleDistance(p[0], p[1], p[2], p[3], p[4], p[5])); });
}

// Relaxation.

RelativeFrame frameOf(const Pair& pair) {
  RelativeFrame frame{};
  const Mat3 m = pair.first.linear.transpose() * pair.second.linear;
  const Vec3 t = pair.first.linear.transpose() * (pair.second.translation - pair.first.translation);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) frame.m[3 * r + c] = static_cast<float>(m(r, c));
    frame.t[r] = static_cast<float>(t[r]);
  }
  frame.scale = 1.0f;
  return frame;
}

void contactOf(State& state, const Shape& shape, bool coarsely) {
  const ContactViews& model = shape.views();
  const ContactKernel kernel = contactKernel(chosenInstructionSet());
  forEach(state, pairsAt(2.5, 7.5), [&](const Pair& p) {
    ClusterMask mask = allClusters;
    ContactSums sums;
    kernel(coarsely ? model.coarseSamples : model.samples, frameOf(p), model.field, 0.02f, 0.05f, mask, sums);
    DoNotOptimize(sums);
  });
}

/// Of red cells at a volume fraction of 0.45 in 100³ µm.
void listOfPairs(State& state) {
  const Box bounds{Vec3::Zero(), Vec3::Constant(100.0)};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> coordinate(0.0, 100.0);
  std::vector<Body> bodies(5548);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].position = {coordinate(random), coordinate(random), coordinate(random)};
    bodies[i].id = static_cast<std::int64_t>(i);
  }
  const std::vector<double> radii = {redCell().radius()};
  const std::vector<std::int64_t> start = {0, 5548};
  for (auto _ : state) {
    PairList list(1);
    PairLister({bodies, start, radii, 0.2 * radii[0], bounds, Vec3::Constant(100.0)}).list({0}, {}, list);
    DoNotOptimize(list[0].size());
  }
}

// Growth.

/// The largest step of a red cell among planes 0.1 to 0.5 µm away from its vertices.
void linearProgram(State& state) {
  const TriangleMesh& mesh = redCell().mesh();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> gap(0.1, 0.5);
  std::vector<LinearProgram> programs(20);
  for (LinearProgram& program : programs) {
    program.objective[0] = 1.0;
    program.lower.setConstant(-1.0);
    program.upper.setConstant(1.0);
    for (const Vec3& v : mesh.vertices) {
      const Vec3 n = (v.normalized() + 0.5 * test::randomDirection(random)).normalized();
      const Vec3 torque = v.cross(n);
      const double row[] = {n.dot(v), torque.x(), torque.y(), torque.z(), n.x(), n.y(), n.z()};
      program.addRow(LinearProgram::Vector(row), gap(random));
    }
  }
  forEach(state, programs, [](const LinearProgram& program) { DoNotOptimize(program.solve().pivots); });
}

const Spheres& sphere() {
  static const Spheres sixteen(16, 1.0);
  return sixteen;
}

void tetrahedra(State& state, TetrahedraKind kind) {
  TetrahedraInput input = sphere().input;
  input.kind = kind;
  for (auto _ : state) DoNotOptimize(tetrahedralise(input).tetrahedra.size());
}

void chordalSplit(State& state) {
  const Tetrahedra cut = tetrahedralise(sphere().input);
  ChordalFaces faces;
  for (auto _ : state) {
    splitChordally(cut, WallFaces::atWall, faces);
    DoNotOptimize(faces.faces.size());
  }
}

/// Prints rows of a table, and keeps them.
class Table : public ::benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override {
    fmt::print("| kernel | time (µs) |\n| --- | ---: |\n");
    return true;
  }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      const double microseconds = 1e6 * run.cpu_accumulated_time / static_cast<double>(run.iterations);
      fmt::print("| {} | {:.3g} |\n", run.benchmark_name(), microseconds);
      std::fflush(stdout);
      rows.push_back({{"kernel", run.benchmark_name()}, {"microseconds", microseconds}});
    }
  }
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
};

void registerAll() {
  const auto add = [](const char* name, auto work) { ::benchmark::RegisterBenchmark(name, work); };
  const auto exact = [&](const char* name, double from, double to, double gapBelow, double interest) {
    add(name, [=](State& state) { relatePairs(state, from, to, gapBelow, interest); });
  };
  constexpr double any = 10.0;
  exact("exact test: red cells that lie apart", 2.5, 7.5, any, 0.0);
  exact("exact test: nearer than 0.1 µm", 2.5, 7.5, 0.1, 0.0);
  exact("exact test: nested and stacked", 2.5, 4.5, any, 0.0);
  exact("exact test: gaps below 0.02 µm measured", 2.5, 7.5, any, 0.02);
  exact("distance: gaps below 1 µm measured", 2.5, 7.5, any, 1.0);
  add("cull: convex hulls of two red cells", cullByHulls);
  add("triangle test", triangleTest);
  add("distance of two triangles", distanceOfTriangles);
  const auto contact = [&](const char* name, const Shape& (*shape)(), bool coarsely) {
    add(name, [=](State& state) { contactOf(state, shape(), coarsely); });
  };
  contact("contact: red cell", redCell, false);
  contact("contact: red cell, coarse samples", redCell, true);
  contact("contact: the same on a grid", redCellOnGrid, false);
  add("cull: list of pairs, 5,548 red cells", listOfPairs);
  add("LP: 642 rows", linearProgram);
  add("tetrahedralisation: constrained, 16 red cells",
      [](State& state) { tetrahedra(state, TetrahedraKind::constrained); });
  add("tetrahedralisation: Delaunay, 16 red cells",
      [](State& state) { tetrahedra(state, TetrahedraKind::delaunay); });
  add("CAT split: 16 red cells", chordalSplit);
}

}  // namespace

nlohmann::ordered_json runKernels() {
  registerAll();
  int argc = 1;
  char name[] = "kernels";
  char* argv[] = {name, nullptr};
  ::benchmark::Initialize(&argc, argv);
  Table table;
  ::benchmark::RunSpecifiedBenchmarks(&table);
  return table.rows;
}

}  // namespace packmesh::benchmark
