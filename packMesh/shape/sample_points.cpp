// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/sample_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace packmesh {
namespace {

int divisions(const Vec3& a, const Vec3& b, double spacing) {
  return std::max(1, static_cast<int>(std::ceil((b - a).norm() / spacing)));
}

std::vector<Vec3> pointsOn(const TriangleMesh& mesh, double spacing) {
  std::vector<Vec3> points = mesh.vertices;
  std::map<std::pair<int, int>, bool> seen;
  for (const Triangle& t : mesh.triangles) {
    int most = 1;
    for (int k = 0; k < 3; ++k) {
      const int a = std::min(t[k], t[(k + 1) % 3]), b = std::max(t[k], t[(k + 1) % 3]);
      const int n = divisions(mesh.vertices[a], mesh.vertices[b], spacing);
      most = std::max(most, n);
      if (std::exchange(seen[{a, b}], true)) continue;
      for (int i = 1; i < n; ++i)
        points.push_back(mesh.vertices[a] + (mesh.vertices[b] - mesh.vertices[a]) * (double(i) / n));
    }
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    for (int i = 1; i < most; ++i)
      for (int j = 1; i + j < most; ++j)
        points.push_back(a + (b - a) * (double(i) / most) + (c - a) * (double(j) / most));
  }
  return points;
}

/// Divides [first, last) along its longest axis into the fewest clusters that can hold it, with sizes that
/// differ by at most one point, so that padding gives no point much more weight than others.
void cluster(std::vector<Vec3>::iterator first, std::vector<Vec3>::iterator last, SamplePoints& out) {
  const auto count = last - first;
  if (count <= SamplePoints::width) {
    for (int k = 0; k < SamplePoints::width; ++k) {
      const Vec3& p = first[k % count];
      out.x.push_back(static_cast<float>(p.x()));
      out.y.push_back(static_cast<float>(p.y()));
      out.z.push_back(static_cast<float>(p.z()));
    }
    Box box;
    for (auto p = first; p != last; ++p) box.add(*p);
    const Vec3 center = box.center().cast<float>().cast<double>();
    double radius = 0.0;
    for (auto p = first; p != last; ++p)
      radius = std::max(radius, (p->cast<float>().cast<double>() - center).norm());
    out.centerX.push_back(static_cast<float>(center.x()));
    out.centerY.push_back(static_cast<float>(center.y()));
    out.centerZ.push_back(static_cast<float>(center.z()));
    out.radius.push_back(static_cast<float>(radius * (1.0 + 1e-6)));  // covers rounding to float
    ++out.clusters;
    return;
  }
  Box box;
  for (auto p = first; p != last; ++p) box.add(*p);
  int axis = 0;
  box.size().maxCoeff(&axis);
  const auto clusters = (count + SamplePoints::width - 1) / SamplePoints::width;
  const auto middle = first + count * (clusters / 2) / clusters;
  const auto before = [axis](const Vec3& p, const Vec3& q) {
    return std::make_tuple(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) <
           std::make_tuple(q[axis], q[(axis + 1) % 3], q[(axis + 2) % 3]);
  };
  std::sort(first, last, before);
  cluster(first, middle, out);
  cluster(middle, last, out);
}

SamplePoints clustered(std::vector<Vec3> points) {
  SamplePoints out;
  if (points.empty()) return out;
  cluster(points.begin(), points.end(), out);
  while (out.centerX.size() % SamplePoints::width != 0) {
    out.centerX.push_back(out.centerX.back());
    out.centerY.push_back(out.centerY.back());
    out.centerZ.push_back(out.centerZ.back());
    out.radius.push_back(out.radius.back());
  }
  return out;
}

}  // namespace

SamplePoints sampleSurface(const TriangleMesh& mesh, double spacing) {
  return clustered(pointsOn(mesh, spacing));
}

SamplePoints sampleCoarsely(const TriangleMesh& mesh) {
  // Farthest-point sampling (Gonzalez 1985).
  const std::size_t wanted = std::min<std::size_t>(
      mesh.vertices.size(), std::max<std::size_t>(2 * SamplePoints::width, mesh.vertices.size() / 4));
  std::vector<double> distance(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  std::vector<Vec3> chosen;
  std::size_t next = 0;
  while (chosen.size() < wanted) {
    const Vec3 p = mesh.vertices[next];
    chosen.push_back(p);
    for (std::size_t i = 0; i < distance.size(); ++i)
      distance[i] = std::min(distance[i], (mesh.vertices[i] - p).squaredNorm());
    next = std::max_element(distance.begin(), distance.end()) - distance.begin();
  }
  return clustered(std::move(chosen));
}

}  // namespace packmesh
