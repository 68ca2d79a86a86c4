// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/container/primitives.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "packMesh/container/container.h"
#include "packMesh/core/error.h"
#include "packMesh/core/vector.h"

namespace packmesh {
namespace {

constexpr double pi = 3.14159265358979323846;

/// Number of sides of the polygon that represents a circle in surface().
constexpr int circleSides = 64;
/// Number of refinements of the icosahedron that represents a sphere in surface().
constexpr int sphereLevels = 3;

/// Relative error of computed squared lengths; the exact tests allow for it.
constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();

void requirePositive(double value, const std::string& what) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw InputError(what + " must be positive and finite; found " + toText(value) + " µm");
}

/// Common base: the container is its own wall.
class Primitive : public Container, public Wall {
 public:
  const Wall* wall() const override { return this; }
  WallDistance distance(const Vec3& p) const override { return form_.distance(p); }
  std::optional<ClosedFormWall> closedForm() const override { return form_; }

 protected:
  ClosedFormWall form_;
};

class BoxContainer final : public Primitive {
 public:
  BoxContainer(const Box& box, const std::array<bool, 3>& periodic) : box_(box), periodic_(periodic) {
    for (int k = 0; k < 3; ++k)
      if (!periodic[k]) {
        form_.lo[k] = box.lo[k];
        form_.hi[k] = box.hi[k];
      }
  }

  Box bounds() const override { return box_; }
  Vec3 period() const override {
    Vec3 period = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      if (periodic_[k]) period[k] = box_.hi[k] - box_.lo[k];
    return period;
  }
  double volume() const override { return box_.volume(); }
  const Wall* wall() const override { return walled() ? this : nullptr; }

  std::string describe() const override {
    const Vec3 size = box_.size();
    std::string which;
    for (int k = 0; k < 3; ++k)
      if (periodic_[k]) which += std::string(which.empty() ? "" : " and ") + axisName[k];
    return std::string(walled() ? "box " : "periodic box ") + toText(size.x()) + " x " + toText(size.y()) +
           " x " + toText(size.z()) + " µm" + (walled() && !which.empty() ? ", periodic along " + which : "");
  }

  TriangleMesh surface() const override {
    TriangleMesh mesh;
    for (int c = 0; c < 8; ++c)
      mesh.vertices.emplace_back(c & 1 ? box_.hi.x() : box_.lo.x(), c & 2 ? box_.hi.y() : box_.lo.y(),
                                 c & 4 ? box_.hi.z() : box_.lo.z());
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    return verdictInConvex(*this, cell, gapOfInterest, [&](const Vec3& v) {
      for (int k = 0; k < 3; ++k)
        if (!periodic_[k] && !(v[k] > box_.lo[k] && v[k] < box_.hi[k])) return false;
      return true;
    });
  }

 private:
  bool walled() const { return !(periodic_[0] && periodic_[1] && periodic_[2]); }

  Box box_;
  std::array<bool, 3> periodic_;
};

class CylinderContainer final : public Primitive {
 public:
  CylinderContainer(const Vec3& center, int axis, double radius, double length, bool periodic)
      : center_(center), axis_(axis), radius_(radius), length_(length), periodic_(periodic) {
    lo_ = center[axis] - 0.5 * length;
    hi_ = center[axis] + 0.5 * length;
    form_.center = center;
    form_.across = Vec3::Ones() - Vec3(Vec3::Unit(axis));
    form_.radius = radius;
    if (!periodic) {
      form_.lo[axis] = lo_;
      form_.hi[axis] = hi_;
    }
  }

  Box bounds() const override {
    Box box{center_.array() - radius_, center_.array() + radius_};
    box.lo[axis_] = lo_;
    box.hi[axis_] = hi_;
    return box;
  }
  Vec3 period() const override { return periodic_ ? Vec3(length_ * Vec3::Unit(axis_)) : Vec3(Vec3::Zero()); }
  double volume() const override { return pi * radius_ * radius_ * length_; }

  std::string describe() const override {
    return std::string("cylinder along ") + axisName[axis_] + ", radius " + toText(radius_) + " µm, length " +
           toText(length_) + " µm, " + (periodic_ ? "periodic" : "closed") + " ends";
  }

  TriangleMesh surface() const override {
    TriangleMesh mesh;
    const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3, n = circleSides;
    const double outer = radius_ / std::cos(pi / n);
    for (const double end : {lo_, hi_}) {
      Vec3 middle = center_;
      middle[axis_] = end;
      for (int k = 0; k < n; ++k) {
        Vec3 p = middle;
        p[u] += outer * std::cos(2.0 * pi * k / n);
        p[v] += outer * std::sin(2.0 * pi * k / n);
        mesh.vertices.push_back(p);
      }
    }
    for (int k = 0; k < n; ++k) {
      const int next = (k + 1) % n;
      mesh.triangles.push_back({k, next, n + k});
      mesh.triangles.push_back({next, n + next, n + k});
    }
    mesh.vertices.push_back(center_);
    mesh.vertices.back()[axis_] = lo_;
    mesh.vertices.push_back(center_);
    mesh.vertices.back()[axis_] = hi_;
    for (int k = 0; k < n; ++k) {
      mesh.triangles.push_back({2 * n, (k + 1) % n, k});
      mesh.triangles.push_back({2 * n + 1, n + k, n + (k + 1) % n});
    }
    return mesh;
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    return verdictInConvex(*this, cell, gapOfInterest, [&](const Vec3& v) {
      Vec3 radial = v - center_;
      radial[axis_] = 0.0;
      return radial.squaredNorm() < (1.0 - rounding) * radius_ * radius_ &&
             (periodic_ || (v[axis_] > lo_ && v[axis_] < hi_));
    });
  }

