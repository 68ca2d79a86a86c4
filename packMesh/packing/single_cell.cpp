// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/single_cell.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <vector>

#include "packMesh/core/error.h"
#include "packMesh/core/pose.h"
#include "packMesh/core/random.h"
#include "packMesh/core/vector_text.h"
#include "packMesh/mesh/closest_point.h"
#include "packMesh/mesh/convex_hull.h"
#include "packMesh/shape/inner_points.h"

namespace packmesh {
namespace {

/// A cause holds if it does so by more than this [µm]: cells are written with rounded numbers.
constexpr double safety = 1e-3;

/// Limits of the number of examined causes, which take about a second, and of the number of times an
/// orientation is divided.
constexpr std::int64_t mostExaminations = 200'000'000;
constexpr int mostDivisions = 14;

/// Random orientations tested first: if a cell fits, one of them usually succeeds.
constexpr int quickLooks = 300;

/// Cost of testing a wall, relative to an image.
constexpr std::int64_t wallExamination = 6;

/// Points in the cell around which balls are constructed.
constexpr int points = 40;

struct Ball {
  Vec3 center;
  double radius;
};

/// Balls inside the cell: around points distributed in it, and around those moved to where the balls are
/// larger.
std::vector<Ball> ballsIn(const Shape& shape) {
  const ClosestPoint surface(shape.mesh());
  const auto ballAt = [&](const Vec3& p) -> Ball {
    const ClosestPoint::Nearest nearest = surface.nearest(p);
    return {p, surface.side(p, nearest) < 0 ? nearest.distance : 0.0};
  };
  std::vector<Ball> all;
  for (const Vec3& p : innerPoints(shape, points)) {
    Ball ball = ballAt(p);
    if (ball.radius == 0.0) continue;
    all.push_back(ball);
    for (double step = shape.halfThickness(); step > 0.05 * shape.halfThickness(); step *= 0.7) {
      const Vec3 away = ball.center - surface.nearest(ball.center).point;
      const Ball moved = ballAt(ball.center + step * away.normalized());
      if (moved.radius > ball.radius) ball = moved;
    }
    all.push_back(ball);
  }
  return all;
}

/// Balls such that a copy of the cell that is moved into one of them overlaps it, without those that protrude
/// little from others.
std::vector<Ball> meetings(const Shape& shape) {
  const double little = 0.2 * shape.halfThickness();
  const std::vector<Ball> balls = ballsIn(shape);
  std::vector<Ball> all, some;
  for (const Ball& a : balls)
    for (const Ball& b : balls) all.push_back({a.center - b.center, a.radius + b.radius});
  std::stable_sort(all.begin(), all.end(), [](const Ball& a, const Ball& b) { return a.radius > b.radius; });
  for (const Ball& ball : all)
    if (std::none_of(some.begin(), some.end(), [&](const Ball& larger) {
          return (larger.center - ball.center).norm() + ball.radius < larger.radius + little;
        }))
      some.push_back(ball);
  return some;
}

/// A direction along which the container is no wider than this [µm].
struct Room {
  Vec3 direction;
  double width;
};

std::vector<Room> roomsOf(const Container& container, double wallClearance) {
  std::vector<Room> rooms;
  for (int k = 0; k < 3; ++k)
    if (container.period()[k] == 0.0)
      rooms.push_back({Vec3::Unit(k), container.bounds().size()[k] - 2.0 * wallClearance});
  const std::optional<ClosedFormWall> round =
      container.wall() ? container.wall()->closedForm() : std::nullopt;
  if (!round || round->radius == 0.0) return rooms;
  constexpr int steps = 12;
  const double width = 2.0 * (round->radius - wallClearance), step = std::acos(-1.0) / steps;
  for (int k = 0; k < 3; ++k)
    for (int i = 1; i < steps; ++i) {
      const int l = (k + 1) % 3;
      if (round->across[k] == 0.0 || round->across[l] == 0.0) continue;
      rooms.push_back({std::cos(i * step) * Vec3::Unit(k) + std::sin(i * step) * Vec3::Unit(l), width});
    }
  return rooms;
}

/// Translations to the images that a cell of this width can touch; one of two opposite ones.
std::vector<Vec3> movesOfImages(const Vec3& period, double width) {
  std::vector<Vec3> moves;
  int most[3];
  for (int k = 0; k < 3; ++k) most[k] = period[k] > 0.0 ? static_cast<int>(width / period[k]) : 0;
  for (int i = 0; i <= most[0]; ++i)
    for (int j = -most[1]; j <= most[1]; ++j)
      for (int k = -most[2]; k <= most[2]; ++k) {
        const Vec3 move = Vec3(i, j, k).cwiseProduct(period);
        if (std::tuple(i, j, k) > std::tuple(0, 0, 0) && move.norm() < width) moves.push_back(move);
      }
  return moves;
}

class Orientations {
 public:
  Orientations(const Shape& shape, const Container& container, double wallClearance, double clearance)
      : hull_(shape.mesh()), width_(2.0 * shape.radius()) {
    for (const Room& room : roomsOf(container, wallClearance))
      if (room.width < width_) causes_.push_back({room.direction, Vec3::Zero(), room.width, width_, true});
    const std::vector<Vec3> moves = movesOfImages(container.period(), width_ + clearance);
    if (moves.empty()) return;
    for (const Ball& meeting : meetings(shape))
      for (const Vec3& move : moves)
        causes_.push_back({move, meeting.center, meeting.radius + clearance, move.norm(), false});
  }

