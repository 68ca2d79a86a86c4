// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/problem_digest.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "packMesh/core/random.h"
#include "packMesh/packing/engine.h"

namespace packmesh {
namespace {

/// To be increased whenever digests must differ from those of earlier versions.
constexpr std::int64_t generation = 1;

/// Number of points at which lumens are compared.
constexpr std::int64_t probes = 256;

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
  digest.add(species.placed());
  species.forEachStart([&](int, const Pose& pose) {
    digest.add(pose.position);
    for (int k = 0; k < 4; ++k) digest.add(pose.orientation.coeffs()[k]);
  });
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
  // The kind only names the cells.
  const auto& [name, shape, count, wall, inHematocrit, kind, deformed, start, freedom, inColumns, asked] =
      species;
  digest.add(name);
  digest.add(count);
  digest.add(physics.shapes[shape]->mesh());
  if (const Wall* const met = physics.wallOf(species)) addWall(*met, bounds, digest);
  if (inColumns) digest.add(std::string("in columns"));
  for (const DeformedCell& cell : deformed) {
    digest.add(cell.shape);
    for (const Vec3& v : physics.shapeOf(cell).mesh().vertices) digest.add(v);
    digest.add(cell.start.has_value());
  }
  if (species.placed() > 0 || !freedom.isFree()) addFreedom(species, bounds, digest);
}

XXH3_state_t* of(const std::shared_ptr<void>& state) {
  return static_cast<XXH3_state_t*>(state.get());
}

}  // namespace

Digest::Digest()
    : state_(XXH3_createState(), [](void* state) { XXH3_freeState(static_cast<XXH3_state_t*>(state)); }) {
  XXH3_128bits_reset(of(state_));
}

void Digest::addBytes(const void* bytes, std::size_t count) {
  XXH3_128bits_update(of(state_), bytes, count);
}

void Digest::add(const std::string& text) {
  add(static_cast<std::int64_t>(text.size()));
  addBytes(text.data(), text.size());
}

void Digest::add(const TriangleMesh& mesh) {
  add(static_cast<std::int64_t>(mesh.vertices.size()));
  for (const Vec3& v : mesh.vertices) add(v);
  for (const Triangle& t : mesh.triangles)
    for (const int corner : t) add(corner);
}

std::string Digest::text() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(of(state_));
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

std::string digestOf(const PackingProblem& problem) {
  // `written` is not compared: it belongs to the program, not to the problem.
  const auto& [species, shapes, container, clearance, wallClearance, smoothWalls, seed, rotate, written] =
      problem.physics;
  Digest digest;
  digest.add(generation);
  digest.add(problem.engine && !problem.engine->deforms() ? 1 : 0);
  digest.add(seed);
  digest.add(rotate);
  digest.add(clearance);
  digest.add(wallClearance);
  if (smoothWalls) digest.add(std::string("smooth walls"));
  digest.add(1);  // of a removed option, so that the digests of older states remain valid
  if (problem.engine) problem.engine->addTo(digest);
  const Box bounds = container->bounds();
  digest.add(bounds.lo);
  digest.add(bounds.hi);
  digest.add(container->period());
  digest.add(container->volume());
  for (const Species& one : species) addSpecies(problem.physics, one, bounds, digest);
  return digest.text();
}

}  // namespace packmesh
