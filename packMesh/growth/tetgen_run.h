// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file One run of the TetGen library (H. Si, "TetGen, a Delaunay-based quality tetrahedral mesh generator",
/// ACM Trans. Math. Softw. 41(2), 2015). Internal to packMesh/growth.
///
/// TetGen keeps global state: one run at a time in a process.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

using Tetrahedron = std::array<int, 4>;

struct TetgenInput {
  std::vector<Vec3> points;         ///< [µm]
  std::vector<Triangle> triangles;  ///< to be respected; empty: Delaunay tetrahedra of the points
  std::vector<int> triangleLabels;  ///< per triangle, positive
  bool keepHull = false;  ///< keep what lies outside all closed surfaces, too, up to the convex hull
  bool regions = false;   ///< number the regions bounded by the triangles
  bool subfaces = false;  ///< list the triangles as subdivided
};

struct TetgenOutput {
  std::vector<Vec3> points;             ///< those given, unchanged, then Steiner points
  std::vector<int> steinerLabels;       ///< of the triangle each Steiner point lies on, 0: on none
  std::vector<Tetrahedron> tetrahedra;  ///< of positive volume: (b-a)x(c-a)·(d-a) > 0
  std::vector<int> regions;             ///< per tetrahedron, if requested; 0: outside all surfaces
  std::vector<Triangle> subfaces;       ///< if requested; in either orientation
  std::vector<int> subfaceLabels;
};

/// Describes why TetGen gave up, if it did.
struct TetgenFailure {
  static constexpr int unknown = 2, badInput = 10, stopped = 12;
  int code = 0;       ///< 0: no failure
  std::string words;  ///< what TetGen printed
  std::string text() const;
};

/// @param variant ways to process difficult input: 0 the fastest, up to tetgenVariants - 1
/// @param failure set if TetGen gives up; the output is then empty
/// @param stop polled while TetGen runs, which is then done in a child process that can be ended; true ends
///   it. Empty: TetGen runs in this process
/// Pre: triangles intersect in common vertices and edges only. On other input TetGen 1.5 may throw, abort or
/// never return.
TetgenOutput runTetgen(const TetgenInput& input, int variant, TetgenFailure& failure,
                       const std::function<bool()>& stop = {});

inline constexpr int tetgenVariants = 3;

}  // namespace packmesh
