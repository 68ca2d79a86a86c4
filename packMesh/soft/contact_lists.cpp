// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/contact_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <type_traits>
#include <utility>

namespace packmesh {
namespace {

constexpr int blockSize = ContactFours::width;
constexpr float none[3] = {0.0f, 0.0f, 0.0f};

/// Sorts items[begin, end) so that each sixteen are near each other: halves along the longest side.
void arrange(std::vector<int>& items, const std::vector<Vec3>& centers, std::size_t begin, std::size_t end) {
  if (end - begin <= std::size_t(blockSize)) {
    std::sort(items.begin() + std::ptrdiff_t(begin), items.begin() + std::ptrdiff_t(end));
    return;
  }
  Box box;
  for (std::size_t k = begin; k < end; ++k) box.add(centers[items[k]]);
  int axis;
  box.size().maxCoeff(&axis);
  const std::size_t groups = (end - begin + blockSize - 1) / blockSize,
                    middle = begin + groups / 2 * blockSize;
  std::nth_element(items.begin() + std::ptrdiff_t(begin), items.begin() + std::ptrdiff_t(middle),
                   items.begin() + std::ptrdiff_t(end), [&](int a, int b) {
                     return std::pair(centers[a][axis], a) < std::pair(centers[b][axis], b);
                   });
  arrange(items, centers, begin, middle);
  arrange(items, centers, middle, end);
}

template <int corners, class Corners>
Clusters::Group<corners> groupsOf(std::size_t count, const std::vector<Vec3>& vertices,
                                  const Corners& cornersOf) {
  std::vector<Vec3> centers(count, Vec3::Zero());
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < corners; ++c) centers[i] += vertices[cornersOf(int(i), c)] / double(corners);
  std::vector<int> items(count);
  std::iota(items.begin(), items.end(), 0);
  arrange(items, centers, 0, count);
  Clusters::Group<corners> out;
  for (std::size_t begin = 0; begin < count; begin += blockSize) {
    out.counts.push_back(int(std::min<std::size_t>(blockSize, count - begin)));
    std::array<std::array<std::int16_t, blockSize>, corners> block{};
    for (int k = 0; k < out.counts.back(); ++k)
      for (int c = 0; c < corners; ++c) block[c][k] = std::int16_t(cornersOf(items[begin + k], c));
    out.blocks.push_back(block);
  }
  return out;
}

/// Product of the normal of a vertex with those of its triangles below which the membrane is folded.
constexpr float foldedBelow = 0.7f;
constexpr float tiny = 1e-20f;  // far below rounding; what has no normal keeps none

template <int corners>
void fitTo(const Clusters::Group<corners>& group, const float* positions, const std::vector<Vec3f>& normals,
           Outline::Boxes& boxes) {
  boxes.cones.resize(group.blocks.size());
  boxes.sixteen.resize((boxes.clusters() + blockSize - 1) / blockSize);
  boxes.blocks.resize(boxes.sixteen.size());
  for (FloatBox& box : boxes.sixteen) box.reset();
  std::vector<Vec3f> ofCluster;
  for (std::size_t b = 0; b < blockSize * boxes.blocks.size(); ++b) {
    FloatBox box;
    box.reset();
    boxes.setBox(b, box);
    if (b >= boxes.clusters()) continue;
    ofCluster.clear();
    for (int c = 0; c < corners; ++c)
      for (int k = 0; k < group.counts[b]; ++k) {
        box.include(positions + 4 * group.blocks[b][c][k]);
        ofCluster.push_back(normals[group.blocks[b][c][k]]);
      }
    boxes.cones[b].fit(ofCluster);
    boxes.sixteen[b / blockSize].include(box.lo);
    boxes.sixteen[b / blockSize].include(box.hi);
    boxes.setBox(b, box);
  }
}

template <int corners>
void addNormals(const std::vector<Vec3f>& normals, Cluster& cluster) {
  for (int k = 0; k < blockSize; ++k) {
    Vec3f sum = Vec3f::Zero();
    bool folded = false;
    for (int c = 0; c < corners; ++c) {
      const Vec3f& normal = normals[cluster.vertex[c][k]];
      sum += normal;
      folded = folded || normal.isZero(0.0f);
    }
    if (folded) sum.setZero();
    const float length = std::max(sum.norm(), tiny);
    for (int c = 0; c < 3; ++c) cluster.normal[c][k] = sum[c] / length;
  }
}

bool shareVertex(const std::int16_t four[4], int ofFirst) {
  for (int p = 0; p < ofFirst; ++p)
    for (int q = ofFirst; q < 4; ++q)
      if (four[p] == four[q]) return true;
  return false;
}

/// Adds what is listed between two clusters, of one cell without pairs that have a vertex in common.
/// @param both they are the same cluster of edges, which finds each pair twice
int addTo(ContactFours& out, const std::int16_t (*fours)[4], int count, int ofFirst, bool same, bool both) {
  int added = 0;
  for (const std::int16_t(*four)[4] = fours; four != fours + count; ++four) {
    const auto& [a, b, c, d] = *four;
    if (same && (shareVertex(*four, ofFirst) || (both && std::pair(a, b) > std::pair(c, d)))) continue;
    out.add(*four);
    ++added;
  }
  return added;
}

}  // namespace

