// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/problem_digest.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <memory>
#include <type_traits>

#include "packMesh/core/random.h"

namespace packmesh {
namespace {

/// To be increased whenever digests must differ from those of earlier versions.
constexpr std::int64_t generation = 1;

/// Number of points at which lumens are compared.
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
    return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
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

// Each of the following functions names all members of what it adds, so that a new member does not compile
// until it is decided here whether states of problems that differ in it have to be distinguished.

void addFreedom(const Species& species, const Box& bounds, Digest& digest) {
  const auto& [fixed, cone, region, freeLayer, extraWallClearance] = species.freedom;
  digest.add(static_cast<std::int64_t>(species.start.size()));
  for (const Pose& pose : species.start) {
    digest.add(pose.position);
    for (int k = 0; k < 4; ++k) digest.add(pose.orientation.coeffs()[k]);
  }
  digest.add(fixed);
  digest.add(extraWallClearance);
  digest.add(cone ? cone->axis : Vec3(Vec3::Zero()));
  digest.add(cone ? cone->spread : -1.0);
  if (freeLayer) digest.add(freeLayer->thickness);
  for (std::int64_t n = 0; region && n < probes; ++n) {
    const auto u = uniform4(0, RandomStream::position, n, 0);
    const Vec3 p = bounds.lo + Vec3(u[0], u[1], u[2]).cwiseProduct(bounds.size());
    digest.add(region->distance(p).distance);
  }
}

void addSpecies(const Physics& physics, const Species& species, const Box& bounds, Digest& digest) {
  // The hematocrit and the numbers before rounding only determine how fewer cells are tried.
  const auto& [name, shape, count, wall, inHematocrit, start, freedom, inColumns, asked, kind] = species;
  digest.add(name);
  digest.add(count);
  digest.add(shape->mesh());
  const Wall* const met = shape->undeformed() ? nullptr : physics.wallOf(species);  // there are many of them
  if (met) addWall(*met, bounds, digest);
  if (inColumns) digest.add(std::string("in columns"));
  if (!start.empty() || !freedom.isFree()) addFreedom(species, bounds, digest);
}

void addGrowth(const GrowthSettings& settings, Digest& digest) {
  const auto& [initialScale, barriers, maxIterations, rotationBound, translationBound, padding,
               linearisations, alpha, beta, centring, shaking, patience, stalledGrowth, relaxationSweeps,
               giveUpAfter, attempts] = settings;
  for (const double barrier : barriers) digest.add(barrier);
  for (const double number :
       {initialScale, rotationBound, translationBound, padding, alpha, beta, shaking, stalledGrowth})
    digest.add(number);
  for (const int number :
       {maxIterations, linearisations, centring ? 1 : 0, patience, relaxationSweeps, giveUpAfter, attempts})
    digest.add(number);
}

void addEscape(const EscapeSettings& settings, Digest& digest) {
  const auto& [orientations, swapRounds, groupSize, holes, reserve] = settings;
  for (const int number : {orientations, swapRounds, groupSize, holes}) digest.add(number);
  for (const std::int64_t number : reserve) digest.add(number);
}

}  // namespace

std::string digestOf(const PackingProblem& problem) {
  // `written` is not compared: it belongs to the program, not to the problem.
  const auto& [species, container, clearance, wallClearance, seed, rotate, written] = problem.physics;
  const auto& [kind, planeSource, growth, escape] = problem.method;
  Digest digest;
  digest.add(generation);
  digest.add(static_cast<int>(kind));
  digest.add(seed);
  digest.add(rotate);
  digest.add(clearance);
  digest.add(wallClearance);
  digest.add(1);  // of a removed option, so that the digests of older states remain valid
  if (kind == Method::cat) {
    digest.add(static_cast<int>(planeSource));
    addGrowth(growth, digest);
    digest.add(escape.has_value());
    if (escape) addEscape(*escape, digest);
  }
  const Box bounds = container->bounds();
  digest.add(bounds.lo);
  digest.add(bounds.hi);
  digest.add(container->period());
  digest.add(container->volume());
  for (const Species& one : species) addSpecies(problem.physics, one, bounds, digest);
  return digest.text();
}

}  // namespace packmesh
