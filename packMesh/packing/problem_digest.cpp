// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/problem_digest.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdio>
#include <memory>
#include <type_traits>

#include "packMesh/core/random.h"

namespace packmesh {
namespace {

/// To be changed when a problem is to be told from the same one of earlier versions.
constexpr std::int64_t generation = 1;

/// Points at which lumens are compared.
constexpr std::int64_t probes = 256;

class Digest {
 public:
  Digest() : state_(XXH3_createState(), XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

  template <class T>
  void add(const T& number) {
    static_assert(std::is_arithmetic_v<T>);
    XXH3_128bits_update(state_.get(), &number, sizeof number);
  }
  void add(const Vec3& v) {
    for (int k = 0; k < 3; ++k) add(v[k]);
  }
  void add(const std::string& text) {
    add(static_cast<std::int64_t>(text.size()));
    XXH3_128bits_update(state_.get(), text.data(), text.size());
  }
  void add(const TriangleMesh& mesh) {
    add(static_cast<std::int64_t>(mesh.vertices.size()));
    for (const Vec3& v : mesh.vertices) add(v);
    for (const Triangle& t : mesh.triangles)
      for (const int corner : t) add(corner);
  }

  std::string text() const {
    const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
    char digits[33];
    std::snprintf(digits, sizeof digits, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return digits;
  }

 private:
  std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state_;
};

void addWall(const Wall& wall, const Box& bounds, Digest& digest) {
  for (std::int64_t n = 0; n < probes; ++n) {
    const auto u = uniform4(0, RandomStream::position, n, 0);
    digest.add(wall.distance(bounds.lo + Vec3(u[0], u[1], u[2]).cwiseProduct(bounds.size())).distance);
  }
}

void addFreedom(const Species& species, const Box& bounds, Digest& digest) {
  const Freedom& freedom = species.freedom;
  digest.add(static_cast<std::int64_t>(species.start.size()));
  for (const Pose& pose : species.start) {
    digest.add(pose.position);
    for (int k = 0; k < 4; ++k) digest.add(pose.orientation.coeffs()[k]);
  }
  digest.add(freedom.fixed);
  digest.add(freedom.extraWallClearance);
  digest.add(freedom.cone ? freedom.cone->axis : Vec3(Vec3::Zero()));
  digest.add(freedom.cone ? freedom.cone->spread : -1.0);
  for (std::int64_t n = 0; freedom.region && n < probes; ++n) {
    const auto u = uniform4(0, RandomStream::position, n, 0);
    const Vec3 p = bounds.lo + Vec3(u[0], u[1], u[2]).cwiseProduct(bounds.size());
    digest.add(freedom.region->distance(p).distance);
  }
}

void addGrowth(const PackingProblem& problem, Digest& digest) {
  const GrowthSettings& g = problem.growth;
  digest.add(static_cast<int>(problem.planeSource));
  for (const double barrier : g.barriers) digest.add(barrier);
  for (const double number : {g.initialScale, g.rotationBound, g.translationBound, g.padding, g.alpha, g.beta,
                              g.shaking, g.stalledGrowth})
    digest.add(number);
  for (const int number : {g.maxIterations, g.linearisations, g.centring ? 1 : 0, g.patience,
                           g.relaxationSweeps, g.giveUpAfter, g.attempts})
    digest.add(number);
  digest.add(problem.escape.has_value());
  if (!problem.escape) return;
  for (const int number : {problem.escape->orientations, problem.escape->swapRounds,
                           problem.escape->groupSize, problem.escape->holes})
    digest.add(number);
  for (const std::int64_t number : problem.escape->reserve) digest.add(number);
}

}  // namespace

std::string digestOf(const PackingProblem& problem) {
  Digest digest;
  digest.add(generation);
  digest.add(static_cast<int>(problem.method));
  digest.add(problem.seed);
  digest.add(problem.rotate);
  digest.add(problem.clearance);
  digest.add(problem.wallClearance);
  digest.add(1);  // of an option that is gone, so that states from before still belong to their problems
  if (problem.method == Method::cat) addGrowth(problem, digest);
  const Box bounds = problem.container->bounds();
  digest.add(bounds.lo);
  digest.add(bounds.hi);
  digest.add(problem.container->period());
  digest.add(problem.container->volume());
  for (const Species& species : problem.species) {
    digest.add(species.name);
    digest.add(species.count);
    digest.add(species.shape->mesh());
    if (const Wall* wall = problem.wallOf(species)) addWall(*wall, bounds, digest);
    if (species.inColumns) digest.add(std::string("in columns"));
    if (!species.start.empty() || !species.freedom.isFree()) addFreedom(species, bounds, digest);
  }
  return digest.text();
}

}  // namespace packmesh
