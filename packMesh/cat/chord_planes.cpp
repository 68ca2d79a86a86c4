// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/chord_planes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/levels_of_detail.h"

namespace packmesh {
namespace {

/// Chords shorter than this take their direction from the gradient of the distance field [µm].
constexpr double shortChord = 1e-4;

/// A wall is concave or has edges where its distance to lateral points is smaller by more than this fraction
/// of their offset.
constexpr double closingIn = 0.01;

/// Below this length the gradient of the distance to the wall, as in the centre of a sphere, gives no
/// direction.
constexpr double noDirection = 1e-6;

/// Distance outside of the bounds up to which walls are sampled [µm].
constexpr double beyondBounds = 1.0;

/// Samples are padded to full clusters by repeating the last point.
bool repeated(const SamplePoints& points, int i) {
  return i % SamplePoints::width != 0 && points.x[i] == points.x[i - 1] && points.y[i] == points.y[i - 1] &&
         points.z[i] == points.z[i - 1];
}

Vec3 pointOf(const SamplePoints& points, int i) {
  return {points.x[i], points.y[i], points.z[i]};
}

std::vector<std::uint16_t> distinctPoints(const SamplePoints& points) {
  std::vector<std::uint16_t> distinct(points.clusters, 0);
  for (int i = 0; i < points.clusters * SamplePoints::width; ++i)
    if (!repeated(points, i))
      distinct[i / SamplePoints::width] |= static_cast<std::uint16_t>(1u << i % SamplePoints::width);
  return distinct;
}

void copyRows(const Mat3& from, float* to) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) to[3 * r + c] = static_cast<float>(from(r, c));
}

}  // namespace

ChordPlanes::ChordPlanes(const Physics& physics)
    : physics_(physics), kernel_(chordKernel(chosenInstructionSet())) {
  for (const Species& species : physics.species) {
    MetWall& met = walls_.emplace_back(MetWall{physics.wallOf(species), nullptr});
    if (met.wall && !met.wall->closedForm())
      met.sampled = std::make_shared<const SampledDistance>(
          *met.wall, physics.container->bounds().grownBy(beyondBounds), met.wall->samplingSpacing());
  }
  surfaces_.resize(physics.shapes.size());
  for (const int s : physics.shapesInUse()) {
    const Shape& shape = *physics.shapes[s];
    Surface surface{&shape, SurfaceDistance(shape), LevelsOfDetail(shape.mesh()), shape.views().field, {},
                    {}};
    for (int level = 0; level < surface.levels.count(); ++level) {
      const TriangleMesh& mesh = surface.levels.mesh(level);
      const double coarseness = std::sqrt(static_cast<double>(shape.mesh().vertices.size()) /
                                          static_cast<double>(mesh.vertices.size()));
      surface.points.push_back(level == 0 ? shape.samples()
                                          : sampleSurface(mesh, coarseness * shape.sampleSpacing()));
      surface.distinct.push_back(distinctPoints(surface.points.back()));
    }
    surfaces_[s] = std::make_unique<const Surface>(std::move(surface));
  }
}

ChordPlanes::Cell ChordPlanes::cellOf(std::int64_t index, const PlaneRequest& request,
                                      const std::vector<int>& levels) const {
  const Body& cell = request.surroundings.cells()[index];
  const bool fixed = isFixed(physics_, cell);
  return {cell.species,       cell.shape, cell.rotation,
          cell.position,      cell.scale, fixed ? 0.0 : request.surroundings.reach(index),
          levels[cell.shape], fixed,      nullptr};
}

/// The level of detail of each shape.
std::vector<int> ChordPlanes::levelsOf(const PlaneRequest& request) const {
  std::vector<int> levels;
  for (const auto& surface : surfaces_)
    levels.push_back(surface ? surface->levels.indexOf(request.detail) : 0);
  return levels;
}

