// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certifier.h"
#include "packMesh/container/primitives.h"
#include "tests/support/catch.h"
#include "tests/support/deformed.h"
#include "tests/support/shapes.h"

using namespace packmesh;

namespace {

struct Course {
  std::int64_t pairs = 0;  ///< listed
  std::int64_t work = 0;   ///< pairs found, listed or forgotten
  int rounds = 0;
  bool more = false;
};

/// The course of a search in which each cell has so many pairs; of examples it has five at most.
Course courseOf(const std::vector<std::int64_t>& pairs, std::int64_t most) {
  Course course;
  OverlapSearch search(std::int64_t(pairs.size()), most);
  while (!search.over()) {
    std::int64_t found = 0;
    for (std::int64_t i = search.begin(); i < search.end(); ++i)
      found += search.more() ? std::min<std::int64_t>(pairs[i], 5) : pairs[i];
    found = std::min(found, search.room());
    course.work += found;
    ++course.rounds;
    if (search.finish(found)) course.pairs += found;
  }
  course.more = search.more();
  return course;
}

}  // namespace

TEST_CASE("A search below its limit lists all pairs in a few rounds", "[overlap_search]") {
  const std::vector<std::int64_t> pairs(1000, 3);
  const Course course = courseOf(pairs, 3001);
  CHECK(course.pairs == 3000);
  CHECK_FALSE(course.more);
  CHECK(course.rounds == 10);
  CHECK(courseOf({}, 10).rounds == 0);
}

TEST_CASE("A search at its limit ends soon, with some examples, wherever the pairs are", "[overlap_search]") {
  constexpr std::int64_t most = 100000;
  std::vector<std::int64_t> pairs(1 << 20, 0);
  const std::size_t size = pairs.size(), where = GENERATE(range(0, 5));
  for (std::size_t i = 0; i < size; ++i) {
    const bool in[] = {true, i + 1 == size, 2 * i >= size, i % 2 == 0, true};
    if (in[where]) pairs[i] = where == 0 ? std::int64_t(size) : where == 4 ? 1 : most;
  }
  const Course course = courseOf(pairs, most);
  CHECK(course.more);
  CHECK(course.pairs >= 5);
  CHECK(course.pairs < most);
  CHECK(course.work <= 2 * most + 1000);
  CHECK(course.rounds < 1000);
}

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

void requireSame(const Certificate& found, const Certificate& expected) {
  REQUIRE(found.cells == expected.cells);
  REQUIRE(found.pairsTested == expected.pairsTested);
  REQUIRE(found.cellVolume == expected.cellVolume);
  REQUIRE(found.minimumGap == expected.minimumGap);
  REQUIRE(found.minimumWallGap == expected.minimumWallGap);
  REQUIRE(std::equal(found.overlapping.begin(), found.overlapping.end(), expected.overlapping.begin(),
                     expected.overlapping.end(), [](const OverlappingPair& a, const OverlappingPair& b) {
                       return std::tie(a.first, a.second, a.contained, a.gap) ==
                                  std::tie(b.first, b.second, b.contained, b.gap) &&
                              a.shift == b.shift;
                     }));
  REQUIRE(std::equal(found.misplaced.begin(), found.misplaced.end(), expected.misplaced.begin(),
                     expected.misplaced.end(), [](const MisplacedCell& a, const MisplacedCell& b) {
                       return std::tie(a.cell, a.reason, a.gap) == std::tie(b.cell, b.reason, b.gap);
                     }));
}

/// Cells of three shapes in a container, some of which move now and then: anywhere, or, in a lattice of
/// balls, around their sites.
class Crowd {
 public:
  Crowd(unsigned seed, int count, std::shared_ptr<const Container> container, bool lattice = false)
      : random_(seed), container_(std::move(container)), lattice_(lattice) {
    for (const TriangleMesh& mesh :
         {test::redCell(2), test::icosphere(1, 1.0), sample::torus(Vec3::Zero(), 1.5, 0.3, 8, 6)})
      shapes_.push_back(std::make_unique<Shape>(mesh, ellipsoidProfile(3.9, 3.9, 3.9)));
    for (int i = 0; i < count; ++i) {
      const int shape = lattice_ ? 1 : int(random_() % shapes_.size());
      cells_.push_back({shape, shape, {}});
      place(i);
    }
  }

