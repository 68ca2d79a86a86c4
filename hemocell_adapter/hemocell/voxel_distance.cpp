// SPDX-License-Identifier: AGPL-3.0-or-later
// Coordinates w are in nodes from the low corner of the lattice: node i is the interval [i, i+1] of w = p/dx
// + 1/2.
#include "hemocell_adapter/hemocell/voxel_distance.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "packMesh/field/sampled_distance.h"

namespace packmesh::hemocell {
namespace {

/// Edge of a brick, whose cells are half as large [nodes].
constexpr int brickNodes = BrickView::cells / 2;

int bricksAlong(int nodes) {
  return (nodes + brickNodes - 1) / brickNodes;
}

/// Nodes around a brick in which the nearest cube within farReach must lie, and the width of brick and
/// margins.
constexpr int margin = 3, windowNodes = brickNodes + 2 * margin;
/// Squared distances are cut off here, in units of (dx/2)²: farReach.
constexpr int codeLimit = 36;

/// Coarse samples are `step` nodes apart. For a single point at least fineReach - nearError nodes away, their
/// interpolation exceeds the distance by less than `error` nodes (measured, position by position in a cell);
/// distances to other sets have a smaller error.
struct Coarseness {
  double mostNodes;
  int step;
  double error;
};
constexpr Coarseness coarsenesses[] = {{4e6, 1, 0.15}, {1e8, 2, 0.6}, {1e300, 4, 2.0}};

const Coarseness& coarsenessOf(const std::array<int, 3>& nodes) {
  const double count = double(nodes[0]) * nodes[1] * nodes[2];
  const Coarseness* coarseness = coarsenesses;
  while (count > coarseness->mostNodes) ++coarseness;
  return *coarseness;
}

/// Squared distance along an axis from fine sample s of a brick to cube c of its windowNodes, in units of
/// (dx/2)².
constexpr int axisCode(int c, int s) {
  const int x = 2 * margin + s, low = 2 * c - x, high = x - 2 * c - 2;
  return low > 0 ? low * low : high > 0 ? high * high : 0;
}

constexpr int lanes = 16;  // fine samples along x, padded to the size of a vector register
struct Row {
  typedef std::uint8_t Bytes __attribute__((vector_size(lanes)));
  Bytes code;
};
Row filled(int code) {
  return {Row::Bytes{} + static_cast<std::uint8_t>(code)};
}

/// For each pattern of cubes in a row of a windowNodes: squared distances to the nearest cube, limited.
const std::vector<Row>& rowCodes() {
  static const std::vector<Row> table = [] {
    std::vector<Row> rows(1u << windowNodes);
    for (unsigned pattern = 0; pattern < rows.size(); ++pattern) {
      rows[pattern] = filled(codeLimit);
      for (int c = 0; c < windowNodes; ++c)
        if (pattern >> c & 1u)
          for (int s = 0; s < 9; ++s)
            rows[pattern].code[s] =
                static_cast<std::uint8_t>(std::min<int>(rows[pattern].code[s], axisCode(c, s)));
    }
    return rows;
  }();
  return table;
}

/// Element-wise minimum of `row` and `other` + more.
Row lowered(const Row& row, const Row& other, int more) {
  const Row::Bytes value = other.code + static_cast<std::uint8_t>(more);
  return {value < row.code ? value : row.code};
}

/// Flags of the nodes first ... first + windowNodes - 1 of a row as bits; 0 for nonexistent nodes.
unsigned patternOf(const Lattice& lattice, int first, int j, int k) {
  const std::array<int, 3> nodes = lattice.nodes();
  if (j < 0 || j >= nodes[1] || k < 0 || k >= nodes[2]) return 0;
  constexpr unsigned mask = (1u << windowNodes) - 1;
  if (first < 0) return static_cast<unsigned>(lattice.word(0, j, k) << -first) & mask;
  const int w = first >> 6, shift = first & 63;
  if (w >= lattice.wordsPerRow()) return 0;
  std::uint64_t bits = lattice.word(w, j, k) >> shift;
  if (shift > 64 - windowNodes && w + 1 < lattice.wordsPerRow())
    bits |= lattice.word(w + 1, j, k) << (64 - shift);
  return static_cast<unsigned>(bits) & mask;
}

using BrickCodes = std::array<std::array<Row, 9>, 9>;  // [z][y][x]

/// The cubes of a windowNodes closer than codeLimit to a sample of the brick, with their distances.
struct Near {
  int count = 0, cube[windowNodes] = {}, code[windowNodes] = {};
};
constexpr std::array<Near, 9> nearCubes() {
  std::array<Near, 9> all{};
  for (int s = 0; s < 9; ++s)
    for (int c = 0; c < windowNodes; ++c)
      if (const int code = axisCode(c, s); code < codeLimit) {
        all[s].cube[all[s].count] = c;
        all[s].code[all[s].count++] = code;
      }
  return all;
}

/// Squared distances of all samples of a brick to the nearest cube set in `patterns` (windowNodes rows
/// [k][j]).
BrickCodes codesOf(const std::array<std::array<unsigned, windowNodes>, windowNodes>& patterns) {
  static const std::vector<Row>& table = rowCodes();
  static constexpr std::array<Near, 9> near = nearCubes();
  const Row none = filled(codeLimit);
  std::array<std::array<Row, 9>, windowNodes> slices;
  bool empty[windowNodes];
  for (int k = 0; k < windowNodes; ++k) {
    empty[k] = true;
    for (int j = 0; j < windowNodes; ++j) empty[k] = empty[k] && patterns[k][j] == 0;
    if (empty[k]) continue;
    for (int y = 0; y < 9; ++y) {
      Row row = none;
      for (int n = 0; n < near[y].count; ++n)
        if (const unsigned pattern = patterns[k][near[y].cube[n]])
          row = lowered(row, table[pattern], near[y].code[n]);
      slices[k][y] = row;
    }
  }
  BrickCodes codes;
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 9; ++y) {
      Row row = none;
      for (int n = 0; n < near[z].count; ++n)
        if (const int k = near[z].cube[n]; !empty[k]) row = lowered(row, slices[k][y], near[z].code[n]);
      codes[z][y] = row;
    }
  return codes;
}

/// Distances [nodes] represented by the codes -codeLimit ... codeLimit.
struct Decoder {
  Decoder() {
    for (int code = -codeLimit; code <= codeLimit; ++code)
      distance[code + codeLimit] = static_cast<float>((code < 0 ? -0.5 : 0.5) * std::sqrt(std::abs(code)));
  }
  float distance[2 * codeLimit + 1];
};
const Decoder decoder;

/// Weights of the three nodes along an axis that quadratic B-splines have at a point, and their derivatives.
struct SplineWeights {
  int first;
  double value[3], slope[3];

