// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/blood.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "hemocell_adapter/problem/own_meshes.h"
#include "packMesh/certificate/certify.h"
#include "packMesh/core/error.h"
#include "packMesh/packing/state_cells.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh::hemocell {
namespace {

/// The only periodic axis.
std::optional<int> periodicAxis(const Vec3& period) {
  if ((period.array() > 0.0).count() != 1) return {};
  return int(std::find_if(period.begin(), period.end(), [](double p) { return p > 0.0; }) - period.begin());
}

/// The axis of a pipe.
std::optional<int> axisOf(const Problem& problem) {
  if (problem.request.container && problem.request.container->lumen) {
    const SolidRequest& body = *problem.request.container->lumen;
    if (body.kind == SolidRequest::Kind::cylinder) return body.axis;
    if (body.openAxis) return body.openAxis;
  }
  return periodicAxis(problem.lumen.container->period());
}

/// A piece of blood in the coordinates of a lumen.
class Piece {
 public:
  Piece(const StateCells& blood, const Problem& problem) : low_(blood.box.lo), period_(blood.period) {
    const Container& lumen = *problem.lumen.container;
    const Vec3 size = blood.box.size();
    int longest = 0;
    size.maxCoeff(&longest);
    if (const auto axis = axisOf(problem))
      shift_ = (*axis - periodicAxis(blood.period).value_or(longest) + 3) % 3;
    const Box bounds = lumen.bounds();
    for (int k = 0; k < 3; ++k) {
      const int to = (k + shift_) % 3;
      step_[to] = blood.period[k] > 0.0 ? blood.period[k] : size[k];
      from_[to] = blood.period[k] > 0.0 ? bounds.lo[to] : bounds.center()[to] - 0.5 * size[k];
      first_[to] = int(std::floor((bounds.lo[to] - from_[to]) / step_[to]));
      last_[to] = int(std::ceil((bounds.hi[to] - from_[to]) / step_[to])) - 1;
    }
    Mat3 turn = Mat3::Zero();
    for (int k = 0; k < 3; ++k) turn((k + shift_) % 3, k) = 1.0;
    turn_ = Quaternion(turn);
  }

  /// Calls visit(pose) for every copy of a cell with its centre in the box of the lumen.
  template <class Visit>
  void forEachCopy(const Pose& pose, const Box& bounds, Visit&& visit) const {
    Vec3 p = pose.position;
    for (int k = 0; k < 3; ++k)
      if (period_[k] > 0.0) p[k] -= period_[k] * std::floor((p[k] - low_[k]) / period_[k]);
    const Vec3 at = from_ + turned(p - low_);
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
  Vec3 step_, from_;
  std::array<int, 3> first_{}, last_{};
  Quaternion turn_;
};

struct Copy {
  int species;
  PresentCell cell;
};

/// Numbers of copies that can stay.
std::vector<std::size_t> fitting(const Problem& problem, const std::vector<Copy>& copies) {
  const Physics physics = physicsOf(problem);
  const auto placedOf = [&](int species, const PresentCell& cell) {
    return PlacedCell{problem.numberOf(species, cell), placementOf(cell)};
  };
  std::vector<char> fits(copies.size(), 0);
  problem.team.forEach(std::int64_t(copies.size()), [&](std::int64_t i, int) {
    const PlacedCell cell = placedOf(copies[i].species, copies[i].cell);
    const Wall* const wall = problem.lumen.container->wall();
    fits[i] = !(wall &&
                wall->examine({problem.shapeOf(cell.species).hierarchy(), cell.placement}, 0.0).violation) &&
              !(keepsAll(problem) && hemocellViolation(problem, cell));
  });
  // Cells that exist already stay.
  std::vector<PlacedCell> cells;
  for (std::size_t s = 0; s < problem.species.size(); ++s)
    for (const auto* const present : {&problem.species[s].fixed, &problem.species[s].start})
      for (const PresentCell& cell : *present) cells.push_back(placedOf(int(s), cell));
  const auto others = std::int64_t(cells.size());
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    if (!fits[i]) continue;
    numbers.push_back(i);
    cells.push_back(placedOf(copies[i].species, copies[i].cell));
  }
  std::vector<char> leaves(cells.size(), 0);
  for (const OverlappingPair& pair : findOverlaps(certificateInputOf(physics, cells, problem.team)))
    if (!leaves[pair.first] && pair.second >= others) leaves[pair.second] = 1;
  std::vector<std::size_t> stay;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!leaves[others + i]) stay.push_back(numbers[i]);
  return stay;
}

}  // namespace

void addBlood(Problem& problem) {
  if (!problem.request.blood) return;
  const std::string file = problem.request.blood->string();
  StateCells blood = readStateCells(*problem.request.blood, Communicator());
  if (blood.box.empty() || !(blood.box.size().minCoeff() > 0.0))
    throw InputError(file + ": has no lumen whose size its cells could be repeated by");
  const Piece piece(blood, problem);
  std::vector<int> speciesOf;
  for (const StateCells::Kind& kind : blood.species) {
    const auto same = [&](const CellSpecies& species) { return species.name == kind.name; };
    speciesOf.push_back(
        int(std::find_if(problem.species.begin(), problem.species.end(), same) - problem.species.begin()));
  }
  std::vector<OwnMesh> meshes;
  std::vector<PresentCell> cells(blood.cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Cell& cell = blood.cells[i];
    cells[i].vertices = std::move(cell.vertices);
    if (!cells[i].vertices.empty())
      meshes.push_back({&cells[i], speciesOf[cell.species], &blood.species[cell.species].mesh.triangles});
  }
  addOwnMeshes(problem, meshes, file);
  for (const OwnMesh& mesh : meshes) problem.species[mesh.species].membranes.push_back(mesh.cell->membrane);
  std::vector<Copy> copies;
  const Box bounds = problem.lumen.container->bounds();
  for (std::size_t i = 0; i < cells.size(); ++i)
    piece.forEachCopy(blood.cells[i].pose, bounds, [&](const Pose& pose) {
      PresentCell copy = posLineOf(pose);
      copy.membrane = cells[i].membrane;
      copies.push_back({speciesOf[blood.cells[i].species], copy});
    });
  for (const std::size_t i : fitting(problem, copies))
    problem.species[copies[i].species].start.push_back(copies[i].cell);
  for (CellSpecies& species : problem.species) {
    const SpeciesRequest* const asked = findSpecies(problem.request, species.name);
    if (!asked || !asked->inBlood) continue;
    const bool determined = asked->count || asked->ratio || (problem.request.hematocrit && species.redCell);
    if (!determined) species.statedCount = std::int64_t(species.fixed.size() + species.start.size());
    if (species.startFrom.empty()) species.startFrom = file;
  }
}

}  // namespace packmesh::hemocell
