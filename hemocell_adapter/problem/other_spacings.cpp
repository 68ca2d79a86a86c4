// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/other_spacings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/hemocell/lattice.h"
#include "hemocell_adapter/problem/make_lumen.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_file.h"

namespace packmesh::hemocell {
namespace {

/// A number of nodes at another spacing, for the same extent.
int scaledNodes(double nodes, double dx, double other, const std::string& what) {
  constexpr double rounding = 1e-9;  // of spacings and their ratio
  const double scaled = nodes * dx / other;
  if (std::abs(scaled - std::round(scaled)) > rounding * scaled || !(std::round(scaled) >= 1.0))
    throw InputError(
        fmt::format("{} {:.15g} at dx {:.15g} µm is {:.15g} µm, which is not a whole number of nodes "
                    "at that spacing",
                    what, nodes, dx, nodes * dx));
  if (scaled > std::numeric_limits<int>::max())
    throw InputError(fmt::format("{} {:.15g} would be {:.4g} nodes at that spacing", what, nodes, scaled));
  return int(std::round(scaled));
}

struct Refined {
  Request request;
  std::optional<Case> simulation;
};

/// The same request and case at another spacing.
Refined refined(const Request& request, const Case* simulation, double other) {
  Refined made{request, {}};
  made.request.dx = other;
  made.request.alsoDx.clear();
  if (made.request.container && made.request.container->nodes)
    for (double& nodes : *made.request.container->nodes)
      nodes = scaledNodes(nodes, request.dx, other, "<nodes>");
  if (!simulation) return made;
  made.simulation = *simulation;
  Domain& domain = made.simulation->domain;
  domain.dx = other;
  if (domain.geometry && !request.container)
    domain.refDirN = scaledNodes(domain.refDirN, request.dx, other, "<refDirN>");
  if (domain.boxNodes)
    for (int& nodes : *domain.boxNodes) nodes = scaledNodes(nodes, request.dx, other, "<domain>");
  return made;
}

/// HemoCell's verdict at another spacing on a cell with this placement at that of the case.
std::optional<std::string> violationAt(const OtherLattice& other, const Acceptance& acceptance,
                                       const TriangleMesh& mesh, const Placement& placement) {
  const Placement moved{placement.linear, placement.translation + other.shift};
  auto violation = acceptance.violation(placedVertices(mesh, moved));
  if (violation) *violation += fmt::format(" at dx {:.6g} µm", other.dx);
  return violation;
}

/// Walls of which the first is that of the lumen, the others those of other spacings.
class WallAtAllSpacings final : public Wall {
 public:
  struct Other {
    OtherLattice at;
    OtherAcceptance acceptance;
    std::unique_ptr<const Wall> wall;
  };

  WallAtAllSpacings(std::shared_ptr<const Wall> own, std::vector<Other> others)
      : own_(std::move(own)), others_(std::move(others)) {}

  WallDistance distance(const Vec3& p) const override {
    WallDistance nearest = own_->distance(p);
    for (const Other& other : others_) {
      const WallDistance d = other.wall->distance(p + other.at.shift);
      if (d.distance < nearest.distance) nearest = d;
    }
    return nearest;
  }

  void sample(const NodeBlock& block, float* distances) const override {
    own_->sample(block, distances);
    std::vector<float> further(std::size_t(block.nodes[0]) * block.nodes[1] * block.nodes[2]);
    for (const Other& other : others_) {
      NodeBlock moved = block;
      moved.origin += other.at.shift;
      other.wall->sample(moved, further.data());
      for (std::size_t i = 0; i < further.size(); ++i) distances[i] = std::min(distances[i], further[i]);
    }
  }

  double slack() const override {
    return largest([](const Wall& wall) { return wall.slack(); });
  }
  double samplingSpacing() const override {
    return -largest([](const Wall& wall) { return -wall.samplingSpacing(); });
  }

  bool isAway(const Sphere& sphere, double gap) const override {
    return own_->isAway(sphere, gap) && std::all_of(others_.begin(), others_.end(), [&](const Other& other) {
             return other.wall->isAway({sphere.center + other.at.shift, sphere.radius + margin}, 0.0);
           });
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    WallVerdict verdict = own_->examine(cell, gapOfInterest);
    for (const Other& other : others_) {
      if (verdict.violation) return verdict;
      verdict.violation =
          violationAt(other.at, *other.acceptance.acceptance, other.acceptance.mesh, cell.placement);
    }
    return verdict;
  }

