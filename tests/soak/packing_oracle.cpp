// SPDX-License-Identifier: AGPL-3.0-or-later
// Examines packings by brute force: every triangle against every triangle, in long double, with none of
// packMesh's predicates, hierarchies or walls. Only the templates of HemoCell's own cells are the library's
// (tests compare those with HemoCell's). Reads a description from standard input, a line each:
//
//   period x y z                         [µm], 0: none
//   clearance c                          between membranes [µm]
//   inside|outside box lo hi             a body that cells are inside or outside of, `lo hi` six numbers
//   [µm]; inside|outside cylinder axis center radius length      beyond 1e17: no wall there inside|outside
//   sphere center radius inside|outside mesh file.off species pos model name dx wall       the cells of a
//   .pos file: of HemoCell's template, species pos ellipsoid e1 e2 e3 wall  of an ellipsoid, species pos mesh
//   file.off scale wall of a mesh; each `wall` µm from bodies
//
// Prints the number and the mesh volume of each species, then faults; exit code 4 if there are any.
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/cell_model.h"

namespace {

using Real = long double;
using Point = std::array<Real, 3>;

Point operator-(const Point& a, const Point& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Point operator+(const Point& a, const Point& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Point operator*(Real s, const Point& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
Real dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real norm(const Point& a) {
  return std::sqrt(dot(a, a));
}
Real volume(const Point& a, const Point& b, const Point& c, const Point& d) {
  return dot(cross(b - a, c - a), d - a);
}

struct Range {
  Point lo, hi;
  bool meets(const Range& other, Real margin) const {
    for (int k = 0; k < 3; ++k)
      if (lo[k] > other.hi[k] + margin || other.lo[k] > hi[k] + margin) return false;
    return true;
  }
};

struct Mesh {
  std::vector<Point> points;
  std::vector<std::array<int, 3>> triangles;

  std::array<Point, 3> corners(std::size_t t) const {
    return {points[triangles[t][0]], points[triangles[t][1]], points[triangles[t][2]]};
  }
  Real sixVolumes() const {
    Real sum = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const auto c = corners(t);
      sum += dot(c[0], cross(c[1], c[2]));
    }
    return std::abs(sum);
  }
};

Range rangeOf(const Point* points, std::size_t count) {
  Range range{points[0], points[0]};
  for (std::size_t i = 1; i < count; ++i)
    for (int k = 0; k < 3; ++k) {
      range.lo[k] = std::min(range.lo[k], points[i][k]);
      range.hi[k] = std::max(range.hi[k], points[i][k]);
    }
  return range;
}

/// Whether the segment from p to q meets the triangle; touching counts.
bool pierces(const Point& p, const Point& q, const std::array<Point, 3>& t) {
  const Real below = volume(t[0], t[1], t[2], p), above = volume(t[0], t[1], t[2], q);
  if ((below > 0 && above > 0) || (below < 0 && above < 0)) return false;
  if (below == 0 && above == 0) return true;  // coplanar: with real packings, never by chance
  const Real a = volume(p, q, t[0], t[1]), b = volume(p, q, t[1], t[2]), c = volume(p, q, t[2], t[0]);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

bool meet(const std::array<Point, 3>& a, const std::array<Point, 3>& b) {
  for (int k = 0; k < 3; ++k)
    if (pierces(a[k], a[(k + 1) % 3], b) || pierces(b[k], b[(k + 1) % 3], a)) return true;
  return false;
}

Real clamp01(Real t) {
  return std::min<Real>(1, std::max<Real>(0, t));
}

Real pointToSegment(const Point& p, const Point& a, const Point& b) {
  const Point d = b - a;
  const Real length = dot(d, d);
  return norm(p - (a + (length > 0 ? clamp01(dot(p - a, d) / length) : 0) * d));
}

Real segmentToSegment(const Point& a, const Point& b, const Point& c, const Point& d) {
  Real least = std::min(
      {pointToSegment(a, c, d), pointToSegment(b, c, d), pointToSegment(c, a, b), pointToSegment(d, a, b)});
  const Point u = b - a, v = d - c, n = cross(u, v), w = c - a;
  const Real size = dot(n, n);
  if (size > 0) {
    const Real s = dot(cross(w, v), n) / size, t = dot(cross(w, u), n) / size;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) least = std::min(least, std::abs(dot(w, n)) / std::sqrt(size));
  }
  return least;
}

Real pointToTriangle(const Point& p, const std::array<Point, 3>& t) {
  const Point n = cross(t[1] - t[0], t[2] - t[0]);
  const Real size = dot(n, n);
  bool over = size > 0;
  for (int k = 0; over && k < 3; ++k) over = dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), n) >= 0;
  if (over) return std::abs(dot(p - t[0], n)) / std::sqrt(size);
  return std::min(
      {pointToSegment(p, t[0], t[1]), pointToSegment(p, t[1], t[2]), pointToSegment(p, t[2], t[0])});
}

/// Of triangles that do not meet.
Real distance(const std::array<Point, 3>& a, const std::array<Point, 3>& b) {
  Real least = std::numeric_limits<Real>::infinity();
  for (int i = 0; i < 3; ++i) {
    least = std::min({least, pointToTriangle(a[i], b), pointToTriangle(b[i], a)});
    for (int j = 0; j < 3; ++j)
      least = std::min(least, segmentToSegment(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]));
  }
  return least;
}