  explicit SplineWeights(double u) : first(static_cast<int>(std::floor(u + 0.5)) - 1) {
    const double t = u - (first + 1);  // from the nearest node
    value[0] = 0.5 * (0.5 - t) * (0.5 - t), slope[0] = t - 0.5;
    value[1] = 0.75 - t * t, slope[1] = -2.0 * t;
    value[2] = 0.5 * (0.5 + t) * (0.5 + t), slope[2] = t + 0.5;
  }
};

/// The weight of a node at the corner of its cube.
constexpr double shareAtCorner = 0.125;
/// Between vertices, edges of a membrane come nearer to the cubes than the smoothed wall by less than this
/// [dx].
constexpr double smoothMargin = 0.15;

}  // namespace

double VoxelDistance::smoothReach() const {
  return (std::sqrt(2.0 * shareAtCorner) - smoothMargin) * dx_;
}

WallDistance VoxelDistance::smoothed(const Vec3& p) const {
  const SplineWeights x(p.x() / dx_), y(p.y() / dx_), z(p.z() / dx_);
  double share = 0.0;
  Vec3 slope = Vec3::Zero();  // per node
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j) {
      const unsigned solid = ~patternOf(inside_, x.first, y.first + j, z.first + k) & 7u;
      if (solid == 0) continue;
      double value = 0.0, along = 0.0;
      for (int i = 0; i < 3; ++i) {
        const double counts = solid >> i & 1u;
        value += counts * x.value[i];
        along += counts * x.slope[i];
      }
      share += value * y.value[j] * z.value[k];
      slope += Vec3(along * y.value[j] * z.value[k], value * y.slope[j] * z.value[k],
                    value * y.value[j] * z.slope[k]);
    }
  const double steepness = slope.norm();
  return {smoothReach() - std::sqrt(2.0 * share) * dx_,
          steepness > 0.0 ? Vec3(-slope / steepness) : Vec3(Vec3::Zero())};
}

VoxelDistance::VoxelDistance(const Lattice& inside)
    : dx_(inside.dx()),
      nodes_(inside.nodes()),
      inside_(inside),
      bricks_({bricksAlong(nodes_[0]), bricksAlong(nodes_[1]), bricksAlong(nodes_[2])}),
      farError_(coarsenessOf(inside.nodes()).error) {}

