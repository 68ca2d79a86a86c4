// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/blood.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/make_species.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/container/side_wall.h"
#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/random.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/parallel/blocks.h"

namespace packmesh::hemocell {
namespace {

/// Distances from the wall that differ by less are the same [µm]; places that are tried to find one.
constexpr double sameDepth = 0.25;
constexpr std::uint32_t mostPlaces = 200;

/// The distances between cells are changed by at most this fraction along an axis, so that the period of the
/// lumen is a multiple of that of the piece.
constexpr double mostStretch = 0.1;

/// The only periodic axis.
std::optional<int> periodicAxis(const Vec3& period) {
  if ((period.array() > 0.0).count() != 1) return {};
  return int(std::find_if(period.begin(), period.end(), [](double p) { return p > 0.0; }) - period.begin());
}

/// The axis of a pipe.
std::optional<int> axisOf(const Scene& scene) {
  if (scene.request.container && scene.request.container->lumen) {
    const SolidRequest& body = *scene.request.container->lumen;
    if (body.kind == SolidRequest::Kind::cylinder) return body.axis;
    if (body.openAxis) return body.openAxis;
  }
  return periodicAxis(scene.lumen.container->period());
}

/// A piece of blood in the coordinates of a lumen.
class Piece {
 public:
  Piece(const StateCells& blood, const Scene& scene) : low_(blood.box.lo), period_(blood.period) {
    const Container& lumen = *scene.lumen.container;
    const Vec3 size = blood.box.size();
    int longest = 0;
    size.maxCoeff(&longest);
    if (const auto axis = axisOf(scene))
      shift_ = (*axis - periodicAxis(blood.period).value_or(longest) + 3) % 3;
    const Box bounds = lumen.bounds();
    for (int k = 0; k < 3; ++k) {
      const int to = (k + shift_) % 3;
      step_[to] = blood.period[k] > 0.0 ? blood.period[k] : size[k];
      const double period = lumen.period()[to];
      if (blood.period[k] > 0.0 && period > 0.0) {
        const double fitting = period / std::max(1.0, std::round(period / step_[to]));
        if (std::abs(fitting / step_[to] - 1.0) <= mostStretch) stretch_[to] = fitting / step_[to];
        step_[to] *= stretch_[to];
      }
      from_[to] = blood.period[k] > 0.0 ? bounds.lo[to] : bounds.center()[to] - 0.5 * size[k];
      first_[to] = int(std::floor((bounds.lo[to] - from_[to]) / step_[to]));
      last_[to] = int(std::ceil((bounds.hi[to] - from_[to]) / step_[to])) - 1;
    }
    Mat3 turn = Mat3::Zero();
    for (int k = 0; k < 3; ++k) turn((k + shift_) % 3, k) = 1.0;
    turn_ = Quaternion(turn);
  }

  /// Whether walls of the piece are repeated inside the lumen.
  bool repeatsWalls() const {
    for (int k = 0; k < 3; ++k) {
      const int to = (k + shift_) % 3;
      if (!(period_[k] > 0.0) && last_[to] > first_[to]) return true;
    }
    return false;
  }

  /// Calls visit(pose) for every copy of a cell with its centre in the box of the lumen.
  template <class Visit>
  void forEachCopy(const Pose& pose, const Box& bounds, Visit&& visit) const {
    Vec3 p = pose.position;
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0.0) p[k] -= period_[k] * std::floor((p[k] - low_[k]) / period_[k]);
    poll();
    const Vec3 at = from_ + stretch_.cwiseProduct(turned(p - low_));
    const Quaternion orientation = (turn_ * pose.orientation).normalized();
    for (int x = first_[0]; x <= last_[0]; ++x)
      for (int y = first_[1]; y <= last_[1]; ++y)
        for (int z = first_[2]; z <= last_[2]; ++z) {
          const Vec3 position = at + step_.cwiseProduct(Vec3(x, y, z));
          if ((position.array() >= bounds.lo.array()).all() && (position.array() < bounds.hi.array()).all())
            visit(Pose{1.0, shift_ == 0 ? pose.orientation : orientation, position});
        }
  }

 private:
  /// Axis k becomes axis k + shift: a rotation.
  Vec3 turned(const Vec3& v) const { return {v[(3 - shift_) % 3], v[(4 - shift_) % 3], v[(5 - shift_) % 3]}; }

