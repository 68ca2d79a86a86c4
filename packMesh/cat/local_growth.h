// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth of a few cells among many.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "packMesh/cat/growth.h"

namespace packmesh {

/// Constructs a plane function for the problem that is worked on.
using PlaneFunctionFactory = std::function<std::unique_ptr<PlaneFunction>()>;

/// Growth of some cells of a state to scale 1, up to the surfaces of their neighbours, as in CAT cells: all
/// other cells stay fixed. The cost is that of the cells near them. Only this rank takes part.
class LocalGrowth {
 public:
  /// References `physics`, which must outlive this. There is no relaxation at barriers, since it would move
  /// all cells. Only the last barrier is used.
  LocalGrowth(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
              const PlaneFunctionFactory& factory);

  /// Whether a cell may have its centre there; empty: anywhere.
  using Permitted = std::function<bool(const Vec3&)>;

  /// @param growing indices into the state, ascending
  /// @param state free of overlap; also on return, with no cell smaller than before. Unchanged if a cell
  ///   would end where it is not permitted
  /// @return whether all of `growing` reached scale 1
  bool grow(const std::vector<std::int64_t>& growing, const std::function<bool()>& stop,
            std::vector<Body>& state, GrowthStatistics& statistics, const Permitted& permitted = {});

  /// Whether these cells (indices, ascending) violate nothing.
  bool valid(const std::vector<std::int64_t>& cells, const std::vector<Body>& state) const;

  /// Whether the bounding spheres of two cells, both at scale 1, come nearer than `margin` [µm].
  bool near(const Body& a, const Body& b, double margin) const;

 private:
  std::vector<std::int64_t> withNeighbours(const std::vector<std::int64_t>& cells,
                                           const std::vector<Body>& state, double margin) const;

  const Physics& physics_;
  const Execution execution_;
  GrowthSettings settings_;
  std::unique_ptr<PlaneFunction> planeFunction_;
};

}  // namespace packmesh