void ChordPlanes::operator()(const PlaneRequest& request, std::vector<CellPlanes>& planes) {
  const std::vector<std::int64_t>& wanted = request.wanted;
  const std::vector<int> levels = levelsOf(request);
  const auto cellFor = [&](std::int64_t index) {
    Cell cell = cellOf(index, request, levels);
    const auto at = std::lower_bound(wanted.begin(), wanted.end(), index);
    if (at != wanted.end() && *at == index && !cell.fixed) cell.planes = &planes[at - wanted.begin()];
    return cell;
  };
  std::int64_t last = -1;
  Cell first{};
  for (const NearPair& pair : request.surroundings.pairsOf(wanted)) {
    if (pair.first != last) first = cellFor(last = pair.first);
    joinPair(pair, first, pair.second == pair.first ? first : cellFor(pair.second));
  }
  addAtWalls(request, planes);
}

void ChordPlanes::addAtWalls(const PlaneRequest& request, std::vector<CellPlanes>& planes) const {
  const std::vector<int> levels = levelsOf(request);
  for (std::size_t k = 0; k < request.wanted.size(); ++k) {
    Cell cell = cellOf(request.wanted[k], request, levels);
    if (cell.fixed) continue;
    cell.planes = &planes[k];
    if (walls_[cell.species].wall) meetWall(cell);
    meetRegion(cell);
  }
}

void ChordPlanes::markWithinReach(const PlaneRequest& request, const NearPair& pair,
                                  const std::array<Vertices, 2>& vertices,
                                  const std::array<std::vector<char>*, 2>& marks) const {
  const std::vector<int> levels = levelsOf(request);
  const Cell cells[] = {cellOf(pair.first, request, levels), cellOf(pair.second, request, levels)};
  const double limit = cells[0].reach + cells[1].reach + physics_.clearance;
  for (int k = 0; k < 2; ++k) {
    const Cell &a = cells[k], &b = cells[1 - k];
    const SurfaceDistance& field = surfaces_[b.shape]->field;
    const Mat3 toBody = b.rotation.transpose() / b.scale;
    const Mat3 linear = a.scale * toBody * a.rotation;
    const Vec3 offset = toBody * (a.position - b.position - (k == 0 ? pair.shift : Vec3(-pair.shift)));
    for (std::size_t v = 0; v < marks[k]->size(); ++v) {
      const Vec3 p = linear * (*vertices[k].points)[v] + offset;
      const double most = std::min(limit, a.scale * (*vertices[k].within)[v]) / b.scale;
      if (!(*marks[k])[v] && !field.isBeyond(p, most)) (*marks[k])[v] = field.sample(p).distance <= most;
    }
  }
}

void ChordPlanes::joinPair(const NearPair& pair, const Cell& a, const Cell& b) const {
  if (!a.planes && !b.planes) return;
  const Vec3 between = a.position - (b.position + pair.shift);
  const double distance = between.norm();
  if (distance > 0.0) {
    const Vec3 direction = between / distance;
    const double apart =
        distance - a.scale * surfaces_[a.shape]->shape->bound().support(a.rotation.transpose() * direction) -
        b.scale * surfaces_[b.shape]->shape->bound().support(b.rotation.transpose() * direction);
    if (apart > a.reach + b.reach + physics_.clearance) return;
  }
  dropChords(a, b, pair.shift);
  dropChords(b, a, -pair.shift);
}

