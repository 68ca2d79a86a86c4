// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/pair_list.h"

#include <algorithm>

#include "packMesh/mesh/sphere_grid.h"

namespace packmesh {
namespace {

/// The second cell of a pair as found in the search.
struct Partner {
  std::int64_t id;
  std::int32_t index;
  ImageShift shift;

  bool operator<(const Partner& other) const { return id != other.id ? id < other.id : shift < other.shift; }
};

/// Finds the pairs in which a body has the smaller id.
class PairSearch {
 public:
  explicit PairSearch(const PairListInput& input)
      : input_(input), spheres_(spheresOf(input)), grid_(spheres_) {
    for (const Sphere& sphere : spheres_) largest_ = std::max(largest_, sphere.radius);
    ids_.reserve(input.bodies.size());
    for (const Body& body : input.bodies) ids_.push_back(body.id);
  }

  /// Appends the pairs of a body, sorted by id and shift. @param partners used as scratch memory
  void find(int i, std::vector<Partner>& partners, std::vector<ContactPair>& pairs) const {
    partners.clear();
    const double reach = spheres_[i].radius + largest_ + input_.margin;
    forEachImage(spheres_[i].center, reach, input_.bounds, input_.period, [&](const ImageShift& shift) {
      // The image of i at +shift is near j; hence j displaced by -shift is near i.
      const bool unshifted = shift == ImageShift{0, 0, 0};
      const ImageShift opposite{static_cast<std::int8_t>(-shift[0]), static_cast<std::int8_t>(-shift[1]),
                                static_cast<std::int8_t>(-shift[2])};
      const Vec3 image = spheres_[i].center + displacement(shift, input_.period);
      grid_.forEachNear({image, spheres_[i].radius}, input_.margin, [&](int j) {
        // Every unordered pair of images is found twice, once from either side: keep the side of the smaller
        // id.
        if (ids_[i] > ids_[j]) return;
        if (i == j && (unshifted || shift < opposite)) return;
        partners.push_back({ids_[j], j, opposite});
      });
    });
    std::sort(partners.begin(), partners.end());
    for (const Partner& partner : partners) {
      ContactPair& pair = pairs.emplace_back();
      pair.first = i;
      pair.second = partner.index;
      pair.shift = partner.shift;
    }
  }

 private:
  static std::vector<Sphere> spheresOf(const PairListInput& input) {
    std::vector<Sphere> spheres;
    spheres.reserve(input.bodies.size());
    for (const Body& b : input.bodies) spheres.push_back({b.position, input.radii[b.species] * b.scale});
    return spheres;
  }

  const PairListInput& input_;
  const std::vector<Sphere> spheres_;
  const SphereGrid grid_;
  std::vector<std::int64_t> ids_;
  double largest_ = 0.0;
};

}  // namespace

PairList listPairs(const PairListInput& input) {
  const PairSearch search(input);
  const auto blocks = static_cast<std::int64_t>(input.start.size()) - 1;
  PairList list(blocks);
  struct Scratch {
    std::vector<Partner> partners;
    std::vector<ContactPair> pairs;
  };
  std::vector<Scratch> scratch(input.threads.count());
  input.threads.forEach(blocks, [&](std::int64_t block, int thread) {
    if (input.own && !input.own(static_cast<int>(block))) return;
    Scratch& own = scratch[thread];
    own.pairs.clear();
    for (std::int64_t i = input.start[block]; i < input.start[block + 1]; ++i)
      search.find(static_cast<int>(i), own.partners, own.pairs);
    list[block] = own.pairs;  // as large as needed, and no larger
  });
  return list;
}

}  // namespace packmesh