  Vec3 low_, period_;
  int shift_ = 0;
  Vec3 step_, from_, stretch_ = Vec3::Ones();
  std::array<int, 3> first_{}, last_{};
  Quaternion turn_;
};

/// The rotation that turns one direction of the wall into another, about the axis if there is one.
Quaternion turnBetween(const Vec3& from, const Vec3& to, std::optional<int> axis) {
  if (!(from.norm() > 0.0 && to.norm() > 0.0)) return Quaternion::Identity();
  if (!axis) return Quaternion::FromTwoVectors(from, to);
  const auto angle = [&](const Vec3& v) { return std::atan2(v[(*axis + 2) % 3], v[(*axis + 1) % 3]); };
  return Quaternion::around(Vec3::Unit(*axis), angle(to) - angle(from));
}

/// Numbers of the copies that are where cells can be: those that meet none before them, and the others.
struct Fitting {
  std::vector<std::size_t> apart, crowded;
};

Fitting fitting(const Scene& scene, const std::vector<PresentCell>& copies) {
  const Physics physics = physicsOf(scene);
  std::vector<char> fits(copies.size(), 0);
  scene.team.forEach(std::int64_t(copies.size()), [&](std::int64_t i, int) {
    const PlacedCell cell = Scene::placed(copies[i]);
    const Wall* const wall = scene.lumen.container->wall();
    fits[i] =
        !(wall && wall->examine({scene.shapes[cell.shape]->hierarchy(), cell.placement}, 0.0).violation) &&
        !hemocellViolation(scene, cell, Loading::plugIn);
  });
  // Cells that exist already stay.
  std::vector<PlacedCell> cells;
  for (std::size_t s = 0; s < scene.species.size(); ++s)
    for (const auto* const present : {&scene.species[s].fixed, &scene.species[s].start})
      for (const PresentCell& cell : *present) cells.push_back(Scene::placed(cell));
  const auto others = std::int64_t(cells.size());
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (!fits[i]) continue;
    numbers.push_back(i);
    cells.push_back(Scene::placed(copies[i]));
  }
  std::vector<char> leaves(cells.size(), 0);
  for (const OverlappingPair& pair : findOverlaps(certificateInputOf(physics, cells, scene.team)))
    if (!leaves[pair.first] && pair.second >= others) leaves[pair.second] = 1;
  Fitting found;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    (leaves[others + i] ? found.crowded : found.apart).push_back(numbers[i]);
  return found;
}

/// Refuses a piece that is thinner than its cells: they would overlap with their own copies.
void requireWide(const StateCells& blood, const std::string& file) {
  double thinnest = std::numeric_limits<double>::infinity();
  for (const StateCells::Kind& kind : blood.species)
    thinnest = std::min(thinnest, boundingBox(kind.mesh).size().minCoeff());
  for (int k = 0; k < 3; ++k) {
    const double step = blood.period[k] > 0.0 ? blood.period[k] : blood.box.size()[k];
    if (step < 0.5 * thinnest)
      throw InputError(
          fmt::format("{}: its cells would be repeated every {:.4g} µm along {}, which is less than they are "
                      "thick: is its lumen that of its cells?",
                      file, step, "xyz"[k]));
  }
}

/// The species with the numbers of cells of each kind of the piece, unless those are requested: those that
/// fit, or, if the number of red cells is requested, as many per red cell as in the piece.
std::vector<CellSpecies> countedAsIn(const StateCells& blood, const std::vector<int>& speciesOf,
                                     std::vector<CellSpecies> all, const Request& request, Notices& notices) {
  const std::string file = request.blood->string();
  std::int64_t redCells = 0;
  bool countsRedCells = request.hematocrit.has_value();
  for (const Cell& cell : blood.cells) {
    CellSpecies& species = all[speciesOf[cell.species]];
    ++species.blood.cells;
    redCells += species.redCell;
  }
  for (const CellSpecies& species : all) {
    const SpeciesRequest* const asked = findSpecies(request, species.name);
    countsRedCells = countsRedCells || (species.redCell && asked && asked->count);
  }
  for (CellSpecies& species : all) {
    const SpeciesRequest* const asked = findSpecies(request, species.name);
    if (!asked || !asked->inBlood) continue;
    if (species.blood.cells > 0 && species.start.empty())
      notices.warnings.push_back(fmt::format("{}: no copy of its {} cells '{}' fits into the lumen", file,
                                             species.blood.cells, species.name));
    if (species.startFrom.empty()) species.startFrom = file;
    const bool determined = asked->count || asked->ratio || (request.hematocrit && species.redCell);
    if (determined) continue;
    species.statedCount.reset();
    if (countsRedCells && redCells > 0 && !species.redCell && species.fixed.empty())
      species.ratio = double(species.blood.cells) / double(redCells);
    else
      species.statedCount = std::int64_t(species.fixed.size() + species.start.size());
  }
  return all;
}