  CertificateInput input(double requiredGap, double requiredWallGap) const {
    CertificateInput in;
    for (const auto& shape : shapes_) in.shapes.push_back(shape.get());
    in.walls.assign(shapes_.size(), container_->wall());
    in.container = container_.get();
    in.cells = &cells_;
    in.requiredGap = requiredGap;
    in.requiredWallGap = requiredWallGap;
    return in;
  }

  static constexpr double spacing = 2.19;  ///< of the lattice [µm]

  /// Moves a random part of the cells, those of `faults` first: anywhere, or a little.
  std::vector<std::int64_t> move(const Certificate& faults) {
    std::vector<std::int64_t> moved;
    for (const OverlappingPair& p : faults.overlapping)
      if (random_() % 4) moved.push_back(random_() % 2 ? p.first : p.second);
    for (const MisplacedCell& m : faults.misplaced)
      if (random_() % 4) moved.push_back(m.cell);
    for (std::size_t more = random_() % 4; more > 0; --more) moved.push_back(random_() % cells_.size());
    for (const std::int64_t cell : moved) {
      if (random_() % 2)
        place(cell);
      else
        cells_[cell].placement.translation += 0.02 * test::randomDirection(random_);
    }
    return moved;  // with repetitions
  }

 private:
  void place(std::int64_t cell) {
    const Box box = container_->bounds();
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const Vec3 at(unit(random_), unit(random_), unit(random_));
    cells_[cell].placement = {test::randomRotation(random_), box.lo + at.cwiseProduct(box.size())};
    if (lattice_) {
      const Vec3 site(cell % sites, cell / sites % sites, cell / (sites * sites));
      constexpr double jitter = 0.1;
      cells_[cell].placement.translation = box.lo + spacing * site + jitter * (2.0 * at - Vec3::Ones());
    }
    for (int k = 0; k < 3; ++k)  // images are as good
      if (container_->period()[k] > 0.0)
        cells_[cell].placement.translation[k] += (int(random_() % 5) - 2) * container_->period()[k];
  }

  static constexpr int sites = 4;

  std::mt19937 random_;
  std::vector<std::unique_ptr<Shape>> shapes_;
  std::vector<PlacedCell> cells_;
  std::shared_ptr<const Container> container_;
  bool lattice_;
};

}  // namespace

TEST_CASE("An updated certificate equals, field by field, a new one", "[certificate]") {
  const auto box = [](const Vec3& size, std::array<bool, 3> periodic) -> std::shared_ptr<const Container> {
    return makeBox({Vec3(1, 2, 3), Vec3(1, 2, 3) + size}, periodic);
  };
  const std::vector<std::shared_ptr<const Container>> containers = {
      box({22, 20, 24}, {true, true, true}),
      box({7, 30, 9}, {true, false, true}),
      box({24, 24, 24}, {false, false, false}),
      makeCylinder({0, 0, 0}, 1, 9.0, 30.0, true),
      makeSphere({5, 5, 5}, 12.0),
      box(Vec3::Constant(4.0 * Crowd::spacing), {true, true, true})};
  int rounds = 0, clean = 0, overlaps = 0, tooNear = 0, ownImages = 0, rising = 0, notMeasured = 0,
      outside = 0, nearWall = 0;
  for (unsigned seed = 0; seed < 8; ++seed)
    for (std::size_t c = 0; c < containers.size(); ++c) {
      const bool lattice = c == 5;
      const double requiredGap = seed % 3 == 2 ? 0.1 : 0.0, requiredWallGap = seed % 2 ? 0.3 : 0.0;
      const double interest = seed % 4 == 3 ? 0.1 : 1.0;
      Crowd crowd(100 * seed + c, lattice ? 64 : seed < 4 ? 6 : 12, containers[c], lattice);
      CertificateInput input = crowd.input(requiredGap, requiredWallGap);
      input.largestGap = input.largestWallGap = interest;
      Certifier certifier(input);
      requireSame(certifier.certificate(), certify(input, interest));
      for (int round = 0; round < 20; ++round, ++rounds) {
        const double before = certifier.certificate().minimumGap;
        certifier.update(crowd.move(certifier.certificate()));
        const Certificate& now = certifier.certificate();
        requireSame(now, certify(input, interest));
        clean += now.clean();
        rising += before > 0.0 && now.minimumGap > before && now.minimumGap < unlimited;
        notMeasured += now.minimumGap == unlimited;
        for (const OverlappingPair& p : now.overlapping) {
          ++(p.gap > 0.0 ? tooNear : overlaps);
          ownImages += p.first == p.second;
        }
        for (const MisplacedCell& m : now.misplaced) ++(m.gap > 0.0 ? nearWall : outside);
      }
    }
  // All of it has come up.
  CAPTURE(clean, overlaps, tooNear, ownImages, rising, notMeasured, outside, nearWall);
  REQUIRE(rounds == 960);
  REQUIRE(clean > 100);
  REQUIRE(overlaps > 300);
  REQUIRE(tooNear > 30);
  REQUIRE(ownImages > 30);
  REQUIRE(rising > 15);
  REQUIRE(notMeasured > 20);
  REQUIRE(outside > 100);
  REQUIRE(nearWall > 20);
}