const std::int8_t* VoxelDistance::brick(const std::array<int, 3>& at) const {
  const int(&count)[3] = bricks_.count();
  return bricks_.at(at[0] + count[0] * (at[1] + std::size_t(count[1]) * at[2]),
                    [&](std::int8_t* codes) { return makeBrick(at, codes); });
}

bool VoxelDistance::makeBrick(const std::array<int, 3>& at, std::int8_t* codes) const {
  constexpr unsigned all = (1u << windowNodes) - 1;
  std::array<std::array<unsigned, windowNodes>, windowNodes> in, out;
  unsigned anyIn = 0, anyOut = 0;
  for (int k = 0; k < windowNodes; ++k)
    for (int j = 0; j < windowNodes; ++j) {
      in[k][j] = patternOf(inside_, brickNodes * at[0] - margin, brickNodes * at[1] - margin + j,
                           brickNodes * at[2] - margin + k);
      out[k][j] = ~in[k][j] & all;
      anyIn |= in[k][j];
      anyOut |= out[k][j];
    }
  if (anyIn == 0 || anyOut == 0) return false;
  const BrickCodes toIn = codesOf(in), toOut = codesOf(out);
  constexpr int samples = BrickView::row;
  for (int z = 0; z < samples; ++z)
    for (int y = 0; y < samples; ++y) {
      const Row::Bytes &in2 = toIn[z][y].code, &out2 = toOut[z][y].code;
      const Row::Bytes code = in2 > 0 ? -in2 : out2;
      std::memcpy(codes + samples * (y + samples * z), &code, samples);
    }
  return true;
}

void VoxelDistance::atSamples(const std::array<int, 3>& first, int step, int count, float* distances) const {
  constexpr int edge = BrickView::cells;  // samples from brick to brick
  constexpr float unknown = std::numeric_limits<float>::quiet_NaN();
  constexpr int reach = static_cast<int>(4.0 * fineReach * fineReach);  // as a code
  std::array<int, 3> at;
  int row = 0, perRow = 1;
  for (int k = 1; k < 3; ++k) {
    if (first[k] < 0 || first[k] > 2 * nodes_[k]) {
      std::fill(distances, distances + count, unknown);
      return;
    }
    at[k] = std::min(first[k] / edge, bricks_.count()[k] - 1);
    perRow *= BrickView::row;
    row += perRow * (first[k] - edge * at[k]);
  }
  at[0] = -1;
  const std::int8_t* stored = nullptr;
  for (int i = 0; i < count; ++i) {
    const int sample = first[0] + step * i;
    distances[i] = unknown;
    if (sample < 0 || sample > 2 * nodes_[0]) continue;
    if (const int brickHere = std::min(sample / edge, bricks_.count()[0] - 1); brickHere != at[0]) {
      at[0] = brickHere;
      stored = brick(at);
    }
    if (!stored) continue;
    // NOLINTNEXTLINE(bugprone-signed-char-misuse): codes have a sign
    const int code = stored[row + sample - edge * at[0]];
    if (std::abs(code) <= reach) distances[i] = static_cast<float>(dx_) * decoder.distance[codeLimit + code];
  }
}

std::optional<VoxelDistance::SampleRows> VoxelDistance::rowsOf(const NodeBlock& block) const {
  constexpr double rounding = 1e-6, most = 1e9;  // in lattice spacings; far beyond any lattice
  const auto isWhole = [](double x) { return std::abs(x) < most && std::abs(x - std::round(x)) < rounding; };
  const double perLength = 2.0 / dx_;
  const Vec3 first = perLength * block.origin + Vec3::Ones();
  if (!isWhole(first.x()) || !isWhole(first.y()) || !isWhole(first.z()) ||
      !isWhole(perLength * block.spacing))
    return {};
  const auto whole = [](double x) { return static_cast<int>(std::lround(x)); };
  return SampleRows{{whole(first.x()), whole(first.y()), whole(first.z())}, whole(perLength * block.spacing)};
}

void VoxelDistance::sample(const NodeBlock& block, float* distances) const {
  const std::optional<SampleRows> rows = rowsOf(block);
  const int n = block.nodes[0];
  for (int k = 0; k < block.nodes[2]; ++k)
    for (int j = 0; j < block.nodes[1]; ++j, distances += n) {
      std::fill(distances, distances + n, std::numeric_limits<float>::quiet_NaN());
      if (rows)
        atSamples({rows->first[0], rows->first[1] + rows->step * j, rows->first[2] + rows->step * k},
                  rows->step, n, distances);
      for (int i = 0; i < n; ++i)
        if (std::isnan(distances[i])) distances[i] = static_cast<float>(at(block.position(i, j, k)).distance);
    }
}

