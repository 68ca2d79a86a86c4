// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/tetgen_planes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "packMesh/core/error.h"
#include "packMesh/core/timer.h"
#include "packMesh/growth/face_planes.h"
#include "packMesh/growth/levels_of_detail.h"
#include "packMesh/growth/tetrahedralise.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

/// Who faces whom is asked anew when a cell has moved so far [µm].
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

/// Two cells, or a cell and an image, that face each other.
struct Pair {
  int first, second;
  std::array<long, 3> image;
  auto key() const { return std::tie(first, second, image); }
  bool operator<(const Pair& o) const { return key() < o.key(); }
  bool operator==(const Pair& o) const { return key() == o.key(); }
};

/// @param members the cells that objects are
void addFacingPairs(const Tetrahedra& t, const std::vector<int>& members, const Vec3& period,
                    std::vector<Pair>& pairs) {
  for (const FacingPart& part : facingParts(t)) {
    const TetrahedraBody &from = t.bodies[part.from], &onto = t.bodies[part.onto];
    const Vec3 n = periodsBetween(from.shift, onto.shift, period);
    Pair pair{members[from.object],
              members[onto.object],
              {std::lround(n[0]), std::lround(n[1]), std::lround(n[2])}};
    const std::array<long, 3> back{-pair.image[0], -pair.image[1], -pair.image[2]};
    if (pair.first > pair.second || (pair.first == pair.second && pair.image < back)) {
      std::swap(pair.first, pair.second);
      pair.image = back;
    }
    pairs.push_back(pair);
  }
}

/// Each pair once.
std::vector<NearPair> nearPairs(std::vector<Pair> pairs, const Vec3& period) {
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

/// As it travels between ranks.
struct PlainPlane {
  double vertex[3], point[3], normal[3];
  std::int64_t cell;

  static PlainPlane of(const PlaneConstraint& plane, int cell) {
    PlainPlane plain{};
    Eigen::Map<Vec3>(plain.vertex) = plane.vertex;
    Eigen::Map<Vec3>(plain.point) = plane.point;
    Eigen::Map<Vec3>(plain.normal) = plane.normal;
    plain.cell = cell;
    return plain;
  }
  PlaneConstraint plane() const {
    return {Eigen::Map<const Vec3>(vertex), Eigen::Map<const Vec3>(point), Eigen::Map<const Vec3>(normal)};
  }
};

}  // namespace

TetgenPlanes::TetgenPlanes(const GrowthScene& scene, TetgenUse use, TetrahedraSums& sums, int failingAttempts,
                           int cellsOfRegion)
    : scene_(scene), use_(use), cellsOfRegion_(cellsOfRegion), chords_(scene), sums_(sums) {
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
    std::vector<Pair> pairs;
    bool known = true;
    for (const Region& region : ownRegions(state, request.shares)) {
      known = known && tetrahedraOf(state, region, 0.0, inset);
      if (known) addFacingPairs(tetrahedra_, members_, input_.period, pairs);
    }
    const Communicator& ranks = request.shares.communicator();
    known_ = !ranks.any(!known);
    pairs_ = known_ ? nearPairs(ranks.gatherAll(pairs), input_.period) : std::vector<NearPair>();
    madeFor_ = state;
  }
  return known_ ? chords_.between(state, request, pairsNow(state)) : chords_(state, request);
}

PlaneConstraints TetgenPlanes::faces(const GrowthState& state, const PlaneRequest& request) {
  const CellShares& shares = request.shares;
  std::vector<std::vector<PlainPlane>> to(shares.communicator().size());
  bool known = true;
  for (const Region& region : ownRegions(state, shares)) {
    known = known && tetrahedraOf(state, region, request.detail, 1.0);
    if (!known) break;
    const Timer watch(sums_.faceSeconds);
    splitChordally(tetrahedra_, WallFaces::atWall, split_);
    std::vector<double> reach;
    for (const int cell : members_) reach.push_back(request.reach[cell]);
    const PlaneConstraints planes = planesOfFaces(tetrahedra_, split_, input_.objects, sliverCosine, reach);
    for (std::size_t object = 0; object < planes.size(); ++object) {
      if (!input_.primary.empty() && !input_.primary[object]) continue;
      const int cell = members_[object];
      for (const PlaneConstraint& plane : planes[object])
        to[shares.owner(cell)].push_back(PlainPlane::of(plane, cell));
    }
  }
  if (shares.communicator().any(!known)) return chords_(state, request);
  PlaneConstraints planes = chords_.between(state, request, {});
  for (const std::vector<PlainPlane>& received : shares.communicator().exchange(to))
    for (const PlainPlane& plane : received) planes[plane.cell].push_back(plane.plane());
  return planes;
}