TEST_CASE("Cells not reported as changed are not examined again", "[certificate]") {
  const auto ball = std::make_shared<Shape>(test::icosphere(1, 1.0), ellipsoidProfile(1, 1, 1));
  std::vector<PlacedCell> cells;
  for (int i = 0; i < 5; ++i) cells.push_back({0, 0, {Mat3::Identity(), Vec3(3.0 * i, 0, 0)}});
  CertificateInput input;
  input.shapes = {ball.get()};
  input.cells = &cells;
  input.largestGap = 2.0;
  Certifier certifier(input);
  REQUIRE(certifier.certificate().clean());
  cells[0].placement.translation.x() = 2.5;  // meets cell 1, in secret
  cells[4].placement.translation.x() += 0.25;
  certifier.update({4});
  REQUIRE(certifier.certificate().clean());
  certifier.update({0});
  REQUIRE(certifier.certificate().overlapping.size() == 1);
  cells[0].placement.translation.x() = 0.0;
  certifier.update({0});
  REQUIRE(certifier.certificate().clean());
  certifier.update({});
  REQUIRE(certifier.certificate().clean());
  REQUIRE(certifier.certificate().minimumGap == certify(input, 2.0).minimumGap);
}

TEST_CASE("The smallest gap is found again when its pair separates", "[certificate]") {
  const auto cube = std::make_shared<Shape>(sample::box({-1, -1, -1}, {1, 1, 1}), ellipsoidProfile(1, 1, 1));
  std::vector<PlacedCell> cells;
  const double gaps[] = {0.25, 0.0625, 0.001953125, 0.5, 0.00390625};
  double x = 0.0;
  cells.push_back({0, 0, {Mat3::Identity(), Vec3::Zero()}});
  for (const double gap : gaps) {
    x += 2.0 + gap;
    cells.push_back({0, 0, {Mat3::Identity(), Vec3(x, 0, 0)}});
  }
  CertificateInput input;
  input.shapes = {cube.get()};
  input.cells = &cells;
  Certifier certifier(input);
  REQUIRE(certifier.certificate().minimumGap == 0.001953125);
  const auto part = [&](int after) {  // all cells after this one go aside
    std::vector<std::int64_t> moved;
    for (std::size_t i = after + 1; i < cells.size(); ++i) {
      cells[i].placement.translation.y() += 16.0;
      moved.push_back(std::int64_t(i));
    }
    certifier.update(moved);
    return certifier.certificate().minimumGap;
  };
  REQUIRE(part(2) == 0.00390625);
  REQUIRE(part(4) == 0.0625);
  REQUIRE(part(1) == 0.25);
  REQUIRE(part(0) == 0.5);
  REQUIRE(part(3) == unlimited);
}

