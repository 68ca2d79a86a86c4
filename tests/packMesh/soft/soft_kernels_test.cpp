// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_kernels.h"
#include "packMesh/core/vector.h"
#include "packMesh/mesh/closest_point.h"
#include "tests/support/catch.h"

namespace packmesh {
namespace {

/// Sixteen contacts of random vertices of two cells.
struct Contacts {
  static constexpr int count = 16;
  std::vector<float> first = std::vector<float>(8 * count), second = std::vector<float>(12 * count);
  VertexFours fours;
  ContactKind kind;

  Contacts(ContactKind of, unsigned seed) : kind(of) {
    std::mt19937 random(seed);
    for (auto* cell : {&first, &second})
      for (float& x : *cell) x = float(random()) / float(random.max()) - 0.5f;
    for (int n = 0; n < count; ++n) {
      const bool edges = kind == ContactKind::edgeEdge;
      const int four[4] = {2 * n, edges ? 2 * n + 1 : 3 * n, 3 * n + 1, 3 * n + 2};
      for (int k = 0; k < 4; ++k) fours[k][n] = std::int16_t(four[k]);
    }
  }
  Vec3 at(int k, int n) const {
    const bool ofFirst = k == 0 || (k == 1 && kind == ContactKind::edgeEdge);
    const float* p = (ofFirst ? first : second).data() + 4 * fours[k][n];
    return Vec3(p[0], p[1], p[2]) + (ofFirst ? Vec3(Vec3::Zero()) : Vec3(0.1, 0.0, 0.3));
  }
  CellPair pair() const { return {first.data(), second.data(), {0.1f, 0.0f, 0.3f}}; }
};

/// The distance of a contact, by other means: the closest point of a mesh, and nested sections.
double distanceOf(const Contacts& c, int n) {
  if (c.kind == ContactKind::vertexTriangle)
    return ClosestPoint({{c.at(1, n), c.at(2, n), c.at(3, n)}, {{0, 1, 2}}})
        .onTriangle(0, c.at(0, n))
        .distance;
  const auto toEdge = [&](double s) {
    const Vec3 p = c.at(0, n) + s * (c.at(1, n) - c.at(0, n)), along = c.at(3, n) - c.at(2, n);
    const double t = std::min(1.0, std::max(0.0, (p - c.at(2, n)).dot(along) / along.squaredNorm()));
    return (p - c.at(2, n) - t * along).norm();
  };
  double lo = 0.0, hi = 1.0;  // the distance is a convex function along the edge
  for (int i = 0; i < 200; ++i) {
    const double a = lo + (hi - lo) / 3.0, b = hi - (hi - lo) / 3.0;
    (toEdge(a) < toEdge(b) ? hi : lo) = toEdge(a) < toEdge(b) ? b : a;
  }
  return toEdge(lo);
}

/// From a point to the first vertex or edge.
double distanceTo(const Vec3& p, const Contacts& c, int n) {
  if (c.kind == ContactKind::vertexTriangle) return (p - c.at(0, n)).norm();
  const Vec3 along = c.at(1, n) - c.at(0, n);
  const double s = std::min(1.0, std::max(0.0, (p - c.at(0, n)).dot(along) / along.squaredNorm()));
  return (p - c.at(0, n) - s * along).norm();
}

struct Result {
  std::vector<float> forces = std::vector<float>(4 * 32, 0.0f), gaps = std::vector<float>(32, 10.0f);
  std::vector<Reaction> reactions = std::vector<Reaction>(16);
  int count = 0;
};
Result forcesOf(const Contacts& c, const Barrier& barrier, Approach approach = {}) {
  Result r;
  std::memset(r.reactions.data(), 0, r.reactions.size() * sizeof(Reaction));
  float notYet = 0.0f;
  if (!approach.until) approach.until = &notYet;
  r.count = proximityKernels(chosenInstructionSet())
                .forces(c.kind, c.pair(), &c.fours, Contacts::count, barrier, approach, r.forces.data(),
                        r.gaps.data(), r.reactions.data());
  return r;
}

TEST_CASE("contacts out of range are not computed until cells can have come near", "[soft]") {
  for (const ContactKind kind : {ContactKind::vertexTriangle, ContactKind::edgeEdge})
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const Contacts c(kind, seed);
      double least = distanceOf(c, 0);
      for (int n = 1; n < Contacts::count; ++n) least = std::min(least, distanceOf(c, n));
      if (least < 0.01) continue;  // at the limits of single precision
      const float range = float(0.5 * least);
      float until = 0.0f;
      const auto count = [&](float within, float moved) {
        return forcesOf(c, {0.0f, within, 20.0f}, {moved, &until}).count;
      };
      CHECK(count(range, 0.1f) == 0);
      CHECK(until == Approx(least + 0.1).epsilon(1e-3));
      until = 10.0f;  // as if they were far away
      CHECK(count(3.0f * range, 0.1f) == 0);
      CHECK(until == 10.0f);
      CHECK(count(3.0f * range, 10.0f - 2.9f * range) > 0);
    }
}

TEST_CASE("contacts have the distance, the force of the barrier and its reaction", "[soft]") {
  const Barrier barrier{0.02f, 0.5f, 20.0f};
  for (const ContactKind kind : {ContactKind::vertexTriangle, ContactKind::edgeEdge})
    for (unsigned seed = 1; seed <= 50; ++seed) {
      const Contacts c(kind, seed);
      const Result r = forcesOf(c, barrier);
      int expected = 0;
      for (int n = 0; n < Contacts::count; ++n) {
        const double gap = distanceOf(c, n) - 0.02;
        if (std::abs(gap - 0.5) < 1e-5 || gap < 0.01) continue;  // at the limits of single precision
        CHECK(r.gaps[c.fours[0][n]] == Approx(gap < 0.5 ? gap : 10.0).epsilon(1e-3));
        if (gap > 0.5) continue;
        ++expected;
        const auto reaction =
            std::find_if(r.reactions.begin(), r.reactions.begin() + r.count, [&](const Reaction& one) {
              return one.vertex[1] == c.fours[kind == ContactKind::edgeEdge ? 3 : 2][n];
            });
        REQUIRE(reaction != r.reactions.begin() + r.count);
        CHECK(reaction->gap == Approx(gap).epsilon(1e-3));
        // The weights are those of the nearest point of the second one.
        const bool edges = kind == ContactKind::edgeEdge;
        const double first = 1.0 - reaction->second - reaction->third;
        const Vec3 nearest =
            edges ? Vec3(first * c.at(2, n) + reaction->second * c.at(3, n))
                  : Vec3(first * c.at(1, n) + reaction->second * c.at(2, n) + reaction->third * c.at(3, n));
        CHECK((edges ? reaction->third == 0.0f : reaction->third >= 0.0f));
        CHECK(distanceTo(nearest, c, n) == Approx(gap + 0.02).epsilon(1e-3));
        const Vec3 force(reaction->force[0], reaction->force[1], reaction->force[2]);
        const double full = 20.0 * (0.5 - gap) * 0.5 / gap;
        // At an end of an edge, contacts of the vertex take over.
        if (kind == ContactKind::edgeEdge)
          CHECK(force.norm() <= 1.001 * full);
        else
          CHECK(force.norm() == Approx(full).epsilon(2e-3));
        Vec3 onFirst = Vec3::Zero();
        for (int k = 0; k < (kind == ContactKind::edgeEdge ? 2 : 1); ++k)
          for (int axis = 0; axis < 3; ++axis) onFirst[axis] += r.forces[4 * c.fours[k][n] + axis];
        CHECK((onFirst - force).norm() < 1e-4 * full);
      }
      CHECK(r.count >= expected);
    }
}

}  // namespace
}  // namespace packmesh