WallDistance VoxelDistance::far(const Vec3& w) const {
  std::call_once(transformed_, [&] {
    const int step = coarsenessOf(nodes_).step;
    for (int k = 0; k < 3; ++k) transform_.nodes[k] = bricks_.count()[k] * brickNodes / step + 1;
    transform_.spacing = step;
    transform_.value =
        voxelTransform(inside_, step, {transform_.nodes[0], transform_.nodes[1], transform_.nodes[2]});
  });
  WallDistance result = transform_.sample(w);
  result.distance -= farError_;
  return result;
}

WallDistance VoxelDistance::inLattice(const Vec3& w) const {
  const GridCell cell(2.0 * w, {2 * nodes_[0], 2 * nodes_[1], 2 * nodes_[2]});
  const auto brickAlong = [&](int k) { return cell.node[k] / BrickView::cells; };
  const std::int8_t* stored = brick({brickAlong(0), brickAlong(1), brickAlong(2)});
  if (!stored) return far(w);
  const std::int8_t* low = stored + BrickView::placeOf(cell.node);
  const auto at = cell.interpolate(BrickView::row, BrickView::slab,
                                   [&](std::size_t n) { return decoder.distance[codeLimit + low[n]]; });
  const WallDistance near{at.value, 2.0 * Vec3(at.slope)};
  const double depth = std::abs(near.distance);
  if (depth <= fineReach) return near;

  const WallDistance away = far(w);
  const double x = std::min(1.0, (depth - fineReach) / (farReach - fineReach)),
               weight = x * x * (3.0 - 2.0 * x);
  const double slope = std::copysign(6.0 * x * (1.0 - x) / (farReach - fineReach), near.distance);
  const double more = away.distance - near.distance;
  return {near.distance + weight * more,
          (1.0 - weight + slope * more) * near.gradient + weight * away.gradient};
}

WallDistance VoxelDistance::at(const Vec3& p) const {
  const Vec3 w = (p / dx_).array() + 0.5;
  const Vec3 q = w.cwiseMax(0.0).cwiseMin(Vec3(nodes_[0], nodes_[1], nodes_[2])), out = w - q;
  WallDistance result = inLattice(q);
  const double away2 = out.squaredNorm();
  if (away2 > 0.0) {  // beyond the lattice: distance to the lattice plus the distance from there
    const double away = std::sqrt(away2);
    if (result.distance >= 0.0) result = {0.0, Vec3::Zero()};
    for (int k = 0; k < 3; ++k)
      if (out[k] != 0.0) result.gradient[k] = 0.0;
    result.distance -= away;
    result.gradient -= out / away;
  }
  const double norm2 = result.gradient.squaredNorm();
  constexpr double flat = 1e-12;  // two equal distances: either direction is valid
  result.gradient = norm2 > flat ? Vec3(result.gradient / std::sqrt(norm2)) : Vec3::UnitX();
  result.distance *= dx_;
  return result;
}

// Distance transform by lower envelopes, one axis after the other (Felzenszwalb and Huttenlocher, Theory of
// Computing 8, 2012), for distances to cubes from their corners.

namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// One axis. From a corner at integer x, the distance to a cube [q, q+1] is that to the nearer of its faces q
/// and q+1, so the squared distance is the lower envelope of parabolas around the faces.
class AxisPass {
 public:
  explicit AxisPass(int length) : apex_(length + 1), value_(length + 1), from_(length + 2) {}

  /// out[s·outStride] = squared distance at x = step·s, for cubes with squared distances f[q·stride] across.
  void operator()(const float* f, std::size_t stride, int length, int step, float* out, std::size_t outStride,
                  int samples) {
    count_ = 0;
    float lower = infinite;
    for (int face = 0; face <= length; ++face) {
      const float upper = face < length ? f[face * stride] : infinite, value = std::min(lower, upper);
      if (value != infinite) add(face, value);
      lower = upper;
    }
    if (count_ == 0) {
      for (int s = 0; s < samples; ++s) out[s * outStride] = infinite;
      return;
    }
    int e = 0;
    for (int s = 0; s < samples; ++s) {
      const float x = static_cast<float>(step * s);
      while (e + 1 < count_ && from_[e + 1] <= x) ++e;
      out[s * outStride] = value_[e] + (x - apex_[e]) * (x - apex_[e]);
    }
  }