Clusters::Clusters(const Membrane& membrane) {
  const TriangleMesh& mesh = membrane.mesh();
  vertices = groupsOf<1>(mesh.vertices.size(), mesh.vertices, [](int v, int) { return v; });
  edges = groupsOf<2>(membrane.edges().size(), mesh.vertices,
                      [&](int e, int c) { return membrane.edges()[e][c]; });
  triangles =
      groupsOf<3>(mesh.triangles.size(), mesh.vertices, [&](int t, int c) { return mesh.triangles[t][c]; });
}

void FloatBox::reset() {
  for (int k = 0; k < 3; ++k) {
    lo[k] = std::numeric_limits<float>::max();
    hi[k] = -std::numeric_limits<float>::max();
  }
}

void FloatBox::include(const float* p) {
  for (int k = 0; k < 3; ++k) {
    lo[k] = std::min(lo[k], p[k]);
    hi[k] = std::max(hi[k], p[k]);
  }
}

bool FloatBox::meets(const float otherLo[3], const float otherHi[3]) const {
  for (int k = 0; k < 3; ++k)
    if (otherLo[k] > hi[k] || lo[k] > otherHi[k]) return false;
  return true;
}

void NormalCone::fit(const std::vector<Vec3f>& normals) {
  constexpr float rounding = 1e-3f;  // of angles
  *this = {};
  const auto isZero = [](const Vec3f& normal) { return normal.isZero(0.0f); };
  if (std::any_of(normals.begin(), normals.end(), isZero)) return;
  for (const Vec3f& normal : normals) axis += normal;
  axis /= std::max(axis.norm(), tiny);
  float least = 1.0f;
  for (const Vec3f& normal : normals) least = std::min(least, axis.dot(normal));
  left = 0.5f * std::acos(facing) - std::acos(least) - rounding;
  cosine = std::cos(left);
  sine = std::sin(left);
}

FloatBox Outline::Boxes::box(std::size_t cluster) const {
  const BoxBlock& block = blocks[cluster / blockSize];
  const std::size_t lane = cluster % blockSize;
  return {{block.lo[0][lane], block.lo[1][lane], block.lo[2][lane]},
          {block.hi[0][lane], block.hi[1][lane], block.hi[2][lane]}};
}

void Outline::Boxes::setBox(std::size_t cluster, const FloatBox& box) {
  for (int k = 0; k < 3; ++k) {
    blocks[cluster / blockSize].lo[k][cluster % blockSize] = box.lo[k];
    blocks[cluster / blockSize].hi[k][cluster % blockSize] = box.hi[k];
  }
}

void findNormals(const Membrane& membrane, const float* positions, std::vector<Vec3f>& normals) {
  const std::vector<Triangle>& triangleCorners = membrane.mesh().triangles;
  const auto at = [&](int v) { return Vec3f(positions + 4 * v); };
  normals.assign(membrane.mesh().vertices.size(), Vec3f::Zero());
  std::vector<Vec3f> flat;
  for (const Triangle& t : triangleCorners) {
    const Vec3f across = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    flat.push_back(across / std::max(across.norm(), tiny));
    for (const int v : t) normals[v] += flat.back();
  }
  for (Vec3f& normal : normals) normal /= std::max(normal.norm(), tiny);
  std::vector<int> folded;
  for (std::size_t t = 0; t < flat.size(); ++t)
    for (const int v : triangleCorners[t])
      if (flat[t].dot(normals[v]) < foldedBelow) folded.push_back(v);
  for (const int v : folded) normals[v].setZero();
}

