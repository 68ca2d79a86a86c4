// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/chordal_split.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "packMesh/cat/tetrahedralise.h"
#include "tests/packMesh/cat/cat_scenes.h"
#include "tests/packMesh/cat/convex_clip.h"

using namespace packmesh;
using namespace packmesh::test;

namespace {

/// One tetrahedron of positive volume with given labels.
Tetrahedra single(const std::array<Vec3, 4>& points, const std::array<int, 4>& labels) {
  Tetrahedra t;
  t.points.assign(points.begin(), points.end());
  t.labels.assign(labels.begin(), labels.end());
  t.vertices = {0, 1, 2, 3};
  t.tetrahedra = {{0, 1, 2, 3}};
  if (volumeOf(t, 0) < 0.0) std::swap(t.tetrahedra[0][0], t.tetrahedra[0][1]);
  for (int b = 0; b < 4; ++b) t.bodies.push_back({b, Vec3::Zero(), true, 0});
  return t;
}

std::array<Vec3, 4> cornersOf(const Tetrahedra& t, int index) {
  return {t.corner(index, 0), t.corner(index, 1), t.corner(index, 2), t.corner(index, 3)};
}

/// -1 for the corners on a face's second side, 1 for those on its first, 0 for others; times the face's
/// normal points away from the corner.
int signOf(const ChordalFace& face, int k) {
  return (face.first >> k & 1) - (face.second >> k & 1);
}

/// Whether x is behind all faces of a single tetrahedron that constrain its corner k.
bool isBehind(const ChordalFaces& split, int k, const Vec3& x) {
  return std::all_of(split.faces.begin(), split.faces.end(), [&](const ChordalFace& face) {
    return signOf(face, k) * face.normal.dot(x - face.point) <= 0.0;
  });
}

/// The segment of a corner: the tetrahedron behind all planes that the corner has to stay behind.
ConvexBody segment(const Tetrahedra& t, const ChordalFaces& split, int tetrahedron, int k) {
  ConvexBody body = ConvexBody::tetrahedron(cornersOf(t, tetrahedron));
  Vec3 last = Vec3::Constant(std::nan(""));
  auto face = std::lower_bound(split.faces.begin(), split.faces.end(), tetrahedron,
                               [](const ChordalFace& f, int index) { return f.tetrahedron < index; });
  for (; face != split.faces.end() && face->tetrahedron == tetrahedron; ++face) {
    if (signOf(*face, k) == 0 || face->point == last) continue;  // pairs have a common plane
    body.cut(face->point, signOf(*face, k) * face->normal);
    last = face->point;
  }
  return body;
}

/// Volumes of all segments, by label; those of the container are left out where its planes are at the wall.
std::map<int, double> segmentVolumes(const Tetrahedra& t, const ChordalFaces& split, int index) {
  std::map<int, double> volumes;
  for (int k = 0; k < 4; ++k) {
    const int label = t.labels[t.tetrahedra[index][k]];
    if (!volumes.count(label)) volumes[label] = segment(t, split, index, k).volume();
  }
  return volumes;
}

std::array<Vec3, 4> randomCorners(std::mt19937& random, int kind) {
  std::normal_distribution<double> normal;
  std::array<Vec3, 4> corners;
  for (Vec3& p : corners) p = Vec3(normal(random), normal(random), normal(random));
  if (kind == 1) corners[3] = (corners[0] + corners[1] + corners[2]) / 3.0 + 1e-4 * corners[3];  // a sliver
  if (kind == 2)
    for (Vec3& p : corners) p = 1e-3 * p + Vec3(20.0, -30.0, 40.0);
  if (kind == 3) corners[1] = corners[0] + 1e-3 * corners[1];  // a short edge
  return corners;
}

/// All ways to label four corners.
std::vector<std::array<int, 4>> allLabels(int lowest) {
  std::vector<std::array<int, 4>> all;
  for (int code = 0; code < 256; ++code)
    all.push_back(
        {lowest + (code & 3), lowest + (code >> 2 & 3), lowest + (code >> 4 & 3), lowest + (code >> 6)});
  return all;
}

/// How often the labels occur, most frequent first.
std::vector<int> countsOf(const std::array<int, 4>& labels) {
  std::map<int, int> count;
  for (const int label : labels) ++count[label];
  std::vector<int> sorted;
  for (const auto& entry : count) sorted.push_back(entry.second);
  std::sort(sorted.rbegin(), sorted.rend());
  return sorted;
}

}  // namespace