/// The cells of blood, which lose their vertices. References blood and species.
CellsOfFile takeCells(StateCells& blood, const std::vector<int>& speciesOf, const std::string& file) {
  CellsOfFile all{file, {}, {}, {}};
  for (Cell& cell : blood.cells) {
    PresentCell& present = all.cells.emplace_back(lineOf(cell));
    present.vertices = std::move(cell.vertices);
  }
  all.species = [&](std::size_t i) { return speciesOf[blood.cells[i].species]; };
  all.triangles = [&](std::size_t i) -> const std::vector<Triangle>& {
    return blood.species[blood.cells[i].species].mesh.triangles;
  };
  return all;
}

}  // namespace

Scene withBlood(Scene scene, Notices& notices) {
  if (!scene.request.blood) return scene;
  const std::string file = scene.request.blood->string();
  StateCells blood = cellsFrom(*scene.request.blood, Communicator());
  if (blood.box.empty() || !(blood.box.size().minCoeff() > 0.0))
    throw InputError(file + ": has no lumen whose size its cells could be repeated by");
  requireWide(blood, file);
  const Piece piece(blood, scene);
  if (piece.repeatsWalls() && !scene.request.profile)
    notices.warnings.push_back(
        file +
        ": the lumen is larger than that of these cells, whose walls are repeated inside it, with the plasma "
        "and the platelets that were there. " +
        named("profile", "developed") +
        " puts red cells towards the axis, and "
        "platelets "
        "to the wall");
  std::vector<int> speciesOf;
  for (const StateCells::Kind& kind : blood.species) {
    const auto same = [&](const CellSpecies& species) { return species.name == kind.name; };
    speciesOf.push_back(
        int(std::find_if(scene.species.begin(), scene.species.end(), same) - scene.species.begin()));
  }
  const ShapedCells shaped = makeShapes(takeCells(blood, speciesOf, file), scene.species, scene.shapes.size(),
                                        SelfIntersecting::undeform, scene.team, notices);
  scene.shapes.insert(scene.shapes.end(), shaped.shapes.begin(), shaped.shapes.end());
  for (const PresentCell& cell : shaped.cells)
    if (cell.shape >= 0) scene.species[cell.species].blood.shapes.push_back(cell.shape);
  std::vector<PresentCell> copies;
  const Box bounds = scene.lumen.container->bounds();
  for (std::size_t i = 0; i < shaped.cells.size(); ++i)
    piece.forEachCopy(blood.cells[i].pose, bounds, [&](const Pose& pose) {
      PresentCell copy = posLineOf(pose);
      copy.shape = shaped.cells[i].shape;
      copy.species = shaped.cells[i].species;
      copies.push_back(copy);
    });
  const Fitting found = fitting(scene, copies);
  for (const std::size_t i : found.apart) scene.species[copies[i].species].start.push_back(copies[i]);
  for (const std::size_t i : found.crowded)
    scene.species[copies[i].species].blood.crowded.push_back(copies[i]);
  scene.species = countedAsIn(blood, speciesOf, std::move(scene.species), scene.request, notices);
  return scene;
}

std::vector<Cell> addLike(const std::vector<Cell>& there, std::int64_t count, const Scene& scene,
                          std::uint32_t stream) {
  std::vector<Cell> cells;
  if (there.empty() || !scene.lumen.container->wall()) return cells;
  const SideWall wall(scene.lumen.container, endAxes(scene));
  if (!wall.exists()) return cells;
  const std::uint64_t seed = scene.request.seed;
  const Box bounds = scene.lumen.container->bounds();
  const std::optional<int> axis = axisOf(scene);
  for (std::int64_t n = 0; n < count; ++n) {
    poll();
    const double chosen = uniform4(seed, RandomStream::draw, std::uint64_t(n), stream)[0];
    Cell cell = there[std::size_t(chosen * double(there.size()))];
    const Pose like = std::exchange(cell.pose, {});
    const WallDistance from = wall.distance(like.position);
    WallDistance found{};
    double nearest = std::numeric_limits<double>::infinity();
    for (std::uint32_t k = 0; k < mostPlaces && nearest > sameDepth; ++k) {
      const auto u = uniform4(seed, RandomStream::position, std::uint64_t(n) * mostPlaces + k, stream);
      const Vec3 place = bounds.lo + bounds.size().cwiseProduct(Vec3(u[0], u[1], u[2]));
      const WallDistance to = wall.distance(place);
      if (!(std::abs(to.distance - from.distance) < nearest)) continue;
      nearest = std::abs(to.distance - from.distance);
      found = to;
      cell.pose.position = place;
    }
    cell.pose.orientation =
        (turnBetween(from.gradient, found.gradient, axis) * like.orientation).normalized();
    cells.push_back(cell);
  }
  return cells;
}

}  // namespace packmesh::hemocell