/// Chords from the samples of one cell to the surface of another, and their planes for both.
void ChordPlanes::dropChords(const Cell& a, const Cell& b, const Vec3& ontoShift) const {
  ChordFrame frame;
  const Mat3 toBody = b.rotation.transpose() / b.scale;
  copyRows(a.scale * toBody * a.rotation, frame.toSurface.m);
  const Vec3 offset = toBody * (a.position - b.position - ontoShift);
  for (int k = 0; k < 3; ++k) frame.toSurface.t[k] = static_cast<float>(offset[k]);
  frame.toSurface.scale = static_cast<float>(a.scale / b.scale);
  copyRows(a.rotation, frame.sampled);
  copyRows(b.rotation, frame.surface);
  const double share = a.fixed ? 0.0 : b.fixed ? 1.0 : 0.5;
  frame.limit = static_cast<float>((a.reach + b.reach + physics_.clearance) / b.scale);
  frame.scale = static_cast<float>(b.scale);
  frame.shortChord = static_cast<float>(shortChord / b.scale);
  frame.share = static_cast<float>(share);
  frame.offset = static_cast<float>((0.5 - share) * physics_.clearance);

  const Surface& surface = *surfaces_[a.shape];
  const SamplePoints& points = surface.points[a.level];
  const auto most = static_cast<std::size_t>(points.clusters * SamplePoints::width);
  std::array<float*, CellPlanes::columns> ofA, ofB;
  if (a.planes) ofA = a.planes->room(most);
  const bool itself = a.planes == b.planes;  // a cell and its own image: the second half follows the first
  if (b.planes) ofB = b.planes->room(itself ? 2 * most + CellPlanes::spare : most);
  if (itself && a.planes) {
    ofA = ofB;
    for (float*& column : ofB) column += most + CellPlanes::spare;
  }
  const int found = kernel_(viewOf(points), surface.distinct[a.level].data(), frame, surfaces_[b.shape]->view,
                            {a.planes ? ofA.data() : nullptr, b.planes ? ofB.data() : nullptr});
  if (a.planes) a.planes->grow(found);
  if (!b.planes) return;
  if (itself)
    for (int k = 0; k < CellPlanes::columns; ++k) std::copy_n(ofB[k], found, ofA[k] + found);
  b.planes->grow(found);
}

void ChordPlanes::meetWall(const Cell& a) const {
  const Surface& surface = *surfaces_[a.shape];
  const MetWall& met = walls_[a.species];
  const double margin =
      physics_.wallClearanceOf(a.species);  // no slack: the distance is precise near the wall
  const double limit = a.reach + margin + met.wall->slack();
  const auto near = [&](const Vec3& p, double radius) { return met.toWall(p).distance <= limit + radius; };
  if (!near(a.position, a.scale * surface.shape->radius())) return;
  const SamplePoints& points = surface.points[a.level];
  for (int cluster = 0; cluster < points.clusters; ++cluster) {
    const Vec3 center(points.centerX[cluster], points.centerY[cluster], points.centerZ[cluster]);
    if (!near(a.position + a.scale * a.rotation * center, a.scale * points.radius[cluster])) continue;
    for (int i = cluster * SamplePoints::width; i < (cluster + 1) * SamplePoints::width; ++i) {
      if (repeated(points, i)) continue;
      const Vec3 arm = a.rotation * pointOf(points, i), p = a.position + a.scale * arm;
      const WallDistance here = met.toWall(p);
      if (here.distance > limit || here.gradient.norm() < noDirection) continue;
      const Vec3 inward = here.gradient.normalized();
      a.planes->add(arm, -inward, (here.distance - margin) - a.scale * inward.dot(arm));
      // The plane does not represent a wall that curves inwards or has edges: add planes for the parts that
      // the point could reach.
      const Vec3 u = inward.unitOrthogonal(), v = inward.cross(u);
      for (const Vec3& aside : {u, Vec3(-u), v, Vec3(-v)}) {
        const Vec3 q = p + a.reach * aside;
        const WallDistance there = met.toWall(q);
        if (there.distance > here.distance - closingIn * a.reach || there.gradient.norm() < noDirection)
          continue;
        const Vec3 back = there.gradient.normalized(), foot = q - (there.distance - margin) * back;
        if (back.dot(p - foot) > 0.0) a.planes->add(arm, -back, back.dot(a.position - foot));
      }
    }
  }
}

/// Keeps the centre in the region of its species.
void ChordPlanes::meetRegion(const Cell& cell) const {
  const Region* region = physics_.species[cell.species].freedom.region.get();
  if (!region) return;
  const WallDistance border = region->distance(cell.position);
  if (border.distance > cell.reach || border.gradient.norm() < noDirection) return;
  const Vec3 inward = border.gradient.normalized();
  cell.planes->add(Vec3::Zero(), -inward, border.distance);
}

}  // namespace packmesh