TEST_CASE("The four cases have 1, 1, 3 and 12 faces", "[cat]") {
  const std::map<std::vector<int>, std::pair<ChordalCase, int>> table = {
      {{4}, {ChordalCase::none, 0}},
      {{3, 1}, {ChordalCase::threeOne, 1}},
      {{2, 2}, {ChordalCase::twoTwo, 1}},
      {{2, 1, 1}, {ChordalCase::twoOneOne, 3}},
      {{1, 1, 1, 1}, {ChordalCase::allDifferent, 12}}};
  std::mt19937 random(1);
  std::map<ChordalCase, int> seen;
  for (const std::array<int, 4>& labels : allLabels(wallLabel)) {
    const auto [kind, faces] = table.at(countsOf(labels));
    ++seen[kind];
    const ChordalPattern& pattern = chordalPattern(labels[0], labels[1], labels[2], labels[3]);
    CHECK(pattern.kind == kind);
    std::array<std::uint8_t, 4> order = pattern.order;
    std::sort(order.begin(), order.end());
    CHECK(order == std::array<std::uint8_t, 4>{0, 1, 2, 3});
    const Tetrahedra t = single(randomCorners(random, 0), labels);
    ChordalFaces split;
    splitChordally(t, WallFaces::midGap, split);
    CHECK(static_cast<int>(split.faces.size()) == faces);
    CHECK(split.tetrahedra[static_cast<int>(kind)] == (faces > 0));
    // Every face has corners on both of its sides, all corners of one label on the same.
    for (const ChordalFace& face : split.faces) {
      CHECK(face.tetrahedron == 0);
      CHECK(face.first != 0);
      CHECK(face.second != 0);
      CHECK((face.first & face.second) == 0);
      for (int k = 0; k < 4; ++k)
        for (int j = 0; j < k; ++j)
          if (labels[t.tetrahedra[0][j]] == labels[t.tetrahedra[0][k]])
            CHECK(signOf(face, j) == signOf(face, k));
    }
  }
  CHECK(seen[ChordalCase::threeOne] == 48);
  CHECK(seen[ChordalCase::twoTwo] == 36);
  CHECK(seen[ChordalCase::twoOneOne] == 144);
  CHECK(seen[ChordalCase::allDifferent] == 24);
}

TEST_CASE("Faces separate the corners on their sides", "[cat]") {
  std::mt19937 random(2);
  for (int kind = 0; kind < 4; ++kind)
    for (const std::array<int, 4>& labels : allLabels(0)) {
      const Tetrahedra t = single(randomCorners(random, kind), labels);
      ChordalFaces split;
      splitChordally(t, WallFaces::midGap, split);
      for (const ChordalFace& face : split.faces) {
        CHECK(face.normal.norm() == Approx(1.0).epsilon(1e-12));
        for (int k = 0; k < 4; ++k) {
          if (face.first >> k & 1) CHECK(face.normal.dot(t.corner(0, k) - face.point) < 0.0);
          if (face.second >> k & 1) CHECK(face.normal.dot(t.corner(0, k) - face.point) > 0.0);
        }
      }
    }
}

TEST_CASE("Segments of a tetrahedron have its total volume", "[cat]") {
  // Shares of the segments, from the definition: integrals over barycentric coordinates.
  const std::map<std::vector<int>, std::map<int, double>> shares = {
      {{3, 1}, {{3, 7.0 / 8.0}, {1, 1.0 / 8.0}}},
      {{2, 2}, {{2, 0.5}}},
      {{2, 1, 1}, {{2, 11.0 / 18.0}, {1, 7.0 / 36.0}}},
      {{1, 1, 1, 1}, {{1, 0.25}}}};
  std::mt19937 random(3);
  for (int kind = 0; kind < 4; ++kind)
    for (const std::array<int, 4>& labels : allLabels(0)) {
      const std::vector<int> counts = countsOf(labels);
      if (counts.size() == 1) continue;
      const Tetrahedra t = single(randomCorners(random, kind), labels);
      ChordalFaces split;
      splitChordally(t, WallFaces::midGap, split);
      const double tolerance =
          kind == 0 ? 1e-12 : 1e-8;  // others lose digits, as all flat and distant bodies do
      double sum = 0.0;
      for (const auto& [label, volume] : segmentVolumes(t, split, 0)) {
        const int corners = static_cast<int>(std::count(labels.begin(), labels.end(), label));
        CHECK(volume == Approx(shares.at(counts).at(corners) * volumeOf(t, 0)).epsilon(tolerance));
        sum += volume;
      }
      CHECK(sum == Approx(volumeOf(t, 0)).epsilon(tolerance));
    }
}

