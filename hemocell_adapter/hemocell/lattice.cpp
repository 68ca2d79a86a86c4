// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/hemocell/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// out &= in shifted by `shift` bits (positive: towards higher nodes), with ones shifted in at both ends.
void andShifted(std::vector<std::uint64_t>& out, const std::vector<std::uint64_t>& in, int shift) {
  const int count = static_cast<int>(in.size());
  const auto word = [&](int w) { return w < 0 || w >= count ? allBits : in[w]; };
  const int words = (shift >= 0 ? shift : shift - 63) / 64, bits = shift - 64 * words;  // bits in 0..63
  for (int w = 0; w < count; ++w)
    out[w] &= bits == 0 ? word(w - words) : word(w - words) << bits | word(w - words - 1) >> (64 - bits);
}

}  // namespace

Lattice::Lattice(std::array<int, 3> nodes, double dx) : nodes_(nodes), dx_(dx), wordsPerRow_(0) {
  if (!(dx > 0.0) || !std::isfinite(dx))
    throw InputError(fmt::format("lattice spacing {} µm: expected a positive length", dx));
  double count = 1.0;
  for (int n : nodes) {
    if (n < 1)
      throw InputError(fmt::format("a lattice of {} x {} x {} nodes: expected at least one on every axis",
                                   nodes[0], nodes[1], nodes[2]));
    count *= n;
  }
  if (count > mostNodes)
    throw InputError(fmt::format("a lattice of {} x {} x {} nodes: expected at most 2^31 in total", nodes[0],
                                 nodes[1], nodes[2]));
  wordsPerRow_ = (nodes[0] + 63) / 64;
  words_.resize(static_cast<std::size_t>(wordsPerRow_) * nodes[1] * nodes[2]);
  for (std::size_t w = 0; w < words_.size(); ++w)
    words_[w] = usedBits(nodes[0], static_cast<int>(w % wordsPerRow_));
}

void Lattice::setFluid(int i, int j, int k, bool fluid) {
  setFluid(i, i, j, k, fluid);
}

void Lattice::setFluid(int from, int to, int j, int k, bool fluid) {
  from = std::max(from, 0);
  to = std::min(to, nodes_[0] - 1);
  if (from > to) return;
  std::uint64_t* words = &words_[rowStart(j, k)];
  for (int w = from >> 6; w <= to >> 6; ++w) {
    std::uint64_t bits = allBits;
    if (w == from >> 6) bits &= allBits << (from & 63);
    if (w == to >> 6) bits &= allBits >> (63 - (to & 63));
    words[w] = fluid ? words[w] | bits : words[w] & ~bits;
  }
}

std::int64_t Lattice::fluidNodes() const {
  std::int64_t count = 0;
  for (std::uint64_t word : words_) count += __builtin_popcountll(word);
  return count;
}

bool Lattice::hasFluidNodes() const {
  return std::any_of(words_.begin(), words_.end(), [](std::uint64_t word) { return word != 0; });
}

std::optional<std::array<std::array<int, 3>, 2>> Lattice::fluidRange() const {
  std::array<int, 3> first = nodes_, last = {-1, -1, -1};
  for (int k = 0; k < nodes_[2]; ++k)
    for (int j = 0; j < nodes_[1]; ++j)
      for (int w = 0; w < wordsPerRow_; ++w) {
        const std::uint64_t bits = word(w, j, k);
        if (bits == 0) continue;
        const std::array<int, 3> low = {64 * w + __builtin_ctzll(bits), j, k},
                                 high = {64 * w + 63 - __builtin_clzll(bits), j, k};
        for (int a = 0; a < 3; ++a) {
          first[a] = std::min(first[a], low[a]);
          last[a] = std::max(last[a], high[a]);
        }
      }
  if (last[0] < 0) return {};
  return std::array<std::array<int, 3>, 2>{first, last};
}

double Lattice::fluidVolume() const {
  return static_cast<double>(fluidNodes()) * dx_ * dx_ * dx_;
}

