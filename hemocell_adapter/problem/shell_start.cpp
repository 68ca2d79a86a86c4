// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/shell_start.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "packMesh/core/poll.h"
#include "packMesh/core/random.h"
#include "packMesh/placement/placement.h"

namespace packmesh::hemocell {
namespace {

/// Points that are tried, at most: for each cell, and besides.
constexpr std::int64_t triesOfCell = 2000, fewestTries = 100000;

/// Purposes of the random numbers of poses, beside those of placeRandomly().
constexpr std::uint32_t ownPurpose = 1 << 20;

}  // namespace

std::vector<std::vector<Pose>> startInShells(const Problem& problem, int species,
                                             const std::vector<std::int64_t>& counts) {
  const DepthProfile& profile = *problem.profile;
  const CellSpecies& cells = problem.species[species];
  const std::uint32_t purpose = ownPurpose + std::uint32_t(species);
  const double room = cells.shape->halfThickness();  // between centre and walls, at least [µm]
  const double least = profile.species[species].freeLayer + room;
  const double reach = 2.0 * jitter * std::cbrt(cells.shape->volume());
  Box bounds = problem.lumen.container->bounds();
  const Vec3 period = problem.lumen.container->period();
  for (int k = 0; k < 3; ++k)
    if (period[k] == 0.0) bounds.lo[k] += room, bounds.hi[k] -= room;
  const auto begin = uniform4(problem.request.seed, RandomStream::begin, 0, purpose);
  std::int64_t missing = std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  const std::int64_t most = std::max(fewestTries, triesOfCell * missing);
  std::vector<std::vector<Pose>> start(counts.size());
  for (std::int64_t n = 0; n < most && missing > 0; ++n) {
    pollAt(std::size_t(n));
    Vec3 p = bounds.lo + bounds.size().cwiseProduct(evenPoint(begin, std::uint64_t(n)));
    const auto u = uniform4(problem.request.seed, RandomStream::position, std::uint64_t(n), purpose);
    p += reach * (Vec3(u[0], u[1], u[2]) - Vec3::Constant(0.5));
    const double depth = (*profile.depth)(p).distance;
    if (depth < least) continue;
    const int shell = profile.shellAt(depth);
    if (std::int64_t(start[shell].size()) >= counts[shell]) continue;
    Pose& pose = start[shell].emplace_back();
    pose.position = p.cwiseMax(bounds.lo).cwiseMin(bounds.hi);
    --missing;
    if (!problem.request.rotate) continue;
    const auto v = uniform4(problem.request.seed, RandomStream::orientation, std::uint64_t(n), purpose);
    pose.orientation = randomOrientation(cells.cone, v[0], v[1], v[2]);
  }
  return start;
}

}  // namespace packmesh::hemocell
