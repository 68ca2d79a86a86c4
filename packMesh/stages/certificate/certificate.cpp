// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/certificate/certificate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "packMesh/stages/certificate/neighbors.h"

namespace packmesh {

namespace {

/// Gaps are first looked for below this [µm].
constexpr double smallestInterest = 0.02;

/// The cells of a CertificateInput, addressed by number.
class Cells {
 public:
  explicit Cells(const CertificateInput& input) : input_(input), cells_(*input.cells) {}

  std::int64_t count() const { return static_cast<std::int64_t>(cells_.size()); }
  const Shape& shape(std::int64_t cell) const { return *input_.shapes[cells_[cell].species]; }
  const Wall* wall(std::int64_t cell) const {
    const std::size_t species = cells_[cell].species;
    return species < input_.walls.size() ? input_.walls[species] : nullptr;
  }
  const Placement& placement(std::int64_t cell) const { return cells_[cell].placement; }
  Sphere sphere(std::int64_t cell) const { return boundingSphere(shape(cell).hierarchy(), placement(cell)); }
  double volume(std::int64_t cell) const {
    return shape(cell).volume() * std::abs(placement(cell).linear.determinant());
  }

  PeriodicNeighbors neighbors() const {
    std::vector<Sphere> spheres(cells_.size());
    for (std::int64_t i = 0; i < count(); ++i) spheres[i] = sphere(i);
    return {std::move(spheres), input_.container ? input_.container->period() : Vec3(Vec3::Zero())};
  }

  /// The first as it is, the second moved by the shift. That sum is part of what is proven: the image of a
  /// cell is its mesh placed with the moved translation.
  MeshPairResult relation(const NearPair& pair, double gapOfInterest) const {
    Placement moved = placement(pair.second);
    moved.translation += pair.shift;
    return relate(shape(pair.first).hierarchy(), placement(pair.first), shape(pair.second).hierarchy(), moved,
                  gapOfInterest);
  }

 private:
  const CertificateInput& input_;
  const std::vector<PlacedCell>& cells_;
};

/// The fault of a pair, if it has one.
std::optional<OverlappingPair> faultOf(const NearPair& pair, const MeshPairResult& result,
                                       double requiredGap) {
  if (result.relation == MeshRelation::apart && !(result.gap < requiredGap)) return {};
  const bool contained =
      result.relation == MeshRelation::firstInside || result.relation == MeshRelation::secondInside;
  return OverlappingPair{pair.first, pair.second, pair.shift, contained, result.gap};
}

void sortByCells(std::vector<OverlappingPair>& pairs) {
  const auto key = [](const OverlappingPair& p) {
    return std::make_tuple(p.first, p.second, p.shift[0], p.shift[1], p.shift[2]);
  };
  std::sort(pairs.begin(), pairs.end(),
            [&](const OverlappingPair& a, const OverlappingPair& b) { return key(a) < key(b); });
}

void certifyPairs(const Cells& cells, double requiredGap, double gapOfInterest, Certificate& out) {
  const PeriodicNeighbors neighbors = cells.neighbors();
  double gap = gapOfInterest;  // smallest so far: larger ones need not be measured
  for (std::int64_t i = 0; i < cells.count(); ++i)
    neighbors.forEachNear(i, std::max(gap, requiredGap), true, [&](const NearPair& pair) {
      ++out.pairsTested;
      const MeshPairResult result = cells.relation(pair, std::max(gap, requiredGap));
      if (const auto fault = faultOf(pair, result, requiredGap)) out.overlapping.push_back(*fault);
      if (result.gap < gap) out.minimumGap = gap = result.gap;
    });
  sortByCells(out.overlapping);
}

void certifyWalls(const Cells& cells, Certificate& out) {
  for (std::int64_t i = 0; i < cells.count(); ++i) {
    const Wall* wall = cells.wall(i);
    if (!wall) continue;
    const Sphere sphere = cells.sphere(i);
    if (wall->distance(sphere.center).distance - wall->slack() > sphere.radius) continue;
    if (auto reason = wall->objection(placed(cells.shape(i).mesh(), cells.placement(i))))
      out.misplaced.push_back({i, std::move(*reason)});
  }
}

}  // namespace

Certificate certify(const CertificateInput& input, double largestGap) {
  const Cells cells(input);
  Certificate out;
  out.cells = cells.count();
  for (std::int64_t i = 0; i < cells.count(); ++i) out.cellVolume += cells.volume(i);
  // Measuring gaps of a micrometre costs fifty times what gaps of a hundredth do, and few packings need it.
  for (double interest = std::min(smallestInterest, largestGap);;
       interest = std::min(8.0 * interest, largestGap)) {
    out.overlapping.clear();
    out.pairsTested = 0;
    certifyPairs(cells, input.requiredGap, interest, out);
    if (out.minimumGap < interest || interest >= largestGap) break;
  }
  certifyWalls(cells, out);
  return out;
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input,
                                          const std::vector<std::int64_t>& movedCells) {
  const Cells cells(input);
  const PeriodicNeighbors neighbors = cells.neighbors();
  std::vector<bool> moved(cells.count(), false);
  for (std::int64_t i : movedCells) moved[i] = true;
  std::vector<OverlappingPair> out;
  for (std::int64_t i = 0; i < cells.count(); ++i) {
    if (!moved[i]) continue;
    neighbors.forEachNear(i, input.requiredGap, false, [&](const NearPair& pair) {
      const std::int64_t other = pair.first == i ? pair.second : pair.first;
      if (other < i && moved[other]) return;  // was its turn
      const MeshPairResult result = cells.relation(pair, input.requiredGap);
      if (const auto fault = faultOf(pair, result, input.requiredGap)) out.push_back(*fault);
    });
  }
  sortByCells(out);
  return out;
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input) {
  std::vector<std::int64_t> all(input.cells->size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
  return findOverlaps(input, all);
}

}  // namespace packmesh
