// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Whole packings by growth: red cells in spheres (thesis figure 4.4) and periodic boxes, single
/// objects in thin copies of themselves (thesis figure 4.3), other closed meshes, threads, padding, and
/// escape.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "packMesh/certificate/certifier.h"
#include "tests/benchmark/growth/cases.h"
#include "tests/support/bodies.h"

namespace packmesh::benchmark {
namespace {

/// One packing and what it is expected to take.
struct GrownPacking {
  std::string name;
  std::function<PackingProblem()> problem;
};

/// Packs, and certifies every accepted state by itself.
/// @return the number of states; -1 when one was not valid
std::int64_t checkStates(PackingProblem problem) {
  std::int64_t states = 0;
  bool valid = true;
  problem.execution.observe = [&](const std::vector<PlacedCell>& cells) {
    valid = valid && certify(certificateInputOf(problem.physics, cells), 1e-3).clean();
    ++states;
  };
  pack(problem);
  return valid ? states : -1;
}

/// `count` cells, to be grown.
PackingProblem grown(std::shared_ptr<const Shape> shape, std::int64_t count,
                     std::shared_ptr<const Container> container,
                     PlaneSource planeSource = PlaneSource::chords) {
  PackingProblem problem;
  problem.physics.add("cell", std::move(shape), count);
  problem.physics.container = std::move(container);
  test::useCat(problem).planeSource = planeSource;
  return problem;
}

/// A sphere of which `count` cells are the given fraction.
std::unique_ptr<Container> sphereFor(const Shape& shape, std::int64_t count, double fraction) {
  return makeSphere(Vec3::Zero(), std::cbrt(0.75 / M_PI * double(count) * shape.volume() / fraction));
}

/// Red cells that are the given fraction of a periodic cube.
PackingProblem grownInBox(double edge, double fraction, PlaneSource planeSource = PlaneSource::chords) {
  const auto shape = test::redCellShape();
  return grown(shape, std::int64_t(fraction * edge * edge * edge / shape->volume()), test::periodicCube(edge),
               planeSource);
}

void print(const GrownPacking& packing, const Options& options) {
  double seconds = 0.0, back = 0.0;
  GrowthStatistics sums;
  int certified = 0;
  std::int64_t cells = 0, states = 0;
  double fraction = 0.0;
  bool valid = true;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    PackingProblem problem = packing.problem();
    problem.physics.seed = std::uint64_t(seed);
    PackingResult result;
    seconds += timeOf([&] { result = pack(problem); });
    const GrowthStatistics& g = test::catStatistics(result).growth;
    certified += result.outcome == Outcome::certified;
    cells = std::int64_t(result.cells.size());
    fraction = result.certificate.cellVolume / problem.physics.container->volume();
    sums.iterations += g.iterations;
    sums.relaxationsKept += g.relaxationsKept;
    sums.planes += g.planes;
    sums.stepHalving.violatingPairs += g.stepHalving.violatingPairs;
    sums.stepHalving.misplaced += g.stepHalving.misplaced;
    back += g.stepHalvingSeconds;
    if (!options.check) continue;
    const std::int64_t seen = checkStates(problem);
    valid = valid && seen > 0;
    states += seen;
  }
  const double n = options.seeds;
  const auto mean = [n](std::int64_t sum) { return double(sum) / n; };
  fmt::print(
      "| {} | {} | {:.4f} | {:.0f} | {:.1f} | {:.0f} | {:.1f} | {:.1f} | {:.0f} | {:.3f} | {} | {}/{} "
      "|\n",
      packing.name, cells, fraction, mean(sums.iterations), mean(sums.relaxationsKept), mean(sums.planes),
      mean(sums.stepHalving.violatingPairs), mean(sums.stepHalving.misplaced),
      seconds > 0.0 ? 100.0 * back / seconds : 0.0, seconds / n,
      !options.check ? ""
      : valid        ? fmt::format("all {} valid", states)
                     : "NOT ALL VALID",
      certified, options.seeds);
  std::fflush(stdout);
}

/// A case that makes these packings and prints a line for each.
Case packings(std::string name, std::string about, std::vector<GrownPacking> of) {
  return {std::move(name), std::move(about), [of = std::move(of)](const Options& options) {
            std::puts(
                "| packing | cells | fraction | iterations | relaxations | planes | violating pairs | "
                "misplaced | "
                "step halving % | CPU s | states | certified |\n"
                "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- | --- |");
            for (const GrownPacking& packing : of) print(packing, options);
          }};
}

std::vector<GrownPacking> spheres(PlaneSource planeSource, const std::vector<int>& counts) {
  std::vector<GrownPacking> out;
  for (const int count : counts)
    out.push_back({fmt::format("sphere, {} red cells", count), [=] {
                     const auto shape = test::redCellShape();
                     return grown(shape, count, sphereFor(*shape, count, 0.30), planeSource);
                   }});
  return out;
}

std::vector<GrownPacking> boxes(PlaneSource planeSource, const std::vector<double>& fractions) {
  std::vector<GrownPacking> out;
  for (const double fraction : fractions)
    out.push_back({fmt::format("periodic box, {:.2f}", fraction),
                   [=] { return grownInBox(25.0, fraction, planeSource); }});
  return out;
}

/// One object in a copy of itself of which it fills 0.8.
PackingProblem inItself(const TriangleMesh& mesh) {
  TriangleMesh around = mesh;
  for (Vec3& v : around.vertices) v *= std::cbrt(1.0 / 0.8);
  return grown(std::make_shared<const Shape>(mesh), 1, makeVessel(std::move(around), {}, 0.2));
}

PackingProblem inSphere(const TriangleMesh& mesh, int count, double fraction) {
  const auto shape = std::make_shared<const Shape>(mesh);
  return grown(shape, count, sphereFor(*shape, count, fraction));
}

void packBox(double edge, double fraction, int threads, const Options& options) {
  double wall = 0.0, cpu = 0.0, tetrahedra = 0.0, faces = 0.0;
  std::int64_t cells = 0, iterations = 0, runs = 0, failures = 0, overlaps = 0;
  int certified = 0;
  for (int seed = 1; seed <= options.seeds; ++seed) {
    PackingProblem problem = grownInBox(edge, fraction, PlaneSource::catFaces);
    problem.physics.seed = std::uint64_t(seed);
    problem.execution.threads = Threads(threads);
    const Timer watch;
    const PackingResult result = pack(problem);
    wall += watch.wall();
    cpu += watch.cpu();
    certified += result.outcome == Outcome::certified;
    cells = std::int64_t(result.cells.size());
    iterations += result.statistics.engine->iterations();
    overlaps += test::catStatistics(result).growth.stepHalving.violatingPairs;
    runs += test::catStatistics(result).tetrahedra->runs;
    failures += test::catStatistics(result).tetrahedra->failures;
    tetrahedra += test::catStatistics(result).tetrahedra->tetrahedraSeconds;
    faces += test::catStatistics(result).tetrahedra->faceSeconds;
  }
  const double n = options.seeds;
  fmt::print(
      "| {:g}³, {:.2f} | {} | {} | {:.0f} | {:.0f} | {:.0f} | {:.0f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | "
      "{}/{} |\n",
      edge, fraction, cells, threads, double(iterations) / n, double(overlaps) / n, double(runs) / n,
      double(failures) / n, tetrahedra / n, faces / n, cpu / n, wall / n, certified, options.seeds);
  std::fflush(stdout);
}

void catFaces(const Options& options) {
  std::puts(
      "| periodic box | cells | threads | iterations | overlaps removed by step halving | "
      "tetrahedralisations | "
      "failed | tetrahedra CPU s | faces CPU s | all CPU s | wall s | certified |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |");
  packBox(25.0, 0.30, 1, options);
  packBox(25.0, 0.40, 1, options);
  for (const int threads : {1, 2}) packBox(43.3, 0.30, threads, options);
  for (const int threads : {1, 2}) packBox(64.7, 0.30, threads, options);
}

/// Does the bound on the rotation keep cells within their planes, or does the padding? Violating pairs and
/// stayed steps per 1000 steps, iterations, and how many runs came to an end, over the seeds.
std::string paddingFigures(double rotation, double padding) {
  constexpr int seeds = 3;
  double pairs = 0.0, stayed = 0.0, steps = 0.0, iterations = 0.0;
  int certified = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    PackingProblem problem = grownInBox(25.0, 0.40);
    problem.physics.seed = std::uint64_t(seed);
    GrowthSettings& growth = test::useCat(problem).growth;
    growth.rotationBound = rotation;
    growth.padding = padding;
    growth.relaxationSweeps = 0;
    growth.maxIterations = 150;
    const PackingResult result = pack(problem);
    const GrowthStatistics& g = test::catStatistics(result).growth;
    certified += result.outcome == Outcome::certified;
    pairs += double(g.stepHalving.violatingPairs);
    stayed += double(g.stepHalving.stayed);
    steps += double(g.stepHalving.steps);
    iterations += double(g.iterations);
  }
  return fmt::format("{:.1f} / {:.1f} / {:.0f}{}", 1e3 * pairs / steps, 1e3 * stayed / steps,
                     iterations / seeds,
                     certified == seeds ? "" : fmt::format(" ({} of {})", certified, seeds));
}