  /// Whether every orientation is impossible for some cause.
  bool allBlocked() {
    std::vector<const Cause*> causes;
    for (const Cause& cause : causes_) causes.push_back(&cause);
    if (causes.empty()) return false;
    for (int n = 0; n < quickLooks; ++n) {
      const auto u = uniform4(1, RandomStream::orientation, n, 0);
      const Mat3 toBody = uniformRotation(u[0], u[1], u[2]).toRotationMatrix();
      if (std::none_of(causes.begin(), causes.end(), [&](const Cause* c) { return depth(*c, toBody) > 0.0; }))
        return false;
    }
    // Every rotation is represented by a quaternion with one component equal to 1 and none larger.
    for (int face = 0; face < 4; ++face)
      if (!blocked(face, Vec3::Zero(), 1.0, mostDivisions, causes)) return false;
    return true;
  }

  std::string obstacle() const {
    return std::string(byWall_ ? "the wall" : "") + (byWall_ && byImage_ ? " or " : "") +
           (byImage_ ? "its own periodic image" : "");
  }

 private:
  /// Why an orientation is impossible.
  struct Cause {
    Vec3 vector;   ///< direction of the width, or translation of the image
    Vec3 meeting;  ///< body frame; translated to here, the image overlaps the cell
    double
        measure;  ///< width of the container, or distance from `meeting` within which they still overlap [µm]
    double lever;  ///< upper bound of the change of any depth [µm/rad]
    bool wall;
  };

  /// Margin by which it holds [µm]; not positive: it does not.
  double depth(const Cause& cause, const Mat3& toBody) const {
    const Vec3 v = toBody * cause.vector;
    if (!cause.wall) return cause.measure - (cause.meeting - v).norm() - safety;
    const Vec3 across = hull_.points()[hull_.furthest(v)] - hull_.points()[hull_.furthest(-v)];
    return v.dot(across) - cause.measure - safety;
  }

  /// A cube of quaternions around `middle`: projected to the unit sphere they do not move further apart, and
  /// rotations differ by twice the angle between them. `causes`: those that may hold in it.
  bool blocked(int face, const Vec3& middle, double half, int divisions,
               const std::vector<const Cause*>& causes) {
    for (const Cause* cause : causes) examinations_ += cause->wall ? wallExamination : 1;
    if (examinations_ > mostExaminations) return false;
    double q[4];
    for (int k = 0, n = 0; k < 4; ++k) q[k] = k == face ? 1.0 : middle[n++];
    const Mat3 toBody = Quaternion(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    const double turn = 2.0 * std::sqrt(3.0) * half;
    bool here = false;
    std::vector<const Cause*> possible;
    for (const Cause* cause : causes) {
      const double now = depth(*cause, toBody), change = turn * cause->lever;
      if (now > change) {
        (cause->wall ? byWall_ : byImage_) = true;
        return true;
      }
      here = here || now > 0.0;
      if (now > -change) possible.push_back(cause);
    }
    if (!here || divisions == 0) return false;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 side(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
      if (!blocked(face, middle + half * side, 0.5 * half, divisions - 1, possible)) return false;
    }
    return true;
  }

  ConvexHull hull_;
  double width_;  ///< diameter of a sphere that contains the cell in any orientation [µm]
  std::vector<Cause> causes_;
  std::int64_t examinations_ = 0;
  bool byWall_ = false, byImage_ = false;
};

}  // namespace

void requireFitsAlone(const std::string& name, const Shape& shape, const Container& container,
                      double wallClearance, double clearance) {
  Orientations orientations(shape, container, wallClearance, clearance);
  if (!orientations.allBlocked()) return;
  const Vec3 size = boundingBox(shape.mesh()).size();
  throw InputError("a cell of species '" + name + "' (" + toText(size[0]) + " x " + toText(size[1]) + " x " +
                   toText(size[2]) + " µm) does not fit in the lumen (" + container.describe() +
                   ") in any orientation: it would intersect " + orientations.obstacle() +
                   (wallClearance > 0.0 || clearance > 0.0 ? " or violate the clearance" : "") +
                   ". Enlarge the lumen or remove this species");
}

}  // namespace packmesh
