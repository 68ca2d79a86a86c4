// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/escape.h"
#include "packMesh/cat/cat_face_planes.h"
#include "packMesh/cat/rooms.h"
#include "packMesh/certificate/certifier.h"
#include "tests/packMesh/cat/escape_scene.h"
#include "tests/support/catch.h"
#include "tests/support/growing.h"

using namespace packmesh;

namespace {

double sumOf(const std::vector<std::vector<double>>& scores, const std::vector<int>& columns) {
  double sum = 0.0;
  for (std::size_t r = 0; r < columns.size(); ++r) sum += scores[r][columns[r]];
  return sum;
}

double bestByTrying(const std::vector<std::vector<double>>& scores) {
  std::vector<int> columns(scores.size());
  std::iota(columns.begin(), columns.end(), 0);
  double best = sumOf(scores, columns);
  while (std::next_permutation(columns.begin(), columns.end())) best = std::max(best, sumOf(scores, columns));
  return best;
}

}  // namespace

TEST_CASE("The best assignment is the best of all permutations") {
  std::mt19937 random(5);
  for (int n = 1; n <= 7; ++n) {
    for (int trial = 0; trial < 40; ++trial) {
      // Few different values, so that there are ties.
      std::uniform_int_distribution<int> few(-3, 3);
      std::uniform_real_distribution<double> many(-5.0, 5.0);
      std::vector<std::vector<double>> scores(n, std::vector<double>(n));
      for (auto& row : scores)
        for (double& s : row) s = trial % 2 == 0 ? few(random) : many(random);
      const std::vector<int> columns = bestAssignment(scores);
      REQUIRE(columns.size() == scores.size());
      std::vector<int> sorted = columns;
      std::sort(sorted.begin(), sorted.end());
      for (int c = 0; c < n; ++c) REQUIRE(sorted[c] == c);
      REQUIRE(sumOf(scores, columns) == Approx(bestByTrying(scores)).margin(1e-9));
    }
  }
}

TEST_CASE("The assignment of an empty matrix is empty") {
  CHECK(bestAssignment({}).empty());
}

namespace {

/// Bodies in a lumen.
struct EscapeScene {
  std::shared_ptr<const Container> lumen;
  Physics physics;
  Execution execution;
  std::vector<Body> state;
  TetrahedraSums tetrahedra;

  EscapeScene(const std::vector<std::shared_ptr<const Shape>>& of, std::shared_ptr<const Container> in)
      : lumen(std::move(in)), physics(test::physicsOf(of, lumen)) {}
  void add(int species, double scale, const Vec3& at) {
    state.push_back(
        makeBody(std::int64_t(state.size()), species, species, Pose{scale, Quaternion::Identity(), at}));
  }
  std::vector<EscapePhase> operator()(const EscapeSettings& settings) {
    const PlaneFunctionFactory factory = [this] {
      return makePlaneFunction(PlaneSource::chords, physics, execution, tetrahedra);
    };
    phases = escape(
        physics, execution, GrowthSettings(), settings, factory, {},
        [this](const std::vector<Body>& now) { CHECK(test::examine(physics, now).clean()); }, state);
    for (std::size_t k = 1; k < phases.size(); ++k)
      CHECK(phases[k].coverage >= phases[k - 1].coverage - 1e-12);
    return phases;
  }
  const EscapePhase& phase(const std::string& name) const {
    for (const EscapePhase& p : phases)
      if (p.name == name) return p;
    throw std::out_of_range(name);
  }
  std::vector<EscapePhase> phases;
};

std::shared_ptr<const Container> twoRooms() {
  // A tube with a wide and a narrow end, closed.
  return makeVessel(sample::tube(
                        0.0, 20.0, 41, 40, [](double x) { return Vec3(x, 0.0, 0.0); },
                        [](double x) { return x < 8.0    ? 3.2
                                              : x > 10.0 ? 1.6
                                                         : 3.2 - 0.8 * (x - 8.0); }),
                    {}, 0.2);
}

}  // namespace