TEST_CASE("A point is in the segment of the surface with the largest sum of weights", "[cat]") {
  std::mt19937 random(4);
  std::exponential_distribution<double> exponential;
  for (const std::array<int, 4>& labels : allLabels(0)) {
    const Tetrahedra t = single(randomCorners(random, 0), labels);
    ChordalFaces split;
    splitChordally(t, WallFaces::midGap, split);
    for (int sample = 0; sample < 20; ++sample) {
      std::array<double, 4> weight;
      double total = 0.0;
      for (double& w : weight) total += w = exponential(random);
      Vec3 x = Vec3::Zero();
      std::map<int, double> sum;
      for (int k = 0; k < 4; ++k) {
        x += weight[k] / total * t.corner(0, k);
        sum[t.labels[t.tetrahedra[0][k]]] += weight[k] / total;
      }
      const auto heaviest = std::max_element(
          sum.begin(), sum.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
      for (int k = 0; k < 4; ++k)
        CHECK(isBehind(split, k, x) == (t.labels[t.tetrahedra[0][k]] == heaviest->first));
    }
  }
}

TEST_CASE("At the wall the whole gap belongs to the objects", "[cat]") {
  std::mt19937 random(5);
  for (const std::array<int, 4>& labels : allLabels(wallLabel)) {
    if (countsOf(labels).size() == 1) continue;
    const Tetrahedra t = single(randomCorners(random, 0), labels);
    ChordalFaces split;
    splitChordally(t, WallFaces::atWall, split);
    double sum = 0.0;
    for (const auto& [label, volume] : segmentVolumes(t, split, 0))
      if (label != wallLabel) sum += volume;
    CHECK(sum == Approx(volumeOf(t, 0)).epsilon(1e-12));
    for (const ChordalFace& face : split.faces)
      for (int k = 0; k < 4; ++k) {
        const bool wall = t.labels[t.tetrahedra[0][k]] == wallLabel;
        const double height = face.normal.dot(t.corner(0, k) - face.point);
        if (face.first >> k & 1) CHECK(height < (wall ? 1e-12 : 0.0));
        if (face.second >> k & 1) CHECK(height > (wall ? -1e-12 : 0.0));
      }
  }
}

TEST_CASE("Segments fill the free space of real tetrahedra", "[cat]") {
  for (const CatScene& scene : {fourCubes(), spheresAndCubes(), mixture(), redCellsInSphere(6, 0.45)}) {
    const Tetrahedra t = tetrahedralise(scene.input);
    for (const WallFaces wall : {WallFaces::atWall, WallFaces::midGap}) {
      ChordalFaces split;
      splitChordally(t, wall, split);
      double sum = 0.0;
      for (std::size_t i = 0; i < t.tetrahedra.size(); ++i) {
        const int n = static_cast<int>(i);
        const std::map<int, double> volumes = segmentVolumes(t, split, n);
        double own = 0.0;
        for (const auto& [label, volume] : volumes)
          if (wall == WallFaces::midGap || label != wallLabel || volumes.size() == 1) own += volume;
        CHECK(own == Approx(volumeOf(t, n)).epsilon(1e-6).margin(1e-9));
        sum += own;
      }
      CHECK(sum == Approx(scene.containerVolume() - scene.objectVolume()).epsilon(1e-9));
    }
  }
}

TEST_CASE("Splitting again leaves no trace of the first result", "[cat]") {
  const Tetrahedra large = tetrahedralise(spheresAndCubes().input), small = tetrahedralise(fourCubes().input);
  ChordalFaces fresh, used;
  splitChordally(small, WallFaces::atWall, fresh);
  splitChordally(large, WallFaces::midGap, used);
  splitChordally(small, WallFaces::atWall, used);
  REQUIRE(fresh.faces.size() == used.faces.size());
  CHECK(fresh.tetrahedra == used.tetrahedra);
  for (std::size_t f = 0; f < fresh.faces.size(); ++f) {
    CHECK(fresh.faces[f].point == used.faces[f].point);
    CHECK(fresh.faces[f].normal == used.faces[f].normal);
    CHECK(fresh.faces[f].tetrahedron == used.faces[f].tetrahedron);
    CHECK(fresh.faces[f].first == used.faces[f].first);
    CHECK(fresh.faces[f].second == used.faces[f].second);
  }
}

TEST_CASE("Segments of adjacent tetrahedra match on their common triangle", "[cat]") {
  std::mt19937 random(6);
  std::exponential_distribution<double> exponential;
  // The surface whose segment holds a point, from the planes of one tetrahedron.
  const auto surfaceAt = [](const Tetrahedra& t, const ChordalFaces& split, const Vec3& x) {
    std::set<int> found;
    for (int k = 0; k < 4; ++k)
      if (isBehind(split, k, x)) found.insert(t.labels[t.tetrahedra[0][k]]);
    return found;
  };
  for (int trial = 0; trial < 2000; ++trial) {
    std::array<Vec3, 4> corners = randomCorners(random, 0);
    std::uniform_int_distribution<int> anyLabel(0, 3);
    std::array<int, 4> labels{anyLabel(random), anyLabel(random), anyLabel(random), anyLabel(random)};
    const Tetrahedra one = single(corners, labels);
    corners[3] = randomCorners(random, 0)[3];
    labels[3] = anyLabel(random);
    const Tetrahedra other = single(corners, labels);
    ChordalFaces oneSplit, otherSplit;
    splitChordally(one, WallFaces::midGap, oneSplit);
    splitChordally(other, WallFaces::midGap, otherSplit);
    for (int sample = 0; sample < 10; ++sample) {
      double weight[3], total = 0.0;
      for (double& w : weight) total += w = exponential(random);
      const Vec3 x = (weight[0] * corners[0] + weight[1] * corners[1] + weight[2] * corners[2]) / total;
      const std::set<int> here = surfaceAt(one, oneSplit, x);
      REQUIRE(here.size() == 1);
      CHECK(here == surfaceAt(other, otherSplit, x));
    }
  }
}
