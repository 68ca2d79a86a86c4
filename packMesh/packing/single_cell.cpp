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

/// Causes count when they hold by more than this [µm]: cells are written with rounded numbers.
constexpr double safety = 1e-3;

/// How often causes are examined, about a second, and how often an orientation is divided, at most.
constexpr std::int64_t mostExaminations = 200'000'000;
constexpr int mostDivisions = 14;

/// Orientations at random that are looked at first: where cells fit, one of them mostly does.
constexpr int quickLooks = 300;

/// What a wall costs to examine, compared with an image.
constexpr std::int64_t wallExamination = 6;

/// Points in the cell that balls are put around.
constexpr int points = 40;

struct Ball {
  Vec3 center;
  double radius;
};

/// Balls that lie in the cell: around points spread in it, and around those moved to where they are larger.
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

/// Balls such that a copy of the cell that is moved into one of them meets it, without those that stand out
/// of others by little.
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

/// By which images are moved that a cell of this width can meet; of two opposite ones one.
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

  /// Whether every orientation has a cause.
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
    // Every rotation is a quaternion one of whose components is 1 and none larger.
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
    Vec3 vector;     ///< direction of the room, or by which the image is moved
    Vec3 meeting;    ///< moved to here the image meets the cell, in the body frame
    double measure;  ///< width of the room, or how far from `meeting` they still meet [µm]
    double lever;    ///< no depth changes by more than this [µm/rad]
    bool wall;
  };

  /// How clearly it holds [µm]; not positive: it does not.
  double depth(const Cause& cause, const Mat3& toBody) const {
    const Vec3 v = toBody * cause.vector;
    if (!cause.wall) return cause.measure - (cause.meeting - v).norm() - safety;
    const Vec3 across = hull_.points()[hull_.furthest(v)] - hull_.points()[hull_.furthest(-v)];
    return v.dot(across) - cause.measure - safety;
  }

  /// A cube of quaternions around `middle`: projected to the unit sphere they get no further apart, and turn
  /// by twice the angle between them. `causes`: those that may hold in it.
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
  double width_;  ///< of a sphere that holds the cell however it is turned [µm]
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
                   ") in any orientation: it would meet " + orientations.obstacle() +
                   (wallClearance > 0.0 || clearance > 0.0 ? " or come nearer than the clearance" : "") +
                   ". Make the lumen larger or leave these cells out");
}

}  // namespace packmesh