/// By counting crossings of a ray in an odd direction.
bool inside(const Point& p, const Mesh& mesh) {
  const Point far = p + 1e6L * Point{0.5377L, 0.8339L, 0.1241L};
  int crossings = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) crossings += pierces(p, far, mesh.corners(t));
  return crossings % 2 == 1;
}

/// A mesh in its place, with the boxes of its triangles.
struct Body {
  Mesh mesh;
  Range range;
  std::vector<Range> ranges;

  explicit Body(Mesh placed) : mesh(std::move(placed)) {
    range = rangeOf(mesh.points.data(), mesh.points.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto c = mesh.corners(t);
      ranges.push_back(rangeOf(c.data(), 3));
    }
  }
};

Body shifted(const Body& body, const Point& by) {
  Mesh mesh = body.mesh;
  for (Point& p : mesh.points) p = p + by;
  return Body(std::move(mesh));
}

/// What two surfaces do to each other; distances from `clearance` on are not looked for.
enum class Fault { none, meet, near };
Fault between(const Body& a, const Body& b, Real clearance, Real& gap) {
  std::vector<std::size_t> of;
  for (std::size_t t = 0; t < b.ranges.size(); ++t)
    if (b.ranges[t].meets(a.range, clearance)) of.push_back(t);
  gap = std::numeric_limits<Real>::infinity();
  for (std::size_t s = 0; s < a.ranges.size(); ++s) {
    if (!a.ranges[s].meets(b.range, clearance)) continue;
    for (const std::size_t t : of) {
      if (!a.ranges[s].meets(b.ranges[t], clearance)) continue;
      const auto first = a.mesh.corners(s), second = b.mesh.corners(t);
      if (meet(first, second)) return Fault::meet;
      if (clearance > 0) gap = std::min(gap, distance(first, second));
    }
  }
  return gap < clearance - 1e-9L ? Fault::near : Fault::none;  // what the certificate rounds by is far below
}

/// What cells have to be inside or outside of.
struct Obstacle {
  bool outside = false;
  std::string kind;
  Point lo{}, hi{}, center{};
  int axis = 0;
  Real radius = 0, length = 0;
  std::vector<Body> body;  ///< one: a mesh

  /// From a sphere, or a cylinder that is longer than where cells are.
  Real distanceFrom(const std::array<Point, 3>& triangle) const {
    if (kind == "sphere") return pointToTriangle(center, triangle) - radius;
    if (kind != "cylinder") throw std::runtime_error("an obstacle that is a box has to be given as a mesh");
    Point a = center, b = center;
    a[axis] -= length / 2, b[axis] += length / 2;
    if (pierces(a, b, triangle)) return -radius;
    Real least = std::min(pointToTriangle(a, triangle), pointToTriangle(b, triangle));
    for (int k = 0; k < 3; ++k)
      least = std::min(least, segmentToSegment(a, b, triangle[k], triangle[(k + 1) % 3]));
    return least - radius;
  }

