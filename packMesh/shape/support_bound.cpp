// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/shape/support_bound.h"

#include <algorithm>
#include <limits>

#include "packMesh/core/poll.h"

namespace packmesh {
namespace {

/// Mean of the support function over the sphere (directions on a spiral): the effective size for culling.
double meanSupport(const SupportBound& bound) {
  constexpr int directions = 200;
  constexpr double goldenAngle = 2.399963229728653;
  double sum = 0.0;
  for (int i = 0; i < directions; ++i) {
    const double y = (2.0 * i + 1.0) / directions - 1.0, r = std::sqrt(1.0 - y * y), angle = goldenAngle * i;
    sum += bound.support({r * std::cos(angle), y, r * std::sin(angle)});
  }
  return sum / directions;
}

}  // namespace

SupportBound boundSupport(const TriangleMesh& mesh, int rings) {
  // Keeps quotients finite for flat meshes.
  Vec3 extent = Vec3::Constant(1e-12);
  double largestRho = 1e-12;
  for (const Vec3& v : mesh.vertices) {
    extent = extent.cwiseMax(v.cwiseAbs());
    largestRho = std::max(largestRho, std::hypot(v.x(), v.z()));
  }

  SupportBound best;
  double bestSize = std::numeric_limits<double>::infinity();
  for (int step = 0; step < rings; ++step) {
    poll();
    SupportBound bound;
    bound.ring = largestRho * step / rings;
    const double tube = largestRho - bound.ring;
    bound.semiAxes = step == 0 ? extent : Vec3(tube, extent.y(), tube);
    // Enlarge the ellipsoid until every vertex lies in the Minkowski sum: v is in it if and only if v minus
    // its nearest point of the disc is in the ellipsoid.
    double blowUp = 1e-12;
    for (const Vec3& v : mesh.vertices) {
      const double rho = std::hypot(v.x(), v.z());
      const double keep = rho > bound.ring ? (rho - bound.ring) / rho : 0.0;
      blowUp = std::max(blowUp, Vec3(keep * v.x(), v.y(), keep * v.z()).cwiseQuotient(bound.semiAxes).norm());
    }
    bound.semiAxes *= blowUp * (1.0 + 1e-12);  // covers rounding
    const double size = meanSupport(bound);
    if (size < bestSize) {
      bestSize = size;
      best = bound;
    }
  }
  return best;
}

}  // namespace packmesh
