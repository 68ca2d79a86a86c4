// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth of a few cells among many.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "packMesh/growth/growth.h"

namespace packmesh {

/// Constructs a plane function for the cells that take part.
using PlaneFunctionFactory = std::function<std::unique_ptr<PlaneFunction>(const GrowthScene&)>;

/// Growth of some cells of a state to scale 1, up to the surfaces of their neighbours, as in CDT cells: all
/// other cells stay fixed. The cost is that of the cells near them.
class LocalGrowth {
 public:
  /// References the scene and settings, which must outlive this. There is no relaxation at barriers, since it
  /// would move all cells. Only the last barrier is used.
  LocalGrowth(const GrowthScene& scene, const GrowthSettings& settings, const PlaneFunctionFactory& factory);

  /// @param growing indices into the state, ascending
  /// @param state free of overlap; also on return, with no cell smaller than before
  /// @return whether all of `growing` reached scale 1
  bool grow(const std::vector<std::int64_t>& growing, const std::function<bool()>& stop,
            std::vector<Body>& state, GrowthStatistics& statistics);

  /// The cells whose bounding spheres, all at scale 1, come nearer than `margin` [µm] to those of `cells`,
  /// excluding these; ascending.
  std::vector<std::int64_t> neighboursOf(const std::vector<std::int64_t>& cells,
                                         const std::vector<Body>& state, double margin) const;

 private:
  GrowthScene scene_;
  GrowthSettings settings_;
  std::unique_ptr<PlaneFunction> planeFunction_;
};

}  // namespace packmesh
