// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/contact_lists.h"

#include "packMesh/mesh/closest_point.h"
#include "tests/packMesh/soft/soft_meshes.h"
#include "tests/support/catch.h"

namespace packmesh {
namespace {

using Fours = std::set<std::array<int, 4>>;

struct Listed {
  Membrane membrane;
  Clusters clusters;
  Outline outline;
  std::vector<float> positions;
  std::vector<Vec3f> normals;

  explicit Listed(const TriangleMesh& mesh) : membrane(mesh, {}), clusters(membrane) {
    for (const Vec3& v : mesh.vertices)
      positions.insert(positions.end(), {float(v.x()), float(v.y()), float(v.z()), 0.0f});
    findNormals(membrane, positions.data(), normals);
    outline.fit(clusters, positions.data(), normals);
  }
  ListedCell cell() const { return {&clusters, &outline, positions.data(), &normals}; }
};

Fours listed(const Listed& a, const Listed& b, ContactKind kind, const std::array<float, 3>& offset,
             float limit, bool same) {
  const ContactKernels kernels = proximityKernels(chosenInstructionSet());
  ContactLister lister(kernels);
  ContactFours out;
  const int found = lister.list(kind, a.cell(), b.cell(), offset.data(), limit, same, out);
  CHECK(out.size() == found);
  Fours fours;
  for (int n = 0; n < found; ++n) {
    const VertexFours& block = out.blocks()[n / 16];
    fours.insert({block[0][n % 16], block[1][n % 16], block[2][n % 16], block[3][n % 16]});
  }
  CHECK(int(fours.size()) == found);  // none twice
  return fours;
}

TEST_CASE("lists of contacts have every vertex that is near a triangle, and no other", "[soft]") {
  const Listed a(sample::redCell(3)), b(sample::redCell(2));
  const std::array<float, 3> offset = {0.5f, 1.6f, 1.0f};
  constexpr double limit = 0.3, rounding = 1e-5;
  const Fours found = listed(a, b, ContactKind::vertexTriangle, offset, float(limit), false);
  TriangleMesh there = b.membrane.mesh();
  for (Vec3& v : there.vertices) v += Vec3(offset[0], offset[1], offset[2]);
  const ClosestPoint closest(there);
  std::size_t expected = 0;
  for (int v = 0; v < int(a.membrane.mesh().vertices.size()); ++v)
    for (int t = 0; t < int(there.triangles.size()); ++t) {
      const double distance = closest.onTriangle(t, a.membrane.mesh().vertices[v]).distance;
      if (std::abs(distance - limit) < rounding) continue;
      const auto& [p, q, r] = there.triangles[t];
      expected += distance < limit;
      CHECK(found.count({v, p, q, r}) == (distance < limit ? 1u : 0u));
    }
  CHECK(expected > 100);
}

/// An upper bound of the distance of two edges.
double edgesApart(const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
  double nearest = 1e9;
  for (int m = 0; m <= 8; ++m)
    for (int n = 0; n <= 8; ++n)
      nearest = std::min(nearest, (p + m / 8.0 * (q - p) - r - n / 8.0 * (s - r)).norm());
  return nearest;
}

TEST_CASE("lists of pairs of edges have every pair of which sampled points are near", "[soft]") {
  const Listed a(sample::redCell(2)), b(sample::redCell(2));
  const std::array<float, 3> offset = {0.4f, 1.5f, 0.9f};
  const Fours found = listed(a, b, ContactKind::edgeEdge, offset, 0.4f, false);
  const auto& x = a.membrane.mesh().vertices;
  const Vec3 shift(offset[0], offset[1], offset[2]);
  std::size_t expected = 0;
  for (const auto& [p, q] : a.membrane.edges())
    for (const auto& [r, s] : b.membrane.edges()) {
      if (edgesApart(x[p], x[q], x[r] + shift, x[s] + shift) >= 0.4) continue;
      ++expected;
      CHECK(found.count({p, q, r, s}) == 1);
    }
  CHECK(expected > 50);
  CHECK(found.size() < 2 * expected);
}

TEST_CASE("a cell's contacts with itself are between pieces that face each other", "[soft]") {
  // At rest a red cell is nowhere near itself.
  const Listed rest(sample::redCell(3));
  for (const ContactKind kind : {ContactKind::vertexTriangle, ContactKind::edgeEdge})
    CHECK(listed(rest, rest, kind, {0.0f, 0.0f, 0.0f}, 0.3f, true).empty());
  // Pressed flat, its two sides are; on the rim, where it is folded, so are neighbours.
  TriangleMesh flat = sample::redCell(3);
  for (Vec3& v : flat.vertices) v.y() *= 0.2;
  const Listed pressed(flat);
  for (const ContactKind kind : {ContactKind::vertexTriangle, ContactKind::edgeEdge}) {
    const Fours found = listed(pressed, pressed, kind, {0.0f, 0.0f, 0.0f}, 0.3f, true);
    CHECK(found.size() > 300);
    std::size_t across = 0;
    for (const auto& four : found) {
      CHECK(std::set<int>(four.begin(), four.end()).size() == 4);
      across += flat.vertices[four[0]].y() * flat.vertices[four[3]].y() < 0.0;
    }
    CHECK(across > found.size() / 2);
  }
}

TEST_CASE("where a membrane is folded, all of its pieces that are near are contacts", "[soft]") {
  TriangleMesh flat = sample::redCell(3);
  for (Vec3& v : flat.vertices) v.y() *= 0.2;
  for (std::size_t v = 0; v < flat.vertices.size(); v += 37) flat.vertices[v].y() -= 0.4;  // spikes
  const Listed pressed(flat);
  const auto isFolded = [&](int v) { return pressed.normals[v].isZero(0.0f); };
  constexpr double limit = 0.3, rounding = 1e-5;
  const Fours triangles =
      listed(pressed, pressed, ContactKind::vertexTriangle, {0.0f, 0.0f, 0.0f}, float(limit), true);
  const Fours edges = listed(pressed, pressed, ContactKind::edgeEdge, {0.0f, 0.0f, 0.0f}, float(limit), true);
  const std::vector<Vec3>& x = flat.vertices;
  const ClosestPoint closest(flat);
  std::size_t near = 0;
  for (int v = 0; v < int(x.size()); ++v)
    for (int t = 0; t < int(flat.triangles.size()); ++t) {
      const auto& [p, q, r] = flat.triangles[t];
      if (!isFolded(v) || v == p || v == q || v == r) continue;
      if (closest.onTriangle(t, x[v]).distance >= limit - rounding) continue;
      ++near;
      CHECK(triangles.count({v, p, q, r}) == 1);
    }
  for (const auto& [p, q] : pressed.membrane.edges())
    for (const auto& [r, s] : pressed.membrane.edges()) {
      if (!isFolded(p) || std::set<int>{p, q, r, s}.size() < 4) continue;
      if (edgesApart(x[p], x[q], x[r], x[s]) >= limit - rounding) continue;
      ++near;
      CHECK(edges.count({p, q, r, s}) + edges.count({r, s, p, q}) == 1);
    }
  CHECK(near > 500);
}

}  // namespace
}  // namespace packmesh