Lattice Lattice::eroded(int radius) const {
  Lattice out = *this;
  if (radius <= 0) return out;
  const auto [nx, ny, nz] = nodes_;
  // One axis after the other, since the cube is the product of three intervals.
  std::vector<std::uint64_t> before(wordsPerRow_), after(wordsPerRow_);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j) {
      for (int w = 0; w < wordsPerRow_; ++w) before[w] = row(j, k)[w] | ~usedBits(nx, w);
      after = before;
      for (int shift = 1; shift <= std::min(radius, nx); ++shift) {
        andShifted(after, before, shift);
        andShifted(after, before, -shift);
      }
      for (int w = 0; w < wordsPerRow_; ++w) out.words_[rowStart(j, k) + w] = after[w] & usedBits(nx, w);
    }
  for (int axis = 1; axis <= 2; ++axis) {
    const Lattice in = out;
    for (int k = 0; k < nz; ++k)
      for (int j = 0; j < ny; ++j) {
        const int at = axis == 1 ? j : k;
        std::uint64_t* words = &out.words_[rowStart(j, k)];
        for (int other = std::max(0, at - radius); other <= std::min(nodes_[axis] - 1, at + radius);
             ++other) {
          const std::uint64_t* row = axis == 1 ? in.row(other, k) : in.row(j, other);
          for (int w = 0; w < wordsPerRow_; ++w) words[w] &= row[w];
        }
      }
  }
  return out;
}

Lattice Lattice::repeated(const std::array<int, 3>& margin) const {
  std::array<int, 3> extended = nodes_;
  for (int k = 0; k < 3; ++k) extended[k] += 2 * margin[k];
  Lattice out(extended, dx_);
  const auto wrapped = [&](int i, int k) { return (((i - margin[k]) % nodes_[k]) + nodes_[k]) % nodes_[k]; };
  for (int k = 0; k < extended[2]; ++k)
    for (int j = 0; j < extended[1]; ++j) {
      const std::uint64_t* from = row(wrapped(j, 1), wrapped(k, 2));
      for (int w = 0; w < out.wordsPerRow_; ++w) {
        const int count = std::min(64, extended[0] - 64 * w);
        std::uint64_t& to = out.words_[out.rowStart(j, k) + w] = 0;
        for (int bit = 0; bit < count;) {  // runs of bits that lie in one word of this lattice
          const int i = wrapped(64 * w + bit, 0), run = std::min({count - bit, nodes_[0] - i, 64 - (i & 63)});
          to |= (from[i >> 6] >> (i & 63) & usedBits(run, 0)) << bit;
          bit += run;
        }
      }
    }
  return out;
}

void inflate(TriangleMesh& mesh, double distance) {
  std::vector<std::vector<int>> faces(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int v : mesh.triangles[t]) faces[v].push_back(static_cast<int>(t));
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    Vec3 sum = Vec3::Zero();
    for (int t : faces[v]) {
      const Vec3& a = mesh.corner(t, 0);
      sum += (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).normalized();
    }
    mesh.vertices[v] += distance * sum.normalized();
  }
}

// Conversion of an STL to fluid nodes, as in HemoCell (Palabos).