 private:
  void add(int apex, float value) {
    while (count_ > 0) {
      const float other = apex_[count_ - 1];
      const float cross = 0.5f * (apex + other + (value - value_[count_ - 1]) / (apex - other));
      if (cross > from_[count_ - 1]) {
        from_[count_] = cross;
        break;
      }
      --count_;
    }
    if (count_ == 0) from_[0] = -infinite;
    apex_[count_] = static_cast<float>(apex);
    value_[count_++] = value;
  }

  std::vector<float> apex_, value_, from_;  ///< parabola e is lowest from from_[e] to from_[e + 1]
  int count_ = 0;
};

/// Squared distances along a row of nodes to those with fluid() == kind, at x = step·s.
void rowDistances(const std::uint64_t* row, int nodes, bool kind, int step, float* out, int samples,
                  std::vector<int>& distance) {
  bool all = step * (samples - 1) <= nodes, none = true;
  for (int w = 0; w < (nodes + 63) / 64; ++w) {
    const std::uint64_t used = usedBits(nodes, w);
    const std::uint64_t bits = (kind ? row[w] : ~row[w]) & used;
    all = all && bits == used;
    none = none && bits == 0;
  }
  if (all || none) {
    std::fill(out, out + samples, all ? 0.0f : infinite);
    return;
  }
  const int far = std::numeric_limits<int>::max() / 2, last = step * (samples - 1);
  distance.resize(std::max(last, nodes) + 1);
  const auto has = [&](int i) {
    return i >= 0 && i < nodes && (row[i >> 6] >> (i & 63) & 1u) == (kind ? 1u : 0u);
  };
  const int end = static_cast<int>(distance.size());
  int away = far;
  for (int x = 0; x < end; ++x) {
    away = has(x - 1) || has(x) ? 0 : std::min(away + 1, far);
    distance[x] = away;
  }
  away = far;
  for (int x = end - 1; x >= 0; --x) {
    away = distance[x] == 0 ? 0 : std::min(away + 1, far);
    distance[x] = std::min(distance[x], away);
  }
  for (int s = 0; s < samples; ++s) {
    const float d = static_cast<float>(distance[step * s]);
    out[s] = distance[step * s] < far / 2 ? d * d : infinite;
  }
}

/// Squared distances from the samples to the cubes of the nodes with fluid() == kind.
std::vector<float> squaredDistance(const Lattice& lattice, bool kind, int step,
                                   const std::array<int, 3>& samples) {
  const auto [nx, ny, nz] = lattice.nodes();
  const auto [sx, sy, sz] = samples;
  AxisPass pass(std::max({nx, ny, nz}));
  // z last, so that only reduced slices are stored.
  const std::size_t plane = std::size_t(sx) * sy;
  std::vector<float> slices(plane * nz), slice(std::size_t(sx) * ny), result(plane * sz);
  std::vector<int> scratch;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j)
      rowDistances(lattice.row(j, k), nx, kind, step, &slice[std::size_t(sx) * j], sx, scratch);
    for (int i = 0; i < sx; ++i) pass(&slice[i], sx, ny, step, &slices[plane * k + i], sx, sy);
  }
  for (std::size_t column = 0; column < plane; ++column)
    pass(&slices[column], plane, nz, step, &result[column], plane, sz);
  return result;
}

}  // namespace

std::vector<float> voxelTransform(const Lattice& inside, int step, const std::array<int, 3>& samples) {
  std::vector<float> toInside = squaredDistance(inside, true, step, samples);
  const std::vector<float> toOutside = squaredDistance(inside, false, step, samples);
  const std::array<int, 3> nodes = inside.nodes();
  const float furthest =
      static_cast<float>(nodes[0]) + nodes[1] + nodes[2];  // for a lattice without fluid nodes
  std::size_t index = 0;
  for (int k = 0; k < samples[2]; ++k)
    for (int j = 0; j < samples[1]; ++j)
      for (int i = 0; i < samples[0]; ++i, ++index) {
        const int corner[3] = {step * i, step * j, step * k};
        int rim = std::numeric_limits<int>::max();
        for (int axis = 0; axis < 3; ++axis) rim = std::min({rim, corner[axis], nodes[axis] - corner[axis]});
        const float outward = std::min(furthest, std::sqrt(toInside[index]));
        const float inward = std::min(static_cast<float>(std::max(rim, 0)), std::sqrt(toOutside[index]));
        toInside[index] = outward > 0.0f ? -outward : inward;
      }
  return toInside;
}

}  // namespace packmesh::hemocell
