// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/relaxation/pair_list.h"

#include <algorithm>

#include "packMesh/mesh/sphere_grid.h"

namespace packmesh {
namespace {

/// Expected number of pairs of spheres of equal size that are distributed uniformly; at most the capacity
/// that geometric growth could reach. Real cells do not overlap, so that there are hardly more.
std::size_t expectedPairs(const std::vector<Sphere>& spheres, double radius, double margin) {
  constexpr double most = 16.0;
  if (spheres.empty()) return 0;
  Box bounds{spheres[0].center, spheres[0].center};
  for (const Sphere& s : spheres) bounds.add(s.center);
  const double bodies = static_cast<double>(spheres.size()), reach = 2.0 * radius + margin;
  const double near = 4.19 * reach * reach * reach * bodies / bounds.volume();
  return static_cast<std::size_t>((near < 2.0 * most ? 0.5 * near : most) * bodies);  // `most` for NaN
}

/// The second cell of a pair as found in the search.
struct Partner {
  std::int64_t id;
  std::int32_t index;
  ImageShift shift;

  bool operator<(const Partner& other) const { return id != other.id ? id < other.id : shift < other.shift; }
};

}  // namespace

PairList listPairs(const std::vector<Body>& bodies, const std::vector<double>& radii, double margin,
                   const Box& bounds, const Vec3& period, int blocks, const std::function<bool(int)>& own) {
  std::vector<Sphere> spheres;
  std::vector<std::int64_t> ids;
  spheres.reserve(bodies.size());
  ids.reserve(bodies.size());
  double largest = 0.0;
  for (const Body& b : bodies) {
    spheres.push_back({b.position, radii[b.species] * b.scale});
    ids.push_back(b.id);
    largest = std::max(largest, spheres.back().radius);
  }
  const SphereGrid grid(spheres);

  PairList list;
  list.pairs.reserve(expectedPairs(spheres, largest, margin));
  list.start.assign(blocks + 1, 0);
  std::vector<Partner> partners;
  for (int i = 0; i < static_cast<int>(bodies.size()); ++i) {
    if (!own(bodies[i].block)) continue;
    partners.clear();
    const double reach = spheres[i].radius + largest + margin;
    forEachImage(spheres[i].center, reach, bounds, period, [&](const ImageShift& shift) {
      // The image of i at +shift is near j; hence j displaced by -shift is near i.
      const bool unshifted = shift == ImageShift{0, 0, 0};
      const ImageShift opposite{static_cast<std::int8_t>(-shift[0]), static_cast<std::int8_t>(-shift[1]),
                                static_cast<std::int8_t>(-shift[2])};
      const Vec3 image = spheres[i].center + displacement(shift, period);
      grid.forEachNear({image, spheres[i].radius}, margin, [&](int j) {
        // Every unordered pair of images is found twice, once from either side: keep the side of the smaller
        // id.
        if (ids[i] > ids[j]) return;
        if (i == j && (unshifted || shift < opposite)) return;
        partners.push_back({ids[j], j, opposite});
      });
    });
    std::sort(partners.begin(), partners.end());
    for (const Partner& partner : partners) {
      ContactPair& pair = list.pairs.emplace_back();
      pair.first = i;
      pair.second = partner.index;
      pair.shift = partner.shift;
    }
    list.start[bodies[i].block + 1] = static_cast<std::int64_t>(list.pairs.size());
  }
  for (int b = 0; b < blocks; ++b) list.start[b + 1] = std::max(list.start[b + 1], list.start[b]);
  return list;
}

}  // namespace packmesh