namespace {

/// One node beyond the surface on each side, and the one at which the extent starts.
constexpr int extraNodes = 3;

/// Point where a surface crosses the row of nodes (row % ny, row / ny).
struct Crossing {
  std::int64_t row;
  double x;
  int winding;  ///< change of the number of times that the surface encloses a point, towards +x
  bool operator<(const Crossing& other) const { return row != other.row ? row < other.row : x < other.x; }
};

/// The integers in (lo, hi], clipped to 0..last: those for which exactly one of lo, hi counts as "not above".
struct Planes {
  Planes(double lo, double hi, int highest)
      : first(static_cast<int>(std::clamp(std::floor(lo) + 1.0, 0.0, highest + 1.0))),
        last(static_cast<int>(std::clamp(std::floor(hi), -1.0, double(highest)))) {}
  int first, last;
};

std::vector<Crossing> crossingsOf(const TriangleMesh& surface, int ny, int nz) {
  std::vector<Crossing> crossings;
  for (const Triangle& t : surface.triangles) {
    const Vec3 *a = &surface.vertices[t[0]], *b = &surface.vertices[t[1]], *c = &surface.vertices[t[2]];
    const int winding = (*b - *a).cross(*c - *a).x() < 0.0 ? 1 : -1;
    const Planes planes(std::min({a->z(), b->z(), c->z()}), std::max({a->z(), b->z(), c->z()}), nz - 1);
    for (int k = planes.first; k <= planes.last; ++k) {
      // The intersection of the triangle with the plane z = k: the two points where its edges cross. Both
      // triangles at an edge compute the same point from the same vertices in the same order, so that
      // sections close exactly.
      Vec3 ends[2];
      int found = 0;
      for (int e = 0; e < 3; ++e) {
        const int low = std::min(t[e], t[(e + 1) % 3]), high = std::max(t[e], t[(e + 1) % 3]);
        const Vec3 &p = surface.vertices[low], &q = surface.vertices[high];
        if ((p.z() < k) == (q.z() < k)) continue;
        ends[found++] = p + (k - p.z()) / (q.z() - p.z()) * (q - p);
      }
      if (found != 2) continue;
      const Vec3 &p = ends[0], &q = ends[1];
      const Planes rows(std::min(p.y(), q.y()), std::max(p.y(), q.y()), ny - 1);
      for (int j = rows.first; j <= rows.last; ++j)
        if ((p.y() < j) != (q.y() < j))
          crossings.push_back(
              {j + std::int64_t(ny) * k, p.x() + (j - p.y()) / (q.y() - p.y()) * (q.x() - p.x()), winding});
    }
  }
  return crossings;
}

/// Orients triangles consistently, as HemoCell does: like the first one of each part.
void orientLikeFirst(TriangleMesh& mesh) {
  const std::vector<TriangleSide> sides = sortedSides(mesh);
  struct Neighbour {
    int triangle;
    bool agrees;
  };
  std::vector<std::vector<Neighbour>> neighbours(mesh.triangles.size());
  for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
    const TriangleSide &a = sides[s], &b = sides[s + 1];
    if (!a.sameEdge(b)) continue;
    neighbours[a.triangle].push_back({b.triangle, a.forwards != b.forwards});
    neighbours[b.triangle].push_back({a.triangle, a.forwards != b.forwards});
  }
  enum State : char { unseen, kept, turned };
  std::vector<char> state(mesh.triangles.size(), unseen);
  for (std::size_t seed = 0; seed < state.size(); ++seed) {
    if (state[seed] != unseen) continue;
    state[seed] = kept;
    std::vector<int> reached{static_cast<int>(seed)};
    for (std::size_t k = 0; k < reached.size(); ++k)
      for (const Neighbour& next : neighbours[reached[k]]) {
        if (state[next.triangle] != unseen) continue;
        const bool turn = (state[reached[k]] == turned) == next.agrees;
        state[next.triangle] = turn ? turned : kept;
        reached.push_back(next.triangle);
      }
  }
  for (std::size_t t = 0; t < state.size(); ++t)
    if (state[t] == turned) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
}

/// HemoCell opens the two ends along x by copying planes, in place and in this order.
void openEnds(Lattice& lattice) {
  const auto [nx, ny, nz] = lattice.nodes();
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (const auto& [to, from] :
           {std::pair(0, 1), std::pair(1, 2), std::pair(nx - 2, nx - 3), std::pair(nx - 1, nx - 2)})
        lattice.setFluid(to, j, k, lattice.fluid(from, j, k));
}

}  // namespace

