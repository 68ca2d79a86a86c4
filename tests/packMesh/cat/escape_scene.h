// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A packing of several blocks from which escapes gain coverage.
#pragma once

#include <memory>
#include <vector>

#include "packMesh/cat/cat_face_planes.h"
#include "packMesh/cat/escape.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/random.h"
#include "tests/support/bodies.h"
#include "tests/support/physics.h"

namespace packmesh::test {

/// A long periodic box with spheres of three radii on a lattice, with vacancies; many are below full size,
/// and the large ones do not fit everywhere.
struct LongBox {
  static constexpr double spacing = 1.2;
  static constexpr int sites = 12, across = 3;

  Physics physics = physicsOf(
      {sphereShape(0.5), sphereShape(0.3), sphereShape(0.8)},
      makeBox(Box{Vec3::Zero(), Vec3(sites* spacing, across* spacing, across* spacing)}, {true, true, true}));
  Execution execution;
  std::vector<Body> state;
  TetrahedraSums tetrahedra;

  LongBox() {
    for (int site = 0; site < sites * across * across; ++site) {
      if (site % 7 == 3) continue;
      const int species = site % 7 == 1 ? 1 : site % 7 == 4 ? 2 : 0;
      const double scale = species == 2 ? 0.4 : site % 3 == 0 ? 0.5 : 1.0;
      // Slightly irregular: TetGen takes long for points on common spheres.
      const auto u = uniform4(1, RandomStream::sample, std::uint64_t(site), 0);
      const Vec3 at(site / (across * across), site / across % across, site % across);
      const Vec3 aside(u[0] - 0.5, u[1] - 0.5, u[2] - 0.5);
      state.push_back(makeBody(std::int64_t(state.size()), species, species,
                               Pose{scale, uniformRotation(u[1], u[2], u[3]),
                                    spacing * (at + Vec3::Constant(0.5)) + 0.1 * aside}));
    }
  }

  std::vector<EscapePhase> escapeFrom(std::vector<Body>& own,
                                      const std::function<void(const std::vector<Body>&)>& observe = {}) {
    EscapeSettings settings;
    settings.reserve = {6, 3, 0};
    settings.orientations = 1;
    const PlaneFunctionFactory factory = [this] {
      return makePlaneFunction(PlaneSource::chords, physics, execution, tetrahedra);
    };
    return escape(physics, execution, GrowthSettings(), settings, factory, {}, observe, own);
  }
};

}  // namespace packmesh::test