 private:
  Vec3 center_;
  int axis_;
  double radius_, length_, lo_, hi_;
  bool periodic_;
};

class SphereContainer final : public Primitive {
 public:
  SphereContainer(const Vec3& center, double radius) : center_(center), radius_(radius) {
    form_.center = center;
    form_.across = Vec3::Ones();
    form_.radius = radius;
  }

  Box bounds() const override { return {center_.array() - radius_, center_.array() + radius_}; }
  Vec3 period() const override { return Vec3::Zero(); }
  double volume() const override { return 4.0 / 3.0 * pi * radius_ * radius_ * radius_; }
  std::string describe() const override { return "sphere, radius " + toText(radius_) + " µm"; }

  TriangleMesh surface() const override {
    // An icosahedron: the corners of three golden rectangles.
    const double g = 0.5 * (1.0 + std::sqrt(5.0));
    TriangleMesh mesh;
    for (const double s : {-1.0, 1.0})
      for (const double t : {-g, g})
        for (const Vec3& v : {Vec3(0.0, s, t), Vec3(s, t, 0.0), Vec3(t, 0.0, s)})
          mesh.vertices.push_back(v.normalized());
    const double edge = 2.0 / std::sqrt(1.0 + g * g);
    const auto joined = [&](int i, int j) {
      return (mesh.vertices[i] - mesh.vertices[j]).norm() < 1.1 * edge;
    };
    for (int i = 0; i < 12; ++i)
      for (int j = i + 1; j < 12; ++j)
        for (int k = j + 1; k < 12; ++k)
          if (joined(i, j) && joined(j, k) && joined(k, i)) {
            const bool outward = mesh.vertices[i].dot(mesh.vertices[j].cross(mesh.vertices[k])) > 0.0;
            mesh.triangles.push_back(outward ? Triangle{i, j, k} : Triangle{i, k, j});
          }
    for (int level = 0; level < sphereLevels; ++level) refine(mesh);
    double innermost = 1.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const int n = static_cast<int>(t);
      const Vec3 normal =
          (mesh.corner(n, 1) - mesh.corner(n, 0)).cross(mesh.corner(n, 2) - mesh.corner(n, 0)).normalized();
      innermost = std::min(innermost, normal.dot(mesh.corner(n, 0)));
    }
    for (Vec3& v : mesh.vertices) v = center_ + radius_ / innermost * v;
    return mesh;
  }

  WallVerdict examine(const PlacedHierarchy& cell, double gapOfInterest) const override {
    return verdictInConvex(*this, cell, gapOfInterest, [&](const Vec3& v) {
      return (v - center_).squaredNorm() < (1.0 - rounding) * radius_ * radius_;
    });
  }

 private:
  /// Divides every triangle of a mesh on the unit sphere into four.
  static void refine(TriangleMesh& mesh) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int i, int j) {
      const auto [entry, isNew] = middles.insert({std::minmax(i, j), static_cast<int>(mesh.vertices.size())});
      if (isNew) mesh.vertices.push_back((mesh.vertices[i] + mesh.vertices[j]).normalized());
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (const Triangle& t : mesh.triangles) {
      const int d = middle(t[0], t[1]), e = middle(t[1], t[2]), f = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], d, f}, {d, t[1], e}, {f, e, t[2]}, {d, e, f}});
    }
    mesh.triangles = std::move(finer);
  }

  Vec3 center_;
  double radius_;
};

}  // namespace

std::unique_ptr<Container> makeBox(const Box& box, const std::array<bool, 3>& periodic) {
  for (int k = 0; k < 3; ++k) {
    requirePositive(box.hi[k] - box.lo[k], std::string("the side of the box along ") + axisName[k]);
    if (!std::isfinite(box.lo[k])) throw InputError("the position of the box must be finite");
  }
  return std::make_unique<BoxContainer>(box, periodic);
}

std::unique_ptr<Container> makeCylinder(const Vec3& center, int axis, double radius, double length,
                                        bool periodicEnds) {
  if (axis < 0 || axis > 2)
    throw InputError("the axis of the cylinder must be 0, 1 or 2; found " + std::to_string(axis));
  requirePositive(radius, "the radius of the cylinder");
  requirePositive(length, "the length of the cylinder");
  if (!center.allFinite()) throw InputError("the position of the cylinder must be finite");
  return std::make_unique<CylinderContainer>(center, axis, radius, length, periodicEnds);
}

std::unique_ptr<Container> makeSphere(const Vec3& center, double radius) {
  requirePositive(radius, "the radius of the sphere");
  if (!center.allFinite()) throw InputError("the position of the sphere must be finite");
  return std::make_unique<SphereContainer>(center, radius);
}

}  // namespace packmesh