  /// How far p is inside; below 0: it is not.
  Real allowance(const Point& p) const {
    Real in = std::numeric_limits<Real>::infinity();
    if (kind == "box") {
      for (int k = 0; k < 3; ++k) in = std::min({in, p[k] - lo[k], hi[k] - p[k]});
    } else if (kind == "sphere") {
      in = radius - norm(p - center);
    } else {
      Point d = p - center;
      const Real along = std::abs(d[axis]);
      d[axis] = 0;
      in = std::min(radius - norm(d), length > 1e17L ? in : length / 2 - along);
    }
    return in;
  }
};

Mesh readOff(const std::string& file) {
  std::ifstream in(file);
  std::string word;
  std::size_t points = 0, triangles = 0, edges = 0;
  if (!(in >> word >> points >> triangles >> edges) || word != "OFF")
    throw std::runtime_error(file + ": no OFF");
  Mesh mesh;
  mesh.points.resize(points);
  for (Point& p : mesh.points) {
    double x, y, z;
    in >> x >> y >> z;
    p = {x, y, z};
  }
  mesh.triangles.resize(triangles);
  for (auto& t : mesh.triangles) in >> points >> t[0] >> t[1] >> t[2];
  if (!in) throw std::runtime_error(file + ": ends early");
  return mesh;
}

Mesh fromLibrary(const packmesh::TriangleMesh& from) {
  Mesh mesh;
  for (const auto& p : from.vertices) mesh.points.push_back({p.x(), p.y(), p.z()});
  for (const auto& t : from.triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  return mesh;
}

/// As packMesh's documentation says: the middle of the bounding box is the origin.
Mesh centred(Mesh mesh, Real scale) {
  const Range range = rangeOf(mesh.points.data(), mesh.points.size());
  const Point middle = 0.5L * (range.lo + range.hi);
  for (Point& p : mesh.points) p = scale * (p - middle);
  return mesh;
}

/// Rz(c) Ry(b) Rx(a) v + x, one axis after the other.
Mesh placed(const Mesh& mesh, const std::array<double, 6>& line) {
  Mesh result = mesh;
  for (Point& p : result.points) {
    for (int axis = 0; axis < 3; ++axis) {
      const Real angle = line[3 + axis] * std::acos(-1.0L) / 180, s = std::sin(angle), c = std::cos(angle);
      Real &u = p[(axis + 1) % 3], &v = p[(axis + 2) % 3];
      const Real turned = c * u - s * v;
      v = s * u + c * v;
      u = turned;
    }
    p = p + Point{line[0], line[1], line[2]};
  }
  return result;
}

struct Cell {
  std::string name;
  Body body;
  Real wall;
};

int faults = 0;
void fault(const std::string& text) {
  std::cout << "fault: " << text << '\n';
  ++faults;
}

void examineWall(const Cell& cell, const Obstacle& o, const Point& period) {
  if (o.body.empty()) {
    // Bodies stand once; walls of a lumen with a period are unbounded along it, obstacles may repeat.
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k) {
          const Point shift{i * period[0], j * period[1], k * period[2]};
          if ((i && period[0] == 0) || (j && period[1] == 0) || (k && period[2] == 0)) continue;
          if (!o.outside && (i || j || k)) continue;
          Real least = std::numeric_limits<Real>::infinity();
          if (o.outside) {
            const Mesh& mesh = cell.body.mesh;
            for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
              auto corners = mesh.corners(t);
              for (Point& p : corners) p = p + shift;
              least = std::min(least, o.distanceFrom(corners));
            }
          } else {  // all of them are convex
            for (const Point& p : cell.body.mesh.points) least = std::min(least, o.allowance(p));
          }
          if (least < cell.wall - 1e-9L)
            fault(cell.name + " is " + std::to_string(double(least)) + " µm within the " + o.kind);
        }
    return;
  }
  const Body& wall = o.body.front();
  Real gap = 0;
  const Fault found = between(cell.body, wall, cell.wall, gap);
  if (found == Fault::meet) fault(cell.name + " meets the mesh of the wall");
  if (found == Fault::near) fault(cell.name + " is " + std::to_string(double(gap)) + " µm from the wall");
  if (found == Fault::none && inside(cell.body.mesh.points.front(), wall.mesh) == o.outside)
    fault(cell.name + " is on the wrong side of the wall");
}

