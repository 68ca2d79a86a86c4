// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Self-intersection test of a mesh, and of many forms of one mesh.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh {

using TrianglePair = std::pair<int, int>;

/// True if two triangles with area have common points other than the vertices and edges they share by index.
/// Exact.
bool meetBeyondShared(const std::vector<Vec3>& vertices, Triangle s, Triangle t);

/// Two triangles of `mesh` that have common points other than the vertices and edges they share by index;
/// empty if there are none. Exact. A triangle without area is returned as a pair with itself.
std::optional<TrianglePair> findSelfIntersection(const TriangleMesh& mesh);

/// Finds self-intersections of surfaces that all have the triangles of one mesh, such as the deformed cells
/// of a species. As exact as findSelfIntersection(), in a tenth of the time: what depends on the triangles
/// alone is made once.
///
/// Triangles with a common vertex are not compared with each other where the directions from the vertex,
/// seen along some axis, certainly go once around it: then they have nothing else in common. Others are
/// compared if their boxes meet.
class SelfIntersectionFinder {
 public:
  /// @param mesh of a form that is typical: its positions determine which triangles are searched together
  explicit SelfIntersectionFinder(const TriangleMesh& mesh);

  /// Two triangles that have common points other than the vertices and edges they share by index, or a
  /// triangle without area twice; empty if there are none. Safe from any thread.
  /// @param vertices in the order of the mesh [µm]
  std::optional<TrianglePair> operator()(const std::vector<Vec3>& vertices) const;

  const std::vector<Triangle>& triangles() const { return triangles_; }

  /// Triangles that are compared at a time.
  static constexpr int blockSize = 16;

 private:
  /// The triangles around a vertex.
  struct Fan {
    int begin, end;  ///< in fanTriangles_ and, if it is a ring, in ring_
    bool ring;       ///< each neighbour is followed by another one, and they are back at the first at last
  };

  /// Those triangles of a block that have a vertex in common with some triangle.
  struct Neighbours {
    int block;
    std::array<std::uint8_t, blockSize> has;
  };

  void sortIntoBlocks(int first, int count, const std::vector<Vec3>& middle);
  void findFans(std::size_t vertices);
  void findNeighbours();
  bool isFlatEnough(const Fan& fan, int vertex, const std::vector<Vec3>& vertices) const;
  std::optional<TrianglePair> inFan(const Fan& fan, const std::vector<Vec3>& vertices) const;
  std::optional<TrianglePair> apart(const std::vector<Vec3>& vertices) const;
  bool leaveOutNeighbours(int place, int block, std::uint8_t (&found)[blockSize]) const;

  std::vector<Triangle> triangles_;
  std::vector<int> order_;  ///< triangles, those of a block in succession
  std::vector<Fan> fans_;   ///< of each vertex
  std::vector<int> fanTriangles_, ring_;
  std::vector<Neighbours> neighbours_;  ///< of each triangle, in order, from firstNeighbours_ on
  std::vector<int> firstNeighbours_;
};

}  // namespace packmesh
