// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/cat_face_planes.h"

#include <algorithm>
#include <cmath>

#include "packMesh/core/error.h"
#include "packMesh/core/timer.h"
#include "packMesh/growth/face_planes.h"
#include "packMesh/growth/levels_of_detail.h"
#include "packMesh/growth/tetrahedralise.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh {
namespace {

/// Images of cells take part up to this far outside the bounds, in mean spacings of cells and largest radii:
/// who is further away does not matter to growth.
constexpr double marginSpacings = 1.0;

/// Faces whose normal has less to do with the gap than this are those of slivers (see planesOfFaces()).
constexpr double sliverCosine = 0.3;

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

CatFacePlanes::CatFacePlanes(const GrowthScene& scene, TetrahedraSums& sums, int failingAttempts,
                             int cellsOfRegion)
    : scene_(scene), cellsOfRegion_(cellsOfRegion), chords_(scene), sums_(sums) {
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

PlaneConstraints CatFacePlanes::operator()(const GrowthState& state, const PlaneRequest& request) {
  const CellShares& shares = request.shares;
  std::vector<std::vector<PlainPlane>> to(shares.communicator().size());
  bool known = true;
  for (const Region& region : ownRegions(state, shares)) {
    known = known && tetrahedraOf(state, region, request.detail);
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
  PlaneConstraints planes = chords_.atWalls(state, request);
  for (const std::vector<PlainPlane>& received : shares.communicator().exchange(to))
    for (const PlainPlane& plane : received) planes[plane.cell].push_back(plane.plane());
  return planes;
}

std::vector<CatFacePlanes::Region> CatFacePlanes::regionsOf(const GrowthState& state) const {
  std::vector<Vec3> centres;
  for (const GrowingCell& cell : state) centres.push_back(cell.pose.position);
  int regions = 1;  // as many as can be shared out evenly
  while (state.size() > static_cast<std::size_t>(regions) * cellsOfRegion_) regions *= 2;
  return bisected(centres, regions);
}

/// Those that this rank tetrahedralises.
std::vector<CatFacePlanes::Region> CatFacePlanes::ownRegions(const GrowthState& state,
                                                             const CellShares& shares) const {
  std::vector<Region> all = regionsOf(state), own;
  const int ranks = shares.communicator().size(), rank = shares.communicator().rank();
  const auto count = static_cast<int>(all.size());
  for (int r = 0; r < count; ++r)
    if (r * ranks / count == rank) own.push_back(std::move(all[r]));
  return own;
}

/// Takes the cells of a region and those of which an image is within the margin of it.
void CatFacePlanes::chooseMembers(const GrowthState& state, const Region& region) {
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
bool CatFacePlanes::tetrahedraOf(const GrowthState& state, const Region& region, double detail) {
  const Timer watch(sums_.tetrahedraSeconds);
  tetrahedra_ = Tetrahedra();
  double largest = 0.0;
  for (const GrowingCell& cell : state)
    largest = std::max(largest, cell.pose.scale * scene_.shapes[cell.species]->radius());
  if (!input_.period.isZero() || region.size() < state.size())
    input_.margin =
        largest + marginSpacings * std::cbrt(input_.bounds.volume() / static_cast<double>(state.size()));
  chooseMembers(state, region);
  if (members_.size() < 2 && input_.period.isZero()) return true;
  ++sums_.runs;
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
      input_.objects.push_back({levels[index].get(), scene_.placement(cell.pose)});
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

}  // namespace packmesh
