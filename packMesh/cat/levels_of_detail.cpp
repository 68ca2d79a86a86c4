// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/levels_of_detail.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "packMesh/mesh/self_intersection.h"

namespace packmesh {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
  VertexAttributes(OpenMesh::Attributes::Status);
  EdgeAttributes(OpenMesh::Attributes::Status);
  FaceAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::Normal);
  HalfedgeAttributes(OpenMesh::Attributes::Status | OpenMesh::Attributes::PrevHalfedge);
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;

HalfedgeMesh toHalfedges(const TriangleMesh& mesh) {
  HalfedgeMesh out;
  std::vector<HalfedgeMesh::VertexHandle> handles;
  for (const Vec3& v : mesh.vertices) handles.push_back(out.add_vertex({v.x(), v.y(), v.z()}));
  for (const Triangle& t : mesh.triangles) out.add_face(handles[t[0]], handles[t[1]], handles[t[2]]);
  return out;
}

TriangleMesh fromHalfedges(const HalfedgeMesh& mesh) {
  TriangleMesh out;
  for (const auto v : mesh.vertices()) {
    const OpenMesh::Vec3d& p = mesh.point(v);
    out.vertices.emplace_back(p[0], p[1], p[2]);
  }
  for (const auto f : mesh.faces()) {
    Triangle t;
    int k = 0;
    for (auto v = mesh.cfv_iter(f); v.is_valid(); ++v) t[k++] = v->idx();
    out.triangles.push_back(t);
  }
  return out;
}

/// The neighbours of each vertex in cyclic order; empty if the mesh is not closed there.
std::vector<std::vector<int>> ringsOf(const TriangleMesh& mesh) {
  std::vector<std::map<int, int>> next(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) next[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
  std::vector<std::vector<int>> rings(mesh.vertices.size());
  for (std::size_t v = 0; v < rings.size(); ++v) {
    if (next[v].empty()) continue;
    const int first = next[v].begin()->first;
    int at = first;
    do {
      rings[v].push_back(at);
      const auto following = next[v].find(at);
      at = following == next[v].end() ? -1 : following->second;
    } while (at != first && at >= 0 && rings[v].size() <= next[v].size());
    if (at != first) rings[v].clear();
  }
  return rings;
}

}  // namespace

double resamplingFactor(double progress, double alpha, double beta) {
  const double k = std::clamp(progress, 0.0, 1.0);
  return std::min(1.0, alpha * std::pow((1.0 - k) + std::pow(alpha, 1.0 / beta), -beta));
}

std::optional<TriangleMesh> unrefined(const TriangleMesh& mesh) {
  // Refinement keeps the degree of old vertices, which may differ from six, and adds vertices of degree six
  // at the midpoints of edges: two steps straight ahead from an old vertex lead to another old one.
  const std::vector<std::vector<int>> rings = ringsOf(mesh);
  std::vector<int> number(mesh.vertices.size(), -1), queue;
  TriangleMesh coarse;
  const auto keep = [&](int v) {
    if (number[v] >= 0) return;
    number[v] = static_cast<int>(coarse.vertices.size());
    coarse.vertices.push_back(mesh.vertices[v]);
    queue.push_back(v);
  };
  std::map<int, std::pair<int, int>> ends;  // ends of the old edge, by the vertex at its midpoint
  for (std::size_t v = 0; v < rings.size(); ++v) {
    if (rings[v].empty()) return {};
    if (rings[v].size() != 6) keep(static_cast<int>(v));
  }
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const int v = queue[i];
    for (const int middle : rings[v]) {
      const std::vector<int>& ring = rings[middle];
      if (ring.size() != 6) return {};
      const auto here = std::find(ring.begin(), ring.end(), v) - ring.begin();
      const int beyond = ring[(here + 3) % 6];
      keep(beyond);
      ends[middle] = {std::min(v, beyond), std::max(v, beyond)};
    }
  }
  if (coarse.vertices.empty() || coarse.vertices.size() + ends.size() != mesh.vertices.size()) return {};
  for (const Triangle& t : mesh.triangles) {
    int old = 0;
    for (const int v : t) {
      old += number[v] >= 0;
      if ((number[v] >= 0) == (ends.count(v) > 0)) return {};  // both old and a midpoint, or neither
    }
    if (old > 1) return {};
    if (old == 1) continue;  // at a corner of an old triangle
    // The central one: each old vertex is shared by two of the three old edges.
    Triangle triangle;
    for (int k = 0; k < 3; ++k) {
      const std::pair<int, int>&before = ends[t[(k + 2) % 3]], &after = ends[t[k]];
      const int shared =
          before.first == after.first || before.first == after.second ? before.first : before.second;
      if (shared != after.first && shared != after.second) return {};
      triangle[k] = number[shared];
    }
    coarse.triangles.push_back(triangle);
  }
  if (4 * coarse.triangles.size() != mesh.triangles.size()) return {};
  return coarse;
}

TriangleMesh decimated(const TriangleMesh& mesh, int vertices) {
  HalfedgeMesh halfedges = toHalfedges(mesh);
  OpenMesh::Decimater::DecimaterT<HalfedgeMesh> decimater(halfedges);
  OpenMesh::Decimater::ModQuadricT<HalfedgeMesh>::Handle quadric;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
  halfedges.update_face_normals();
  decimater.initialize();
  decimater.decimate_to(static_cast<std::size_t>(vertices));
  halfedges.garbage_collection();
  return fromHalfedges(halfedges);
}

namespace {

constexpr std::size_t fewestVertices = 40;
constexpr double levelFactor = 4.0;

}  // namespace

LevelsOfDetail::LevelsOfDetail(const TriangleMesh& mesh) : meshes_{mesh} {
  for (;;) {
    const TriangleMesh& last = meshes_.back();
    const auto wanted = static_cast<int>(static_cast<double>(last.vertices.size()) / levelFactor);
    if (static_cast<std::size_t>(wanted) + 2 < fewestVertices) break;
    std::optional<TriangleMesh> coarser = unrefined(last);
    if (!coarser) coarser = decimated(last, wanted);
    const bool useful = coarser->vertices.size() >= fewestVertices &&
                        2 * coarser->vertices.size() < last.vertices.size() &&
                        !findSelfIntersection(*coarser);
    if (!useful) break;
    meshes_.push_back(std::move(*coarser));
  }
}

int LevelsOfDetail::indexOf(double share) const {
  int best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count(); ++i) {
    const double has = static_cast<double>(meshes_[i].vertices.size()) / meshes_[0].vertices.size();
    const double off = std::abs(std::log(has / std::max(share, 1e-6)));  // finite for 0
    if (off < least) {
      least = off;
      best = i;
    }
  }
  return best;
}

}  // namespace packmesh