void examinePair(const Cell& a, const Cell& b, Real clearance, const Point& period, bool self) {
  int reach[3];
  for (int k = 0; k < 3; ++k) {
    reach[k] = 0;
    if (period[k] > 0)
      reach[k] = 2 + int((a.body.range.hi[k] - a.body.range.lo[k] + b.body.range.hi[k] - b.body.range.lo[k]) /
                         period[k]);
  }
  Point home{};  // brings b next to a
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0)
      home[k] = period[k] * std::round((a.body.range.lo[k] - b.body.range.lo[k]) / period[k]);
  for (int i = -reach[0]; i <= reach[0]; ++i)
    for (int j = -reach[1]; j <= reach[1]; ++j)
      for (int k = -reach[2]; k <= reach[2]; ++k) {
        if (self && !i && !j && !k) continue;
        const Point shift = home + Point{i * period[0], j * period[1], k * period[2]};
        const Range range{b.body.range.lo + shift, b.body.range.hi + shift};
        if (!a.body.range.meets(range, clearance)) continue;
        const Body image = shifted(b.body, shift);
        Real gap = 0;
        const Fault found = between(a.body, image, clearance, gap);
        if (found == Fault::meet) fault(a.name + " and " + b.name + " meet");
        if (found == Fault::near)
          fault(a.name + " and " + b.name + " are " + std::to_string(double(gap)) + " µm apart");
        if (found == Fault::none && (inside(a.body.mesh.points.front(), image.mesh) ||
                                     inside(image.mesh.points.front(), a.body.mesh)))
          fault("one of " + a.name + " and " + b.name + " is inside the other");
      }
}

Mesh templateOf(std::istream& in, const std::string& kind) {
  if (kind == "model") {
    std::string name;
    double dx;
    in >> name >> dx;
    return fromLibrary(packmesh::hemocell::buildTemplate(packmesh::hemocell::defaultModel(name).value(), dx));
  }
  if (kind == "ellipsoid") {
    double e1, e2, e3;
    in >> e1 >> e2 >> e3;
    return fromLibrary(packmesh::hemocell::makeEllipsoid(e1, e2, e3)->mesh());
  }
  std::string file;
  double scale;
  in >> file >> scale;
  return centred(readOff(file), scale);
}

}  // namespace

int main() try {
  Point period{};
  Real clearance = 0;
  std::vector<Obstacle> obstacles;
  std::vector<Cell> cells;
  std::cout.precision(17);
  for (std::string text, word; std::getline(std::cin, text);) {
    std::istringstream in(text);
    if (!(in >> word)) continue;
    if (word == "period") {
      in >> period[0] >> period[1] >> period[2];
    } else if (word == "clearance") {
      in >> clearance;
    } else if (word == "inside" || word == "outside") {
      Obstacle o;
      o.outside = word == "outside";
      in >> o.kind;
      const auto point = [&](Point& p) { in >> p[0] >> p[1] >> p[2]; };
      if (o.kind == "box") {
        point(o.lo), point(o.hi);
      } else if (o.kind == "cylinder") {
        in >> o.axis, point(o.center), in >> o.radius >> o.length;
      } else if (o.kind == "sphere") {
        point(o.center), in >> o.radius;
      } else {
        in >> word;
        o.body.emplace_back(readOff(word));
      }
      obstacles.push_back(std::move(o));
    } else {
      std::string file, kind;
      in >> file >> kind;
      const Mesh mesh = templateOf(in, kind);
      Real wall = 0;
      in >> wall;
      std::ifstream pos(file);
      long announced = 0, count = 0;  // no file: none of these cells
      pos >> announced;
      for (std::array<double, 6> line; pos >> line[0] >> line[1] >> line[2] >> line[3] >> line[4] >> line[5];
           ++count)
        cells.push_back({file + ":" + std::to_string(count + 2), Body(placed(mesh, line)), wall});
      if (announced != count) fault(file + " announces " + std::to_string(announced) + " cells");
      std::cout << file << ' ' << count << ' ' << double(mesh.sixVolumes() / 6) << '\n';
    }
    if (!in) throw std::runtime_error("not understood: " + text);
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const Obstacle& o : obstacles) examineWall(cells[i], o, period);
    for (std::size_t j = i; j < cells.size(); ++j) examinePair(cells[i], cells[j], clearance, period, i == j);
  }
  return faults > 0 ? 4 : 0;
} catch (const std::exception& error) {
  std::cout << "fault: " << error.what() << '\n';
  return 4;
}