 private:
  static constexpr double margin = 0.1;  ///< more than templates differ between spacings [µm]

  template <class Number>
  double largest(Number&& number) const {
    double all = number(*own_);
    for (const Other& other : others_) all = std::max(all, number(*other.wall));
    return all;
  }

  std::shared_ptr<const Wall> own_;
  std::vector<Other> others_;
};

/// The template that HemoCell builds of a species at a spacing.
TriangleMesh templateAt(const CellSpecies& species, double dx) {
  using Template = SpeciesPlan::Template;
  if (species.kind == Template::model) return buildTemplate(species.model, dx);
  if (species.kind == Template::mesh && species.meshFrame == MeshFrame::hemocell) {
    TriangleMesh mesh = meshFrom(species.meshFile);
    for (Vec3& v : mesh.vertices) v *= species.meshScale;
    return meshFromStl(std::move(mesh), dx);
  }
  return species.shape->mesh();
}

}  // namespace

Lumen withOtherSpacings(Lumen lumen, const Request& request, const Case* simulation,
                        const std::optional<PreInletPlace>& preInlet) {
  for (const double other : request.alsoDx) {
    if (other == request.dx) continue;
    if (preInlet || (simulation && simulation->running) || lumen.periodic || (!simulation && !lumen.keptBox))
      throw InputError(fmt::format(
          named("also-dx") +
              " {:.15g}: other spacings are for cases and boxes with closed ends: HemoCell deletes "
              "cells across periodic ends, and the frame of a pre-inlet follows from its nodes",
          other));
    const Lumen there = located(fmt::format("{} {:.15g}", named("also-dx"), other), [&] {
      const Refined at = refined(request, simulation, other);
      return makeLumen(at.request, at.simulation ? &*at.simulation : nullptr, {});
    });
    if (!simulation) {
      Box& kept = *lumen.keptBox;
      const Box own = there.keptBox->grownBy(-2.0 * inflation * std::max(0.0, other - request.dx));
      kept = {kept.lo.cwiseMax(own.lo), kept.hi.cwiseMin(own.hi)};
      lumen.container = makeBox(kept, {false, false, false});
      lumen.note += fmt::format("; only what HemoCell keeps at dx {:.6g} µm, too", other);
      continue;
    }
    const bool framed = simulation->domain.geometry && !request.container;
    lumen.others.push_back({other, Vec3::Constant(framed ? other - request.dx : 0.0), there.lattice});
  }
  return lumen;
}

std::vector<OtherAcceptance> otherAcceptances(const CellSpecies& species, const Lumen& lumen) {
  std::vector<OtherAcceptance> all;
  for (const OtherLattice& other : lumen.others)
    all.push_back({std::make_shared<Acceptance>(other.lattice, species.minimumDistanceFromSolid),
                   templateAt(species, other.dx)});
  return all;
}

std::optional<std::string> violationElsewhere(const CellSpecies& species, const Lumen& lumen,
                                              const Placement& placement, const TriangleMesh* own) {
  for (std::size_t i = 0; i < species.others.size(); ++i) {
    const OtherAcceptance& other = species.others[i];
    if (auto violation = violationAt(lumen.others[i], *other.acceptance, own ? *own : other.mesh, placement))
      return violation;
  }
  return {};
}

double inflationElsewhere(const Lumen& lumen, double dx) {
  double largest = dx;
  for (const OtherLattice& other : lumen.others) largest = std::max(largest, other.dx);
  return inflation * (largest - dx);
}

std::shared_ptr<const Wall> wallAtAllSpacings(std::shared_ptr<const Wall> wall, const CellSpecies& species,
                                              const Lumen& lumen, double dx, double wallClearance) {
  if (lumen.others.empty()) return wall;
  std::vector<WallAtAllSpacings::Other> others;
  for (std::size_t i = 0; i < lumen.others.size(); ++i) {
    const OtherLattice& other = lumen.others[i];
    const double beyond = 2.0 * inflation * std::max(0.0, other.dx - dx);
    others.push_back(
        {other, species.others[i],
         makeAcceptedWall(nullptr, other.lattice, species.minimumDistanceFromSolid, wallClearance - beyond)});
  }
  return std::make_shared<WallAtAllSpacings>(std::move(wall), std::move(others));
}

}  // namespace packmesh::hemocell
