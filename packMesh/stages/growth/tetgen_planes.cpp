// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/growth/tetgen_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "packMesh/error.h"
#include "packMesh/stages/growth/face_planes.h"
#include "packMesh/stopwatch.h"

namespace packmesh {
namespace {

/// Who faces whom is asked anew after so many iterations, or when a cell has moved so far [µm].
constexpr int longestUse = 4;
constexpr double farthestMove = 2.0;

/// Coarse levels are shrunk to this for who faces whom: 42 vertices of a red cell span its dimples.
constexpr double inset = 0.85;

/// Images of cells take part up to this far outside the bounds, in mean spacings of cells and largest radii:
/// who is further away does not matter to growth.
constexpr double marginSpacings = 1.0;

/// While no cell is larger than this they are so far apart that plain Delaunay tetrahedra respect the
/// surfaces anyway.
constexpr double smallScale = 0.5;

/// Faces whose normal has less to do with the gap than this are those of slivers (see planesOfFaces()).
constexpr double sliverCosine = 0.3;

/// By how many periods each coordinate jumped on the way from one place to another nearby.
Vec3 periodsBetween(const Vec3& from, const Vec3& to, const Vec3& period) {
  Vec3 n = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0) n[k] = std::round((to[k] - from[k]) / period[k]);
  return n;
}

/// Each pair of cells, or of a cell and an image, once.
std::vector<NearPair> facingPairs(const Tetrahedra& t, const Vec3& period) {
  struct Pair {
    int first, second;
    std::array<long, 3> image;
    auto key() const { return std::tie(first, second, image); }
    bool operator<(const Pair& o) const { return key() < o.key(); }
    bool operator==(const Pair& o) const { return key() == o.key(); }
  };
  std::vector<Pair> pairs;
  for (const FacingPart& part : facingParts(t)) {
    const TetrahedraBody &from = t.bodies[part.from], &onto = t.bodies[part.onto];
    const Vec3 n = periodsBetween(from.shift, onto.shift, period);
    Pair pair{from.object, onto.object, {std::lround(n[0]), std::lround(n[1]), std::lround(n[2])}};
    const std::array<long, 3> back{-pair.image[0], -pair.image[1], -pair.image[2]};
    if (pair.first > pair.second || (pair.first == pair.second && pair.image < back)) {
      std::swap(pair.first, pair.second);
      pair.image = back;
    }
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<NearPair> out;
  for (const Pair& p : pairs)
    out.push_back({p.first, p.second,
                   period.cwiseProduct(Vec3(static_cast<double>(p.image[0]), static_cast<double>(p.image[1]),
                                            static_cast<double>(p.image[2]))),
                   0.0});
  return out;
}

}  // namespace

TetgenPlanes::TetgenPlanes(const GrowthScene& scene, TetgenUse use, TetrahedraSums& sums, int failingAttempts)
    : scene_(scene), use_(use), chords_(scene), sums_(sums) {
  for (std::size_t s = 0; s < scene.shapes.size(); ++s) {
    const LevelsOfDetail& levels = chords_.levels(static_cast<int>(s));
    levels_.emplace_back();
    for (int level = 0; level < levels.count(); ++level)
      levels_.back().push_back(std::make_unique<MeshHierarchy>(levels.mesh(level)));
  }
  input_.period = scene.container->period();
  input_.bounds = scene.container->bounds();
  input_.kept = TetrahedraKept::joining;
  input_.explain = false;
  input_.failingAttempts = failingAttempts;
}

PlaneConstraints TetgenPlanes::operator()(const GrowthState& state, const PlaneRequest& request) {
  return use_ == TetgenUse::facing ? facing(state, request) : faces(state, request);
}

PlaneConstraints TetgenPlanes::facing(const GrowthState& state, const PlaneRequest& request) {
  if (outdated(state, request)) {
    known_ = tetrahedraOf(state, 0.0, inset);
    pairs_ = known_ ? facingPairs(tetrahedra_, input_.period) : std::vector<NearPair>();
    madeFor_ = state;
    uses_ = 0;
  }
  ++uses_;
  return known_ ? chords_.between(state, request, pairsNow(state)) : chords_(state, request);
}

PlaneConstraints TetgenPlanes::faces(const GrowthState& state, const PlaneRequest& request) {
  if (!tetrahedraOf(state, request.detail, 1.0)) return chords_(state, request);
  PlaneConstraints planes = chords_.between(state, request, {});
  const Stopwatch watch(sums_.faceSeconds);
  splitChordally(tetrahedra_, WallFaces::atWall, split_);
  const PlaneConstraints between =
      planesOfFaces(tetrahedra_, split_, input_.objects, sliverCosine, request.reach);
  for (std::size_t i = 0; i < planes.size(); ++i)
    planes[i].insert(planes[i].end(), between[i].begin(), between[i].end());
  return planes;
}

bool TetgenPlanes::outdated(const GrowthState& state, const PlaneRequest& request) const {
  if (uses_ == 0 || uses_ >= longestUse || request.jumped || madeFor_.size() != state.size()) return true;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Vec3 &before = madeFor_[i].pose.position, &now = state[i].pose.position;
    const Vec3 moved = now - before - periodsBetween(before, now, input_.period).cwiseProduct(input_.period);
    if (moved.norm() > farthestMove) return true;
  }
  return false;
}