void paddingTable(const Options&) {
  const std::vector<double> paddings = {0.0, 0.02, 0.04, 0.08, 0.16};
  fmt::print("| θ_max [rad] \\ p |");
  for (const double padding : paddings) fmt::print(" {:.2f} |", padding);
  fmt::print("\n| --- |");
  for (std::size_t k = 0; k < paddings.size(); ++k) fmt::print(" ---: |");
  fmt::print("\n");
  for (const double rotation : {0.0125, 0.025, 0.05, 0.1, 0.2618}) {
    fmt::print("| {:.4f} |", rotation);
    for (const double padding : paddings) {
      fmt::print(" {} |", paddingFigures(rotation, padding));
      std::fflush(stdout);
    }
    fmt::print("\n");
  }
}

void escapeFrom(const Options& options) {
  fmt::print(
      "Spheres, cubes, cones, tori and sickles, half of the lumen if all were full size; three more of each "
      "and "
      "twenty small spheres in reserve. Coverage: volume of all bodies, as large as they are, over that of "
      "the "
      "lumen. Every state that growth or a phase accepts is certified by itself.\n\n"
      "| lumen | seed | phase | coverage | bodies | full size | tried | changed | CPU s | states |\n"
      "| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n");
  const std::pair<std::string, std::shared_ptr<const Container>> lumens[] = {
      {"sphere", makeSphere(Vec3::Zero(), 9.0)}, {"vase", test::vase()}};
  for (const auto& [name, lumen] : lumens)
    for (int seed = 1; seed <= options.seeds; ++seed) {
      PackingProblem problem = test::mixtureIn(lumen, 8);
      for (Species& species : problem.physics.species)
        species.count = std::llround(0.5 / 5.0 * lumen->volume() / problem.physics.shapeOf(species).volume());
      problem.physics.seed = std::uint64_t(seed);
      EscapeSettings& escape = test::useCat(problem).escape.emplace();
      escape.reserve.assign(problem.physics.species.size(), 3);
      problem.physics.add("small sphere", std::make_shared<const Shape>(test::icosphere(2, 0.8)), 0);
      escape.reserve.push_back(20);
      const PackingResult result = pack(problem);
      const std::int64_t states = checkStates(problem);
      double before = 0.0;
      for (const EscapePhase& p : test::catStatistics(result).escape) {
        fmt::print("| {} | {} | {} | {:.4f}{} | {} | {} | {} | {} | {:.2f} | {} |\n", name, seed, p.name,
                   p.coverage, p.coverage < before - 1e-12 ? " LOWER" : "", p.cells, p.full, p.tried,
                   p.changed, p.seconds,
                   &p != &test::catStatistics(result).escape.back() ? ""
                   : states < 0                                     ? "NOT ALL VALID"
                                                                    : fmt::format("all {} valid", states));
        before = p.coverage;
      }
      std::fflush(stdout);
    }
}

}  // namespace