TEST_CASE("Swapping moves the large body to the large room") {
  EscapeScene s({test::sphereShape(2.8), test::sphereShape(1.2)}, twoRooms());
  s.add(0, 0.5, Vec3(16.0, 0.0, 0.0));
  s.add(1, 1.0, Vec3(4.0, 0.0, 0.0));
  s(EscapeSettings());
  CHECK(s.phase("swapping").changed == 2);
  CHECK(s.state[0].species == 1);
  CHECK(s.state[1].species == 0);
  CHECK(s.phases.back().full == 2);
}

TEST_CASE("Enlargement grows a body into the room between its neighbours") {
  EscapeScene s({test::sphereShape(2.0)}, makeSphere(Vec3::Zero(), 6.0));
  s.add(0, 1.0, Vec3(-3.5, 0.0, 0.0));
  s.add(0, 0.4, Vec3(2.0, 0.0, 0.0));
  s(EscapeSettings());
  CHECK(s.phase("enlargement").changed == 1);
  CHECK(s.phase("enlargement").full == 2);
}

TEST_CASE("Replacement substitutes a body from the reserve for one that does not fit") {
  EscapeScene s({test::sphereShape(4.0), std::make_shared<const Shape>(test::cube(3.2))},
                makeSphere(Vec3::Zero(), 3.0));
  // The sphere reaches 0.75 of its size; the cube full size, but that is less volume.
  s.add(1, 0.5, Vec3::Zero());
  s.state[0].species = s.state[0].shape = 1;
  EscapeSettings settings;
  settings.reserve = {1, 0};
  s(settings);
  CHECK(s.state.size() == 1);
  // Enlargement made the cube full; nothing that is full is replaced.
  CHECK(s.state[0].species == 1);
  CHECK(s.state[0].scale == 1.0);

  EscapeScene t({test::sphereShape(2.5), std::make_shared<const Shape>(test::cube(4.0))},
                makeSphere(Vec3::Zero(), 3.0));
  t.add(1, 0.4, Vec3::Zero());
  settings.reserve = {1, 0};
  t(settings);
  CHECK(t.phase("replacement").changed == 1);
  CHECK(t.state[0].species == 0);
  CHECK(t.state[0].scale == 1.0);
}

TEST_CASE("Holes are empty, disjoint and sorted by size") {
  EscapeScene s({test::sphereShape(1.0)},
                makeBox(Box{Vec3::Zero(), Vec3::Constant(8.0)}, {false, false, false}));
  for (const double x : {1.5, 6.5})
    for (const double y : {1.5, 6.5})
      for (const double z : {1.5, 6.5}) s.add(0, 1.0, Vec3(x, y, z));
  const std::vector<Sphere> holes = Holes(s.physics, s.execution).in(s.lumen->bounds(), s.state, 0.5);
  REQUIRE(!holes.empty());
  // The middle is the largest one.
  CHECK((holes[0].center - Vec3::Constant(4.0)).norm() < 0.05);
  CHECK(holes[0].radius == Approx(2.5 * std::sqrt(3.0) - 1.0).epsilon(0.03));
  for (std::size_t i = 0; i < holes.size(); ++i) {
    for (const Body& cell : s.state)
      CHECK((holes[i].center - cell.position).norm() >= holes[i].radius + 0.98);
    CHECK(s.lumen->wall()->distance(holes[i].center).distance >= holes[i].radius - 1e-9);
    for (std::size_t j = 0; j < i; ++j) {
      CHECK(holes[i].radius <= holes[j].radius);
      CHECK((holes[i].center - holes[j].center).norm() >= holes[i].radius + holes[j].radius);
    }
  }
}

TEST_CASE("Hole filling accepts full-size bodies until the reserve is used up", "[long]") {
  EscapeScene s({test::sphereShape(1.0), test::sphereShape(2.0), test::sphereShape(20.0)},
                makeBox(Box{Vec3::Zero(), Vec3::Constant(8.0)}, {true, true, true}));
  for (const double x : {2.0, 6.0})
    for (const double y : {2.0, 6.0})
      for (const double z : {2.0, 6.0}) s.add(0, 1.0, Vec3(x, y, z));
  EscapeSettings settings;
  settings.reserve = {1, 1, 5};
  s(settings);
  CHECK(s.phase("hole filling").changed == 2);
  REQUIRE(s.state.size() == 10);
  CHECK(s.state[8].species == 1);
  CHECK(s.state[9].species == 0);
}