TEST_CASE("After repair of a pair that was too close, the cells are examined once", "[certificate]") {
  const auto ball = std::make_shared<Shape>(test::icosphere(1, 1.0), ellipsoidProfile(1, 1, 1));
  const double required = 0.1, gap = required + 0.002;
  std::vector<PlacedCell> cells;
  for (const double x : {0.0, 2.0 + gap, 10.0, 12.0 + 0.5 * required, 20.0, 23.0})
    cells.push_back({0, 0, {Mat3::Identity(), Vec3(x, 0, 0)}});
  CertificateInput input;
  input.shapes = {ball.get()};
  input.cells = &cells;
  input.requiredGap = required;
  std::int64_t examined = 0;
  input.stop = [&] {
    ++examined;
    return false;
  };
  Certifier certifier(input);
  REQUIRE(certifier.certificate().overlapping.size() == 1);
  REQUIRE(certifier.certificate().minimumGap == Approx(0.5 * required));
  REQUIRE(examined == std::int64_t(cells.size()));

  examined = 0;
  cells[3].placement.translation.x() += required;
  certifier.update({3});
  REQUIRE(certifier.certificate().clean());
  REQUIRE(certifier.certificate().minimumGap == Approx(gap));
  REQUIRE(examined == 1);
}

TEST_CASE("A deformed cell that intersects itself is a fault of its own, wherever it is", "[certificate]") {
  const std::shared_ptr<const Shape> red = test::redCellShape();
  std::vector<Vec3> crossed = red->mesh().vertices;
  crossed[0] = -2.0 * crossed[0];  // through the cell
  const Shape plain(test::deformed(red->mesh(), 1), red), faulty(crossed, red);
  std::vector<PlacedCell> cells(3);
  for (int i = 0; i < 3; ++i)
    cells[i] = {0, i, Pose{1.0, Quaternion::Identity(), Vec3(20.0 * i, 0, 0)}.placement()};
  CertificateInput input;
  input.shapes = {red.get(), &plain, &faulty};
  input.cells = &cells;
  Certifier certifier(input);
  const auto requireFound = [&] {
    const Certificate& found = certifier.certificate();
    CHECK(found.overlapping.empty());
    CHECK_FALSE(found.clean());
    REQUIRE(found.selfIntersecting.size() == 1);
    CHECK(found.selfIntersecting[0].cell == 2);
    CHECK(found.selfIntersecting[0].first != found.selfIntersecting[0].second);
  };
  requireFound();
  cells[1].placement.translation.y() += 1.0;
  certifier.update({1});
  requireFound();
  cells[2].placement.translation.y() += 1.0;
  certifier.update({2});
  requireFound();
  const Certificate of = ofAllRanks(certifier.certificate(), {7, 8, 9}, Communicator());
  CHECK(of.selfIntersecting[0].cell == 9);
  cells[2].shape = 0;
  certifier.update({2});
  CHECK(certifier.certificate().clean());
}

TEST_CASE("Faults of thousands of deformed cells are found, and the least gap", "[certificate]") {
  const auto ball = std::make_shared<const Shape>(sample::box(Vec3::Constant(-1.0), Vec3::Ones()));
  const int count = 9000;
  std::vector<std::unique_ptr<Shape>> shapes;
  CertificateInput input;
  std::vector<PlacedCell> cells(count);
  for (int i = 0; i < count; ++i) {
    std::vector<Vec3> longer = ball->mesh().vertices;
    for (Vec3& v : longer) v.x() *= 1.1;
    shapes.push_back(std::make_unique<Shape>(std::move(longer), ball));
    input.shapes.push_back(shapes.back().get());
    cells[i] = {0, i, Pose{1.0, Quaternion::Identity(), Vec3(2.3 * i, 0, 0)}.placement()};
  }
  input.cells = &cells;
  const Certificate clean = certify(input);
  CHECK(clean.clean());
  CHECK(clean.minimumGap == Approx(0.1));
  std::vector<int> moved;
  for (int i = 5; i + 1 < count; i += 997) {
    cells[i].placement.translation.x() += 0.2;  // into the next one
    moved.push_back(i);
  }
  const Certificate found = certify(input);
  REQUIRE(found.overlapping.size() == moved.size());
  for (std::size_t k = 0; k < moved.size(); ++k) CHECK(found.overlapping[k].first == moved[k]);
}