/// @return whether tetrahedra_ are those of the state; otherwise TetGen gave up
bool TetgenPlanes::tetrahedraOf(const GrowthState& state, double detail, double shrunk) {
  const Stopwatch watch(sums_.tetrahedraSeconds);
  tetrahedra_ = Tetrahedra();
  if (state.size() < 2 && input_.period.isZero()) return true;
  ++sums_.runs;
  double largest = 0.0, scale = 0.0;
  for (const GrowingCell& cell : state) {
    scale = std::max(scale, cell.pose.scale);
    largest = std::max(largest, cell.pose.scale * scene_.shapes[cell.species]->radius());
  }
  if (!input_.period.isZero())
    input_.margin =
        largest + marginSpacings * std::cbrt(input_.bounds.volume() / static_cast<double>(state.size()));
  const bool far = use_ == TetgenUse::facing && scale <= smallScale;
  input_.kind = far ? TetrahedraKind::delaunay : TetrahedraKind::constrained;
  int coarsest = 0;
  for (std::size_t s = 0; s < levels_.size(); ++s)
    coarsest = std::max(coarsest, chords_.levels(static_cast<int>(s)).indexOf(detail));
  for (int level = coarsest; level >= 0; --level) {
    // The cells themselves are known not to meet.
    input_.valid = level == 0;
    input_.objects.clear();
    for (const GrowingCell& cell : state) {
      const auto& levels = levels_[cell.species];
      const int index = std::min(level, chords_.levels(cell.species).indexOf(detail));
      Placement placement = scene_.placement(cell.pose);
      if (level > 0) placement.linear *= shrunk;
      input_.objects.push_back({levels[index].get(), placement});
    }
    try {
      tetrahedra_ = tetrahedralise(input_);
      sums_.attempts += tetrahedra_.attempts;
      return true;
    } catch (const TetrahedraError& error) {
      sums_.attempts += tetgenVariants;
      sums_.lastFailure = error.what();
      break;
    } catch (const InputError&) {  // coarse levels meet
      ++sums_.finer;
    }
  }
  ++sums_.failures;
  return false;
}

/// The pairs that face each other, for cells that have moved since, and may have been wrapped.
std::vector<NearPair> TetgenPlanes::pairsNow(const GrowthState& state) const {
  std::vector<Vec3> jumped;
  for (std::size_t i = 0; i < state.size(); ++i)
    jumped.push_back(periodsBetween(madeFor_[i].pose.position, state[i].pose.position, input_.period)
                         .cwiseProduct(input_.period));
  std::vector<NearPair> pairs = pairs_;
  for (NearPair& pair : pairs) pair.shift += jumped[pair.first] - jumped[pair.second];
  return pairs;
}

}  // namespace packmesh
