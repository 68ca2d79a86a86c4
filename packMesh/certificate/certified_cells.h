// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The cells of a CertificateInput, addressed by number. Internal to packMesh/certificate.
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <tuple>

#include "packMesh/certificate/certificate_input.h"
#include "packMesh/certificate/periodic_neighbors.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_intersection.h"

namespace packmesh {

class CertifiedCells {
 public:
  /// @param input must outlive this object, as must the vector it refers to
  explicit CertifiedCells(const CertificateInput& input) : input_(input) {}

  std::int64_t count() const { return static_cast<std::int64_t>(input_.cells->size()); }
  bool isOwn(std::int64_t cell) const { return input_.own == nullptr || (*input_.own)[cell]; }
  const Shape& shape(std::int64_t cell) const { return *input_.shapes[at(cell).shape]; }
  const Placement& placement(std::int64_t cell) const { return at(cell).placement; }
  const Wall* wall(std::int64_t cell) const {
    const std::size_t species = at(cell).species;
    return species < input_.walls.size() ? input_.walls[species] : nullptr;
  }
  PlacedHierarchy mesh(std::int64_t cell) const { return {shape(cell).hierarchy(), placement(cell)}; }
  Sphere sphere(std::int64_t cell) const { return boundingSphere(shape(cell).hierarchy(), placement(cell)); }
  double volume(std::int64_t cell) const {
    return shape(cell).volume() * std::abs(placement(cell).linear.determinant());
  }

  PeriodicNeighbors neighbors() const {
    std::vector<Sphere> spheres(count());
    input_.threads.forEachPart(count(), [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) spheres[i] = sphere(i);
    });
    return {std::move(spheres), input_.container ? input_.container->period() : Vec3(Vec3::Zero())};
  }

  /// A lower bound of the gap of two cells [µm]: what is between their convex bounds across the line between
  /// their centres, negative if that is nothing.
  double leastGap(const NearPair& pair) const {
    const Placement &a = placement(pair.first), &b = placement(pair.second);
    const Vec3 between = a.translation - b.translation - pair.shift;
    const double distance = between.norm();
    if (!(distance > 0.0)) return -std::numeric_limits<double>::infinity();
    const Vec3 n = between / distance;
    const double reach = shape(pair.first).bound().support(a.linear.transpose() * n) +
                         shape(pair.second).bound().support(b.linear.transpose() * n);
    return distance - reach - tolerance::culling;
  }

  /// The first cell in place, the second moved by the shift. The sum is part of what is proven: the image of
  /// a cell is its mesh placed with the shifted translation.
  MeshPairResult relation(const NearPair& pair, double largestGap) const {
    Placement moved = placement(pair.second);
    moved.translation += pair.shift;
    return relate(shape(pair.first).hierarchy(), placement(pair.first), shape(pair.second).hierarchy(), moved,
                  largestGap);
  }

  /// The violation of a pair, if any.
  std::optional<OverlappingPair> faultOf(const NearPair& pair, const MeshPairResult& result) const {
    if (result.relation == MeshRelation::apart && !(result.gap < input_.requiredGap)) return {};
    const bool contained =
        result.relation == MeshRelation::firstInside || result.relation == MeshRelation::secondInside;
    return OverlappingPair{pair.first, pair.second, pair.shift, contained, result.gap};
  }

 private:
  const PlacedCell& at(std::int64_t cell) const { return (*input_.cells)[cell]; }

  const CertificateInput& input_;
};

}  // namespace packmesh
