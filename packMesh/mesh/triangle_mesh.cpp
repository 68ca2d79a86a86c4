// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "packMesh/core/poll.h"
#include "packMesh/mesh/union_find.h"

namespace packmesh {

std::vector<TriangleSide> sortedSides(const TriangleMesh& mesh) {
  std::vector<TriangleSide> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<int>(t), a < b});
    }
  std::sort(sides.begin(), sides.end(), [](const TriangleSide& a, const TriangleSide& b) {
    return std::tie(a.lo, a.hi, a.triangle) < std::tie(b.lo, b.hi, b.triangle);
  });
  return sides;
}

double signedVolume(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return 0.0;
  // Relative to a vertex of the mesh, so that distant meshes lose no digits.
  const Vec3 origin = mesh.vertices.front();
  double six = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - origin, b = mesh.vertices[t[1]] - origin,
               c = mesh.vertices[t[2]] - origin;
    six += a.dot(b.cross(c));
  }
  return six / 6.0;
}

double surfaceArea(const TriangleMesh& mesh) {
  double two = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    two += (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
  }
  return two / 2.0;
}

std::vector<Vec3> scaledBy(double factor, std::vector<Vec3> points) {
  for (Vec3& p : points) p *= factor;
  return points;
}

Box boundingBox(const TriangleMesh& mesh) {
  Box box;
  for (const Vec3& v : mesh.vertices) box.add(v);
  return box;
}

std::vector<Vec3> placedVertices(const TriangleMesh& mesh, const Placement& placement) {
  std::vector<Vec3> out;
  out.reserve(mesh.vertices.size());
  for (const Vec3& v : mesh.vertices) out.push_back(placement(v));
  return out;
}

TriangleMesh placed(const TriangleMesh& mesh, const Placement& placement) {
  TriangleMesh out;
  out.vertices = placedVertices(mesh, placement);
  out.triangles = mesh.triangles;
  return out;
}

void flip(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

std::vector<int> mergeEqualVertices(std::vector<Vec3>& vertices) {
  const std::vector<Vec3>& v = vertices;
  std::vector<int> order(v.size()), number(v.size());
  std::iota(order.begin(), order.end(), 0);
  poll();
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    for (int k = 0; k < 3; ++k)
      if (v[i][k] != v[j][k]) return v[i][k] < v[j][k];
    return i < j;
  });
  for (std::size_t k = 0; k < order.size(); ++k)
    number[order[k]] = k > 0 && v[order[k]] == v[order[k - 1]] ? number[order[k - 1]] : order[k];
  std::vector<Vec3> kept;
  for (std::size_t i = 0; i < v.size(); ++i) {
    if (number[i] == static_cast<int>(i)) {
      number[i] = static_cast<int>(kept.size());
      kept.push_back(v[i]);
    } else {
      number[i] = number[number[i]];  // its first occurrence is earlier and already has its final number
    }
  }
  vertices = std::move(kept);
  return number;
}

namespace {

/// A cube of a grid so fine that points in one cube are near each other.
struct Cube {
  std::array<double, 3> at;  ///< whole numbers
  bool operator==(const Cube& other) const { return at == other.at; }
};
struct HashOfCube {
  std::size_t operator()(const Cube& cube) const {
    std::size_t hash = 0;
    for (const double x : cube.at)
      hash = 0x9e3779b97f4a7c15u * (hash ^ std::hash<double>()(x)) + (hash >> 29);
    return hash;
  }
};

/// Offsets to one of any two cubes with points near each other.
std::vector<std::array<int, 3>> offsetsOfCubes() {
  std::vector<std::array<int, 3>> offsets;
  for (int i = -2; i <= 2; ++i)
    for (int j = -2; j <= 2; ++j)
      for (int k = -2; k <= 2; ++k)
        if (std::array<int, 3>{i, j, k} > std::array<int, 3>{}) offsets.push_back({i, j, k});
  return offsets;
}

}  // namespace

std::size_t mergeEqualVertices(TriangleMesh& mesh) {
  const std::size_t before = mesh.vertices.size();
  const std::vector<int> number = mergeEqualVertices(mesh.vertices);
  for (Triangle& triangle : mesh.triangles)
    for (int& corner : triangle) corner = number[corner];
  return before - mesh.vertices.size();
}

std::vector<int> firstOfNearVertices(const std::vector<Vec3>& vertices, double distance) {
  UnionFind sets(vertices.size());
  std::vector<int> first(vertices.size());
  if (distance > 0.0) {
    constexpr double safely = 0.999;  // rounding
    const double edge = safely * distance / std::sqrt(3.0);
    std::unordered_map<Cube, std::vector<int>, HashOfCube> cubes;
    const auto cubeOf = [&](const Vec3& v) {
      return Cube{{std::floor(v.x() / edge), std::floor(v.y() / edge), std::floor(v.z() / edge)}};
    };
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      std::vector<int>& inCube = cubes[cubeOf(vertices[v])];
      if (!inCube.empty()) sets.join(inCube.front(), static_cast<int>(v));
      inCube.push_back(static_cast<int>(v));
    }
    // Dense cubes that are not near each other would have to be compared point by point.
    constexpr std::size_t comparisonsPerVertex = 1000;
    std::size_t left = comparisonsPerVertex * (vertices.size() + comparisonsPerVertex);
    const auto areNear = [&](const std::vector<int>& some, const std::vector<int>& others) {
      for (const int v : some)
        for (const int w : others) {
          if (left == 0) return false;
          pollAt(--left);
          if ((vertices[v] - vertices[w]).squaredNorm() < distance * distance) return true;
        }
      return false;
    };
    const std::vector<std::array<int, 3>> offsets = offsetsOfCubes();
    for (const auto& [cube, inCube] : cubes)
      for (const std::array<int, 3>& offset : offsets) {
        const auto other =
            cubes.find({{cube.at[0] + offset[0], cube.at[1] + offset[1], cube.at[2] + offset[2]}});
        if (other == cubes.end()) continue;
        const int v = inCube.front(), w = other->second.front();
        if (sets.first(v) != sets.first(w) && areNear(inCube, other->second)) sets.join(v, w);
      }
  }
  for (std::size_t v = 0; v < first.size(); ++v) first[v] = sets.first(static_cast<int>(v));
  return first;
}

std::size_t removeUnusedVertices(TriangleMesh& mesh) {
  std::vector<int> number(mesh.vertices.size(), -1);
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) number[v] = 0;
  int kept = 0;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] == 0) {
      mesh.vertices[kept] = mesh.vertices[v];
      number[v] = kept++;
    }
  const std::size_t removed = mesh.vertices.size() - kept;
  mesh.vertices.resize(kept);
  for (Triangle& t : mesh.triangles)
    for (int& v : t) v = number[v];
  return removed;
}

std::string coordinateFault(const Vec3& v) {
  if (!v.allFinite()) return " has a coordinate that is not a finite number";
  int axis = 0;
  if (v.cwiseAbs().maxCoeff(&axis) <= tolerance::largestCoordinate) return {};
  return std::string(" has the coordinate ") + axisName[axis] + " = " + toText(v[axis], 3) + ", at most " +
         toText(tolerance::largestCoordinate, 3) + " is possible; is the file damaged?";
}

}  // namespace packmesh