std::vector<Case> packingCases() {
  return {
      packings("sphere-chords",
               "red cells in a sphere, coverage 0.30 (thesis figure 4.4), planes from chords",
               spheres(PlaneSource::chords, {5, 30, 128})),
      packings("sphere-cat-faces", "the same, planes from CAT faces, as in the thesis",
               spheres(PlaneSource::catFaces, {5, 30})),
      packings("box-chords", "red cells in a periodic box of 25 µm, planes from chords",
               boxes(PlaneSource::chords, {0.30, 0.40, 0.45, 0.50, 0.55})),
      packings("box-cat-faces", "the same, planes from CAT faces, as in the thesis",
               boxes(PlaneSource::catFaces, {0.30, 0.40})),
      packings("itself", "one object in a copy of itself of which it fills 0.8 (thesis figure 4.3)",
               {{"cube", [] { return inItself(test::cube(4.0)); }},
                {"sphere", [] { return inItself(test::icosphere(3, 2.5)); }},
                {"tetrahedron", [] { return inItself(test::tetrahedron()); }},
                {"cone", [] { return inItself(test::cone()); }}}),
      packings("any-mesh", "20 objects of any closed mesh in a sphere, coverage 0.20",
               {{"torus", [] { return inSphere(sample::torus(Vec3::Zero(), 3.0, 1.0, 40, 20), 20, 0.20); }},
                {"star", [] { return inSphere(test::star(), 20, 0.20); }},
                {"organic", [] { return inSphere(test::organic(), 20, 0.20); }}}),
      {"threads-cat-faces", "periodic boxes with planes from CAT faces, one thread and two", catFaces},
      {"padding",
       "violating pairs per 1000 steps / steps not taken per 1000 / iterations, by rotation bound and "
       "padding",
       paddingTable},
      {"escape", "coverage after swapping, enlargement, replacement and hole filling", escapeFrom},
  };
}

}  // namespace packmesh::benchmark