void fillInside(Lattice& lattice, const TriangleMesh& surface) {
  const auto [nx, ny, nz] = lattice.nodes();
  std::vector<Crossing> crossings = crossingsOf(surface, ny, nz);
  std::sort(crossings.begin(), crossings.end());
  // In pairs: every closed section crosses a row an even number of times.
  for (std::size_t c = 0; c + 1 < crossings.size(); c += 2) {
    const double first = std::clamp(std::ceil(crossings[c].x), 0.0, double(nx));
    const double last = std::clamp(std::floor(crossings[c + 1].x), -1.0, nx - 1.0);
    lattice.setFluid(static_cast<int>(first), static_cast<int>(last), static_cast<int>(crossings[c].row % ny),
                     static_cast<int>(crossings[c].row / ny), true);
  }
}

double enclosedVolume(const TriangleMesh& surface) {
  const Vec3 highest = boundingBox(surface).hi.array().ceil();
  std::vector<Crossing> crossings = crossingsOf(surface, int(highest.y()) + 1, int(highest.z()) + 1);
  std::sort(crossings.begin(), crossings.end());
  double volume = 0.0;
  int times = 0;
  for (std::size_t c = 0; c + 1 < crossings.size(); ++c) {
    times += crossings[c].winding;
    if (crossings[c + 1].row == crossings[c].row)
      volume += std::abs(times) * (crossings[c + 1].x - crossings[c].x);
    else
      times = 0;  // it is, up to rounding
  }
  return volume;
}

bool isFilledByParity(const TriangleMesh& mesh) {
  const std::vector<TriangleSide> sides = sortedSides(mesh);
  for (std::size_t from = 0, to = 0; from < sides.size(); from = to) {
    for (to = from; to < sides.size() && sides[to].sameEdge(sides[from]);) ++to;
    if ((to - from) % 2 != 0) return false;
  }
  return true;
}

VesselOnLattice placeVessel(TriangleMesh stl, double dx, int refDir, int refDirN,
                            const TriangleMesh* asRead) {
  if (refDir < 0 || refDir > 2)
    throw InputError(fmt::format("<refDir> {}: expected 0, 1 or 2 (x, y or z)", refDir));
  if (refDirN < 1) throw InputError(fmt::format("<refDirN> {}: expected at least one node", refDirN));
  const Box box = boundingBox(stl);
  if (box.empty() || !box.size().allFinite() || !(box.size().minCoeff() > 0.0))
    throw InputError("the vessel is flat: its extent along an axis is 0");

  const double scale = refDirN / box.size()[refDir];
  const auto toLattice = [&](TriangleMesh& mesh) {
    for (Vec3& v : mesh.vertices) v = ((v - box.lo) * scale).array() + 1.0;
  };
  toLattice(stl);
  TriangleMesh inflated = asRead ? *asRead : stl;
  if (asRead) {
    toLattice(inflated);
    orientLikeFirst(inflated);
  }
  inflate(inflated, inflation);
  const Vec3 extent = boundingBox(inflated).size();
  std::array<int, 3> nodes;
  double count = 1.0;
  for (int k = 0; k < 3; ++k) {
    const double n = std::floor(extent[k]) + extraNodes;
    count *= n;
    if (!(count <= mostNodes))
      throw InputError(
          fmt::format("<refDirN> {} along {} gives a lattice of more than 2^31 nodes (the vessel is {:.4g} x "
                      "{:.4g} x {:.4g} in units of its file)",
                      refDirN, "xyz"[refDir], box.size().x(), box.size().y(), box.size().z()));
    nodes[k] = static_cast<int>(n);
  }

  VesselOnLattice vessel{std::move(stl), Lattice(nodes, dx), nodes[0] * dx};
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j) vessel.lattice.setFluid(0, nodes[0] - 1, j, k, false);
  fillInside(vessel.lattice, inflated);
  openEnds(vessel.lattice);
  for (Vec3& v : vessel.surface.vertices) v *= dx;
  return vessel;
}

}  // namespace packmesh::hemocell