void Outline::fit(const Clusters& clusters, const float* positions, const std::vector<Vec3f>& normals) {
  fitTo(clusters.vertices, positions, normals, vertices);
  fitTo(clusters.edges, positions, normals, edges);
  fitTo(clusters.triangles, positions, normals, triangles);
  all.reset();
  for (const FloatBox& box : vertices.sixteen) {
    all.include(box.lo);
    all.include(box.hi);
  }
}

void ContactFours::clear() {
  numbers_.clear();
  size_ = 0;
}

void ContactFours::add(const std::int16_t four[4]) {
  const std::size_t first = std::size_t(size_ / blockSize * 4 * blockSize);
  if (numbers_.size() < first + 4 * blockSize) numbers_.resize(first + 4 * blockSize, 0);
  for (int k = 0; k < 4; ++k) numbers_[first + k * blockSize + size_ % blockSize] = four[k];
  ++size_;
}

template <int ofFirst, int ofSecond>
int ContactLister::listBetween(const Clusters::Group<ofFirst>& a, const Outline::Boxes& boxesOfA,
                               const Clusters::Group<ofSecond>& b, const Outline::Boxes& boxesOfB,
                               ContactKind kind, const ListedCell& first, const ListedCell& second,
                               const float offset[3], float limit, bool same, ContactFours& out) {
  loaded_.clear();
  place_.assign(boxesOfB.clusters(), -1);
  const auto load = [&](const auto& group, const Outline::Boxes& boxes, std::size_t k, const ListedCell& cell,
                        auto corners, const float* by) {
    Cluster cluster;
    const FloatBox box = boxes.box(k);
    for (int c = 0; c < 3; ++c) {
      cluster.lo[c] = box.lo[c] + by[c];
      cluster.hi[c] = box.hi[c] + by[c];
      cluster.axis[c] = boxes.cones[k].axis[c];
    }
    cluster.vertex = reinterpret_cast<const std::int16_t(*)[blockSize]>(group.blocks[k].data());
    cluster.count = group.counts[k];
    if (same) addNormals<corners>(*cell.normals, cluster);
    kernels_.load(cell.positions, by, corners, cluster);
    return cluster;
  };
  int found = 0;
  for (std::size_t i = 0; i < boxesOfA.clusters(); ++i) {
    const FloatBox box = boxesOfA.box(i);
    float lo[3], hi[3];
    for (int k = 0; k < 3; ++k) {
      lo[k] = box.lo[k] - limit - offset[k];
      hi[k] = box.hi[k] + limit - offset[k];
    }
    if (!second.outline->all.meets(lo, hi)) continue;
    near_.clear();
    for (std::size_t f = 0; f < boxesOfB.blocks.size(); ++f) {
      if (!boxesOfB.sixteen[f].meets(lo, hi)) continue;
      for (unsigned bits = kernels_.boxes(boxesOfB.blocks[f], lo, hi); bits != 0; bits &= bits - 1) {
        const int j = int(f) * blockSize + __builtin_ctz(bits);
        const bool twice = same && ofFirst == ofSecond && j < int(i);
        if (twice || (same && boxesOfA.cones[i].facesAway(boxesOfB.cones[j]))) continue;
        near_.push_back(j);
      }
    }
    if (near_.empty()) continue;
    const Cluster own = load(a, boxesOfA, i, first, std::integral_constant<int, ofFirst>(), none);
    for (const int j : near_) {
      if (place_[j] < 0) {
        place_[j] = int(loaded_.size());
        loaded_.push_back(load(b, boxesOfB, j, second, std::integral_constant<int, ofSecond>(), offset));
      }
      std::int16_t fours[blockSize * blockSize][4];
      const int listed = kernels_.list(kind, own, loaded_[place_[j]], limit, same, fours);
      found += addTo(out, fours, listed, ofFirst, same, ofFirst == ofSecond && j == int(i));
    }
  }
  return found;
}

int ContactLister::list(ContactKind kind, const ListedCell& first, const ListedCell& second,
                        const float offset[3], float limit, bool same, ContactFours& out) {
  out.pad();
  if (kind == ContactKind::vertexTriangle)
    return listBetween<1, 3>(first.clusters->vertices, first.outline->vertices, second.clusters->triangles,
                             second.outline->triangles, kind, first, second, offset, limit, same, out);
  return listBetween<2, 2>(first.clusters->edges, first.outline->edges, second.clusters->edges,
                           second.outline->edges, kind, first, second, offset, limit, same, out);
}

}  // namespace packmesh
