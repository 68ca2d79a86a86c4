// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/pair_lister.h"

#include <algorithm>

#include "packMesh/parallel/per_thread.h"

namespace packmesh {
namespace {

std::vector<Sphere> spheresOf(const PairListerInput& input) {
  std::vector<Sphere> spheres;
  spheres.reserve(input.bodies.size());
  for (const Body& b : input.bodies) spheres.push_back({b.position, input.radii[b.shape] * b.scale});
  return spheres;
}

}  // namespace

/// The second cell of a pair as found in the search.
struct PairLister::Partner {
  std::int64_t id;
  std::int32_t index;
  ImageShift shift;

  bool operator<(const Partner& other) const { return id != other.id ? id < other.id : shift < other.shift; }
};

PairLister::PairLister(const PairListerInput& input)
    : input_(input), spheres_(spheresOf(input)), grid_(spheres_) {
  for (const Sphere& sphere : spheres_) largest_ = std::max(largest_, sphere.radius);
  ids_.reserve(input.bodies.size());
  for (const Body& body : input.bodies) ids_.push_back(body.id);
}

/// Appends the pairs in which a body has the smaller id, sorted. @param partners used as scratch memory
void PairLister::find(int i, std::vector<Partner>& partners, std::vector<ContactPair>& pairs) const {
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

void PairLister::list(const std::vector<int>& blocks, const Threads& threads, PairList& list) const {
  struct Scratch {
    std::vector<Partner> partners;
    std::vector<ContactPair> pairs;
  };
  PerThread<Scratch> scratch(threads);
  threads.forEach(static_cast<std::int64_t>(blocks.size()), [&](std::int64_t b, int thread) {
    const int block = blocks[b];
    Scratch& own = scratch[thread];
    own.pairs.clear();
    for (std::int64_t i = input_.start[block]; i < input_.start[block + 1]; ++i)
      find(static_cast<int>(i), own.partners, own.pairs);
    list[block] = own.pairs;  // as large as needed, and no larger
  });
}

}  // namespace packmesh