std::vector<TetgenPlanes::Region> TetgenPlanes::regionsOf(const GrowthState& state) const {
  std::vector<Vec3> centres;
  for (const GrowingCell& cell : state) centres.push_back(cell.pose.position);
  int regions = 1;  // as many as can be shared out evenly
  while (state.size() > static_cast<std::size_t>(regions) * cellsOfRegion_) regions *= 2;
  return bisected(centres, regions);
}

/// Those that this rank tetrahedralises.
std::vector<TetgenPlanes::Region> TetgenPlanes::ownRegions(const GrowthState& state,
                                                           const CellShares& shares) const {
  std::vector<Region> all = regionsOf(state), own;
  const int ranks = shares.communicator().size(), rank = shares.communicator().rank();
  const auto count = static_cast<int>(all.size());
  for (int r = 0; r < count; ++r)
    if (r * ranks / count == rank) own.push_back(std::move(all[r]));
  return own;
}

bool TetgenPlanes::outdated(const GrowthState& state, const PlaneRequest& request) const {
  if (request.anew || madeFor_.size() != state.size()) return true;
  for (std::size_t i = 0; i < state.size(); ++i) {
    const Vec3 &before = madeFor_[i].pose.position, &now = state[i].pose.position;
    const Vec3 moved = now - before - periodsBetween(before, now, input_.period).cwiseProduct(input_.period);
    if (moved.norm() > farthestMove) return true;
  }
  return false;
}

/// Takes the cells of a region and those of which an image is within the margin of it.
void TetgenPlanes::chooseMembers(const GrowthState& state, const Region& region) {
  members_.clear();
  input_.primary.clear();
  if (region.size() == state.size()) {
    members_ = region;
    return;
  }
  const Vec3& first = state[region.front()].pose.position;
  input_.region = Box{first, first};
  for (const int cell : region) input_.region.add(state[cell].pose.position);
  std::vector<bool> inRegion(state.size(), false);
  for (const int cell : region) inRegion[cell] = true;
  for (int cell = 0; cell < static_cast<int>(state.size()); ++cell) {
    const double reach =
        input_.margin + 2.0 * state[cell].pose.scale * scene_.shapes[state[cell].species]->radius();
    bool near = inRegion[cell];
    forEachImage(state[cell].pose.position, reach, input_.bounds, input_.period, [&](const ImageShift& n) {
      const Vec3 image = state[cell].pose.position + displacement(n, input_.period);
      near = near || input_.region.squaredDistance(image) < reach * reach;
    });
    if (!near) continue;
    members_.push_back(cell);
    input_.primary.push_back(inRegion[cell]);
  }
}

/// @return whether tetrahedra_ are those of the region; otherwise TetGen gave up
bool TetgenPlanes::tetrahedraOf(const GrowthState& state, const Region& region, double detail,
                                double shrunk) {
  const Timer watch(sums_.tetrahedraSeconds);
  tetrahedra_ = Tetrahedra();
  double largest = 0.0, scale = 0.0;
  for (const GrowingCell& cell : state) {
    scale = std::max(scale, cell.pose.scale);
    largest = std::max(largest, cell.pose.scale * scene_.shapes[cell.species]->radius());
  }
  if (!input_.period.isZero() || region.size() < state.size())
    input_.margin =
        largest + marginSpacings * std::cbrt(input_.bounds.volume() / static_cast<double>(state.size()));
  chooseMembers(state, region);
  if (members_.size() < 2 && input_.period.isZero()) return true;
  ++sums_.runs;
  const bool far = use_ == TetgenUse::facing && scale <= smallScale;
  input_.kind = far ? TetrahedraKind::delaunay : TetrahedraKind::constrained;
  int coarsest = 0;
  for (std::size_t s = 0; s < levels_.size(); ++s)
    coarsest = std::max(coarsest, chords_.levels(static_cast<int>(s)).indexOf(detail));
  for (int level = coarsest; level >= 0; --level) {
    // The cells themselves are known not to meet.
    input_.valid = level == 0;
    input_.objects.clear();
    for (const int member : members_) {
      const GrowingCell& cell = state[member];
      const auto& levels = levels_[cell.species];
      const int index = std::min(level, chords_.levels(cell.species).indexOf(detail));
      Placement placement = scene_.placement(cell.pose);
      if (level > 0) placement.linear *= shrunk;
      input_.objects.push_back({levels[index].get(), placement});
    }
    try {
      input_.stop = scene_.stop;
      tetrahedra_ = tetrahedralise(input_);
      sums_.attempts += tetrahedra_.attempts;
      return true;
    } catch (const TetrahedraError& error) {
      sums_.attempts += error.attempts();
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
