// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Closed meshes made for tests.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::sample {

inline void append(TriangleMesh& mesh, const TriangleMesh& other) {
  const int n = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
}

inline TriangleMesh box(const Vec3& lo, const Vec3& hi) {
  TriangleMesh mesh;
  for (int c = 0; c < 8; ++c)
    mesh.vertices.emplace_back(c & 1 ? hi.x() : lo.x(), c & 2 ? hi.y() : lo.y(), c & 4 ? hi.z() : lo.z());
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// Rings of `sides` vertices joined to a closed surface; the ends are closed by fans around their middles.
inline TriangleMesh sweep(const std::vector<std::vector<Vec3>>& rings) {
  TriangleMesh mesh;
  const int sides = int(rings[0].size()), count = int(rings.size());
  for (const std::vector<Vec3>& ring : rings)
    mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  for (int r = 0; r + 1 < count; ++r)
    for (int k = 0; k < sides; ++k) {
      const int a = r * sides + k, b = r * sides + (k + 1) % sides, c = a + sides, d = b + sides;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({b, d, c});
    }
  for (const int r : {0, count - 1}) {
    Vec3 middle = Vec3::Zero();
    for (const Vec3& v : rings[r]) middle += v / sides;
    const int m = int(mesh.vertices.size());
    mesh.vertices.push_back(middle);
    for (int k = 0; k < sides; ++k) {
      const int a = r * sides + k, b = r * sides + (k + 1) % sides;
      mesh.triangles.push_back(r == 0 ? Triangle{m, b, a} : Triangle{m, a, b});
    }
  }
  if (signedVolume(mesh) < 0.0) flip(mesh);
  return mesh;
}

/// Tube along x from x0 to x1 whose middle line and radius are functions of x; all rings are planes x =
/// constant.
inline TriangleMesh tube(double x0, double x1, int rings, int sides,
                         const std::function<Vec3(double)>& middle,
                         const std::function<double(double)>& radius) {
  std::vector<std::vector<Vec3>> all(rings);
  for (int r = 0; r < rings; ++r) {
    const double x = r + 1 == rings ? x1 : x0 + (x1 - x0) * r / (rings - 1);
    for (int k = 0; k < sides; ++k) {
      const double angle = 2.0 * M_PI * k / sides;
      const Vec3 m = middle(x);
      all[r].emplace_back(x, m.y() + radius(x) * std::cos(angle), m.z() + radius(x) * std::sin(angle));
    }
  }
  return sweep(all);
}

inline TriangleMesh straightTube(double x0, double x1, double radius, int rings, int sides) {
  return tube(
      x0, x1, rings, sides, [](double x) { return Vec3(x, 0.0, 0.0); }, [&](double) { return radius; });
}

/// Sphere of rings and sides, with vertices on the sphere of the given radius.
inline TriangleMesh sphere(const Vec3& center, double radius, int rings, int sides) {
  TriangleMesh mesh;
  mesh.vertices.push_back(center + Vec3(0, 0, radius));
  for (int r = 1; r < rings; ++r)
    for (int k = 0; k < sides; ++k) {
      const double theta = M_PI * r / rings, phi = 2.0 * M_PI * (k + 0.5 * (r % 2)) / sides;
      mesh.vertices.push_back(center + radius * Vec3(std::sin(theta) * std::cos(phi),
                                                     std::sin(theta) * std::sin(phi), std::cos(theta)));
    }
  mesh.vertices.push_back(center - Vec3(0, 0, radius));
  const int south = int(mesh.vertices.size()) - 1;
  for (int k = 0; k < sides; ++k) {
    const int next = (k + 1) % sides;
    mesh.triangles.push_back({0, 1 + k, 1 + next});
    mesh.triangles.push_back({south, south - sides + next, south - sides + k});
    for (int r = 1; r + 1 < rings; ++r) {
      const int a = 1 + (r - 1) * sides + k, b = 1 + (r - 1) * sides + next, c = a + sides, d = b + sides;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({b, c, d});
    }
  }
  return mesh;
}

/// Torus around z.
inline TriangleMesh torus(const Vec3& center, double ringRadius, double tubeRadius, int around, int across) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2.0 * M_PI * i / around, v = 2.0 * M_PI * j / across;
      const double s = ringRadius + tubeRadius * std::cos(v);
      mesh.vertices.push_back(center + Vec3(s * std::cos(u), s * std::sin(u), tubeRadius * std::sin(v)));
    }
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const int a = i * across + j, b = ((i + 1) % around) * across + j;
      const int c = i * across + (j + 1) % across, d = ((i + 1) % around) * across + (j + 1) % across;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({b, d, c});
    }
  return mesh;
}

/// Surface of all unit cubes (i,j,k) in [0,n)³ for which `filled` is true, times `size`.
inline TriangleMesh voxels(int n, double size, const std::function<bool(int, int, int)>& filled) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> number;
  const auto in = [&](std::array<int, 3> c) {
    for (const int x : c)
      if (x < 0 || x >= n) return false;
    return filled(c[0], c[1], c[2]);
  };
  const auto vertex = [&](std::array<int, 3> c) {
    const auto [entry, isNew] = number.insert({c, int(mesh.vertices.size())});
    if (isNew) mesh.vertices.push_back(size * Vec3(c[0], c[1], c[2]));
    return entry->second;
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        if (!in({i, j, k})) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (int up = 0; up < 2; ++up) {
            std::array<int, 3> beyond{i, j, k};
            beyond[axis] += up ? 1 : -1;
            if (in(beyond)) continue;
            int quad[4];
            for (int c = 0; c < 4; ++c) {
              std::array<int, 3> corner{i, j, k};
              corner[axis] += up;
              corner[(axis + 1) % 3] += c == 1 || c == 2;
              corner[(axis + 2) % 3] += c >= 2;
              quad[c] = vertex(corner);
            }
            if (!up) std::swap(quad[1], quad[3]);
            mesh.triangles.push_back({quad[0], quad[1], quad[2]});
            mesh.triangles.push_back({quad[0], quad[2], quad[3]});
          }
      }
  return mesh;
}

/// The same mesh somewhere else.
inline TriangleMesh moved(TriangleMesh mesh, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v += by;
  return mesh;
}

}  // namespace packmesh::sample