TEST_CASE("Parts of the container have the holes that the whole has there", "[long]") {
  test::LongBox box;
  const Holes holes(box.physics, box.execution);
  const Box bounds = box.physics.container->bounds();
  const auto apart = [&](Vec3 between) {
    for (int k = 0; k < 3; ++k) between[k] -= bounds.hi[k] * std::round(between[k] / bounds.hi[k]);
    return between.norm();
  };
  std::vector<Sphere> ofParts;
  for (int part = 0; part < 4; ++part) {
    Box region = bounds;
    if (part > 0) region.lo[0] = 0.25 * part * bounds.hi[0];
    if (part < 3) region.hi[0] = 0.25 * (part + 1) * bounds.hi[0];
    for (const Sphere& hole : holes.in(region, box.state, 0.4)) {
      ofParts.push_back(hole);
      CHECK(region.contains(hole.center));
      for (const Body& cell : box.state)
        CHECK(apart(hole.center - cell.position) >=
              hole.radius + 0.97 * cell.scale * box.physics.shapeOf(cell).radius());
    }
  }
  const std::vector<Sphere> all = holes.in(bounds, box.state, 0.4);
  REQUIRE(!all.empty());
  const double largest = box.physics.shapes[2]->radius();  // holes of parts are not larger
  for (const Sphere& hole : all)
    CHECK(std::any_of(ofParts.begin(), ofParts.end(), [&](const Sphere& other) {
      return apart(hole.center - other.center) < hole.radius + other.radius &&
             other.radius >= 0.99 * std::min(hole.radius, largest);
    }));
}

TEST_CASE("Escapes in several blocks gain coverage in every phase and share the reserve", "[long]") {
  test::LongBox box;
  const std::size_t before = box.state.size();
  std::vector<Body> state = box.state;
  const std::vector<EscapePhase> phases = box.escapeFrom(
      state, [&](const std::vector<Body>& now) { CHECK(test::examine(box.physics, now).clean()); });
  REQUIRE(phases.size() == 6);
  for (std::size_t k = 1; k < phases.size(); ++k) {
    INFO(phases[k].name);
    CHECK(phases[k].coverage >= phases[k - 1].coverage);
    CHECK(phases[k].tried > 0);
  }
  CHECK(phases[1].changed > 0);
  CHECK(phases[2].changed > 0);
  CHECK(phases[5].changed > 0);
  CHECK(phases[5].full > phases[0].full);
  // No more than the reserve has, and all cells are numbered without gaps.
  std::vector<std::int64_t> counts(3, 0);
  for (std::size_t i = 0; i < state.size(); ++i) {
    CHECK(state[i].id == std::int64_t(i));
    ++counts[state[i].species];
  }
  for (const Body& cell : box.state) --counts[cell.species];
  CHECK(state.size() > before + 6);
  CHECK(counts[0] <= 6);
  CHECK(counts[1] <= 3);
  CHECK(counts[2] <= 0);
}

TEST_CASE("No phase of an escape of a mixture in a vase lowers the coverage, and all states are valid") {
  PackingProblem problem = test::mixtureIn(test::vase(), 9);
  CatSettings& cat = test::useCat(problem);
  cat.growth.maxIterations = 20;
  cat.growth.giveUpAfter = 1;
  cat.escape.emplace();
  cat.escape->orientations = 1;
  cat.escape->swapRounds = 1;
  cat.escape->groupSize = 6;
  cat.escape->holes = 4;
  cat.escape->reserve = {1, 1, 1, 1, 1};
  problem.execution.observe = [&](const std::vector<PlacedCell>& cells) {
    REQUIRE(certify(certificateInputOf(problem.physics, cells), 1e-3).clean());
  };
  const PackingResult result = pack(problem);
  const std::vector<EscapePhase>& phases = test::catStatistics(result).escape;
  REQUIRE(phases.size() == 6);
  for (std::size_t k = 1; k < phases.size(); ++k) CHECK(phases[k].coverage >= phases[k - 1].coverage - 1e-12);
  CHECK(phases.back().coverage > phases.front().coverage);
  CHECK(result.certificate.clean());
  for (std::size_t i = 1; i < result.cells.size(); ++i)
    CHECK(result.cells[i - 1].species <= result.cells[i].species);
}
