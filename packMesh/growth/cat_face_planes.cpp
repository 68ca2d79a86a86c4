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

/// As many cells as are worth the cells around them, which take part in the runs of several blocks.
constexpr std::int64_t cellsOfBlock = 100;

}  // namespace

CatFacePlanes::CatFacePlanes(const GrowthScene& scene, TetrahedraSums& sums, int failingAttempts)
    : scene_(scene), chords_(scene), sums_(sums) {
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

std::int64_t CatFacePlanes::cellsAtOnce() const {
  return cellsOfBlock;
}

double CatFacePlanes::range(std::int64_t count) const {
  double largest = 0.0;
  for (const Shape* shape : scene_.shapes) largest = std::max(largest, shape->radius());
  return margin(largest, count) + 2.0 * largest;
}

/// Up to here around the bodies, images and cells of other blocks take part [µm].
double CatFacePlanes::margin(double largestRadius, std::int64_t count) const {
  return largestRadius + marginSpacings * std::cbrt(input_.bounds.volume() / static_cast<double>(count));
}

PlaneConstraints CatFacePlanes::operator()(const PlaneRequest& request) {
  if (request.wanted.empty()) return {};
  if (!tetrahedraOf(request)) return chords_(request);
  const Timer watch(sums_.faceSeconds);
  splitChordally(tetrahedra_, WallFaces::atWall, split_);
  std::vector<double> reach;
  for (const std::int64_t cell : members_) reach.push_back(request.surroundings.reach(cell));
  PlaneConstraints planes = chords_.atWalls(request);
  const PlaneConstraints found = planesOfFaces(tetrahedra_, split_, input_.objects, sliverCosine, reach);
  for (std::size_t object = 0; object < found.size(); ++object) {
    const auto at = std::lower_bound(request.wanted.begin(), request.wanted.end(), members_[object]);
    if (at == request.wanted.end() || *at != members_[object]) continue;
    std::vector<PlaneConstraint>& of = planes[at - request.wanted.begin()];
    of.insert(of.end(), found[object].begin(), found[object].end());
  }
  return planes;
}

/// Takes the wanted cells and those of which an image is within the margin of them.
void CatFacePlanes::chooseMembers(const PlaneRequest& request) {
  const std::vector<Body>& cells = request.surroundings.cells();
  members_.clear();
  input_.primary.clear();
  if (static_cast<std::int64_t>(request.wanted.size()) == request.count) {
    members_ = request.wanted;
    return;
  }
  const Vec3& first = cells[request.wanted.front()].position;
  input_.region = Box{first, first};
  for (const std::int64_t cell : request.wanted) input_.region.add(cells[cell].position);
  for (std::int64_t cell = 0; cell < static_cast<std::int64_t>(cells.size()); ++cell) {
    const Body& body = cells[cell];
    const double reach = input_.margin + 2.0 * body.scale * scene_.shapes[body.species]->radius();
    const bool wanted = std::binary_search(request.wanted.begin(), request.wanted.end(), cell);
    bool near = wanted;
    forEachImage(body.position, reach, input_.bounds, input_.period, [&](const ImageShift& n) {
      const Vec3 image = body.position + displacement(n, input_.period);
      near = near || input_.region.squaredDistance(image) < reach * reach;
    });
    if (!near) continue;
    members_.push_back(cell);
    input_.primary.push_back(wanted);
  }
}

/// @return whether tetrahedra_ are those around the wanted cells; otherwise TetGen failed
bool CatFacePlanes::tetrahedraOf(const PlaneRequest& request) {
  const Timer watch(sums_.tetrahedraSeconds);
  const std::vector<Body>& cells = request.surroundings.cells();
  tetrahedra_ = Tetrahedra();
  input_.margin = margin(request.largestRadius, request.count);
  chooseMembers(request);
  if (members_.size() < 2 && input_.period.isZero()) return true;
  ++sums_.runs;
  int coarsest = 0;
  for (std::size_t s = 0; s < levels_.size(); ++s)
    coarsest = std::max(coarsest, chords_.levels(static_cast<int>(s)).indexOf(request.detail));
  for (int level = coarsest; level >= 0; --level) {
    // The cells themselves are known not to meet.
    input_.valid = level == 0;
    input_.objects.clear();
    for (const std::int64_t member : members_) {
      const Body& cell = cells[member];
      const auto& levels = levels_[cell.species];
      const int index = std::min(level, chords_.levels(cell.species).indexOf(request.detail));
      input_.objects.push_back({levels[index].get(), scene_.placement(cell.pose())});
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
