// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/mesh/merge_vertices.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace packmesh {

std::vector<int> mergeEqualVertices(std::vector<Vec3>& vertices) {
  const std::vector<Vec3>& v = vertices;
  std::vector<int> order(v.size()), number(v.size());
  std::iota(order.begin(), order.end(), 0);
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

std::vector<int> firstOfNearVertices(const std::vector<Vec3>& vertices, double distance) {
  std::vector<int> order(vertices.size()), first(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::iota(first.begin(), first.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    return vertices[i].x() != vertices[j].x() ? vertices[i].x() < vertices[j].x() : i < j;
  });
  const auto root = [&](int i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  for (std::size_t k = 0; k < order.size(); ++k)
    for (std::size_t l = k + 1; l < order.size(); ++l) {
      const Vec3 step = vertices[order[l]] - vertices[order[k]];
      if (step.x() >= distance) break;
      if (step.squaredNorm() >= distance * distance) continue;
      const int a = root(order[k]), b = root(order[l]);
      first[std::max(a, b)] = std::min(a, b);
    }
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = root(static_cast<int>(i));
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

}  // namespace packmesh
