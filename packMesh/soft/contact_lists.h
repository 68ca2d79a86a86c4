// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Lists of the contacts that are possible until membranes have moved by a skin.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "packMesh/soft/membrane.h"
#include "packMesh/soft/soft_kernels.h"

namespace packmesh {

/// Vertices, edges and triangles of a template in groups of sixteen that are near each other: what is far
/// away is excluded group by group.
struct Clusters {
  explicit Clusters(const Membrane& membrane);

  template <int corners>
  using Blocks = std::vector<std::array<std::array<std::int16_t, 16>, corners>>;
  template <int corners>
  struct Group {
    Blocks<corners> blocks;
    std::vector<int> counts;
  };
  Group<1> vertices;
  Group<2> edges;
  Group<3> triangles;
};

struct FloatBox {
  float lo[3], hi[3];
  void reset();
  void include(const float* p);
  /// @param lo, hi of another box
  bool meets(const float lo[3], const float hi[3]) const;
};

/// The directions of normals.
struct NormalCone {
  Vec3f axis = Vec3f::Zero();
  /// Half of the angle within which normals do not face each other, less the half angle of the cone.
  float left = -1.0f, cosine = 0.0f, sine = 0.0f;

  /// 0: the membrane is folded
  void fit(const std::vector<Vec3f>& normals);
  /// Whether no normal of one faces one of the other.
  bool facesAway(const NormalCone& other) const {
    return left + other.left > 0.0f && axis.dot(other.axis) > cosine * other.cosine - sine * other.sine;
  }
};

/// Where a cell is.
struct Outline {
  FloatBox all;
  /// Of the clusters, and of every sixteen of them.
  struct Boxes {
    std::vector<BoxBlock> blocks;
    std::vector<FloatBox> sixteen;
    std::vector<NormalCone> cones;
    std::size_t clusters() const { return cones.size(); }
    FloatBox box(std::size_t cluster) const;
    void setBox(std::size_t cluster, const FloatBox& box);
  };
  Boxes vertices, edges, triangles;
  /// @param positions four numbers per vertex [µm] @param normals of vertices
  void fit(const Clusters& clusters, const float* positions, const std::vector<Vec3f>& normals);
};

/// Those of vertices; 0 where the triangles are not nearly in one plane.
/// @param positions four numbers per vertex [µm] @param normals overwritten
void findNormals(const Membrane& membrane, const float* positions, std::vector<Vec3f>& normals);

/// Contacts in blocks.
class ContactFours {
 public:
  std::int64_t size() const { return size_; }
  const VertexFours* blocks() const { return reinterpret_cast<const VertexFours*>(numbers_.data()); }
  const std::int16_t* numbers() const { return numbers_.data(); }  ///< of the blocks, one after the other
  void clear();
  void add(const std::int16_t four[4]);
  /// Begins the next one at a new block.
  void pad() { size_ = (size_ + width - 1) / width * width; }
  static constexpr int width = 16;

 private:
  std::vector<std::int16_t> numbers_;
  std::int64_t size_ = 0;
};

/// One cell's part in listing.
struct ListedCell {
  const Clusters* clusters;
  const Outline* outline;
  const float* positions;
  const std::vector<Vec3f>* normals = nullptr;  ///< of a cell that is listed with itself
};

class ContactLister {
 public:
  explicit ContactLister(const ContactKernels& kernels) : kernels_(kernels) {}
  /// Appends to `out` the contacts of a kind between vertices (edges) of `first` and triangles (edges) of
  /// `second` with a distance below `limit` [µm], from the beginning of a block.
  /// @param offset added to positions of the second [µm]
  /// @param same they are the same cell: only what faces each other and has no vertex in common; pairs of
  /// edges
  ///   are listed once
  /// @return their number
  int list(ContactKind kind, const ListedCell& first, const ListedCell& second, const float offset[3],
           float limit, bool same, ContactFours& out);

 private:
  template <int ofFirst, int ofSecond>
  int listBetween(const Clusters::Group<ofFirst>& a, const Outline::Boxes& boxesOfA,
                  const Clusters::Group<ofSecond>& b, const Outline::Boxes& boxesOfB, ContactKind kind,
                  const ListedCell& first, const ListedCell& second, const float offset[3], float limit,
                  bool same, ContactFours& out);

  const ContactKernels& kernels_;
  std::vector<int> place_;  ///< of a cluster in `loaded_`; -1: not loaded
  std::vector<Cluster> loaded_;
  std::vector<int> near_;
};

}  // namespace packmesh
