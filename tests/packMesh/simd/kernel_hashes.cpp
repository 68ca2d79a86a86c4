// SPDX-License-Identifier: AGPL-3.0-or-later
// Runs every kernel on fixed inputs with each instruction set there is, and prints a hash of what each
// returns. Fails where instruction sets differ. Needs nothing but the kernels, so that it is easily built for
// another processor; inputs take IEEE operations only, so that they are the same on all of them.
// To measure one: kernel_hashes <repetitions> <kernel, as printed> <0: portable, 1: AVX2, 2: AVX-512>.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "packMesh/cat/growth_kernels.h"
#include "packMesh/mesh/mesh_kernels.h"
#include "packMesh/relaxation/contact_kernels.h"
#include "tests/packMesh/simd/kernel_inputs.h"
#include "tests/packMesh/simd/soft_kernel_hashes.h"
#include "tests/packMesh/simd/triangle_candidates.h"

namespace packmesh {
namespace {

/// Points on an ellipsoid, in clusters of neighbours more or less.
class Samples {
 public:
  Samples(int clusters, const float (&axes)[3]) {
    Random random;
    for (int c = 0; c < clusters; ++c) {
      float around[3], center[3], radius = 0.0f;
      random.direction(around);
      for (int k = 0; k < 3; ++k) center[k] = axes[k] * around[k];
      for (int p = 0; p < 16; ++p) {
        float aside[3], length = 0.0f, apart = 0.0f;
        random.direction(aside);
        for (int k = 0; k < 3; ++k) {
          aside[k] = around[k] + 0.25f * aside[k];
          length += aside[k] * aside[k];
        }
        for (int k = 0; k < 3; ++k) {
          const float x = axes[k] * aside[k] / std::sqrt(length);
          points_[k].push_back(x);
          apart += (x - center[k]) * (x - center[k]);
        }
        radius = std::sqrt(apart) > radius ? std::sqrt(apart) : radius;
      }
      for (int k = 0; k < 3; ++k) centers_[k].push_back(center[k]);
      centers_[3].push_back(radius);
    }
    for (std::vector<float>& values : centers_) values.resize((clusters + 63) / 64 * 64);
    view_ = {clusters,           clusters > 64 ? 1 : 0, points_[0].data(),
             points_[1].data(),  points_[2].data(),     centers_[0].data(),
             centers_[1].data(), centers_[2].data(),    centers_[3].data()};
  }
  const SampleView& view() const { return view_; }

 private:
  SampleView view_;
  std::vector<float> points_[3], centers_[4];
};

constexpr float axes[3] = {3.9f, 1.2f, 3.9f};

/// Much like a red cell.
FieldView closedForm() {
  FieldView field{};
  const float p[6] = {0.16f, 3.2f, -2.36f, -1.5f, 0.9f, -0.4f};
  std::memcpy(field.p, p, sizeof p);
  field.a = field.c = 1.0f / (axes[0] * axes[0]);
  field.bend = -3.0f;
  field.curvature = 1.4f;
  return field;
}

constexpr int gridNodes = 24;

/// Distances from an ellipsoid, roughly.
std::vector<float> gridValues() {
  std::vector<float> values;
  for (int z = 0; z < gridNodes; ++z)
    for (int y = 0; y < gridNodes; ++y)
      for (int x = 0; x < gridNodes; ++x) {
        float squared = 0.0f;
        const int node[3] = {x, y, z};
        for (int k = 0; k < 3; ++k) {
          const float u = (static_cast<float>(node[k]) / 2.0f - 5.5f) / axes[k];
          squared += u * u;
        }
        values.push_back((std::sqrt(squared) - 1.0f) * axes[1]);
      }
  return values;
}

FieldView onGrid() {
  static const std::vector<float> values = gridValues();
  FieldView field{};
  field.onGrid = true;
  field.value = values.data();
  field.nodesPerLength = 2.0f;
  for (int k = 0; k < 3; ++k) field.origin[k] = -5.5f, field.nodes[k] = gridNodes;
  return field;
}

/// Examples must show what they are for.
void require(bool fulfilled) {
  if (fulfilled) return;
  std::fputs("the examples of a kernel are all of one kind\n", stderr);
  std::exit(1);
}

/// With the bounds outside of which points are certainly apart.
FieldView bounded(FieldView field) {
  field.ring = axes[0] - axes[1];
  field.thickness = axes[1];
  for (int k = 0; k < 3; ++k) field.extent[k] = axes[k];
  return field;
}

/// A cell somewhere around another one, of another size now and then.
void place(RelativeFrame& frame, float scale, Random& random) {
  random.rotation(frame.m);
  for (float& m : frame.m) m *= scale;
  random.direction(frame.t);
  const float apart = random.between(1.5f, 7.0f);
  for (float& t : frame.t) t *= apart;
  frame.scale = scale;
}

Hash contacts(InstructionSet set, const FieldView& field, int clusters) {
  const auto kernel = contactKernel(set);
  const Samples samples(clusters, axes);
  Random random;
  Hash hash;
  int touching = 0, apart = 0;
  for (int example = 0; example < 200; ++example) {
    RelativeFrame frame{};
    place(frame, example % 4 == 0 ? random.between(0.5f, 2.0f) : 1.0f, random);
    ClusterMask mask = allClusters;
    for (const bool all : {true, false}) {
      ContactSums sums{};
      const float clearance = example % 3 == 0 ? 0.25f : 0.02f,
                  margin = all && example % 2 == 0 ? 0.3f : 0.0f;
      kernel(samples.view(), frame, field, clearance, margin, mask, sums);
      ++(sums.weight > 0.0f ? touching : apart);
      hash.add(sums.weight);
      hash.add(sums.nearest);
      hash.add(mask);
      hash.add(sums.touched);
      if (!(sums.weight > 0.0f)) continue;
      hash.add(sums.point);
      hash.add(sums.normal);
      hash.add(sums.gradient);
      hash.add(sums.deepest);
    }
  }
  require(touching > 50 && apart > 50);
  return hash;
}

/// Columns of planes, or of rows.
template <class Value, int columns>
struct Columns {
  std::vector<Value> values[columns];
  Value* at[columns];

  explicit Columns(int rows) {
    for (int k = 0; k < columns; ++k) {
      values[k].resize(rows);
      at[k] = values[k].data();
    }
  }
  void addTo(Hash& hash, int rows) const {
    for (const std::vector<Value>& column : values)
      for (int i = 0; i < rows; ++i) hash.add(column[i]);
  }
};

#if PACKMESH_CAT
void solve(InstructionSet set, const Columns<double, 8>& rows, int count, bool atBarrier, Random& random,
           Hash& hash) {
  LinearProgramView program{};
  for (int k = 0; k < 7; ++k) {
    program.column[k] = rows.at[k];
    program.objective[k] = k == 0 ? 1.0 : static_cast<double>(random.between(-1e-3f, 1e-3f));
    program.lower[k] = k == 0 ? 0.0 : -0.15;
    program.upper[k] = k == 0 && !atBarrier ? 1.0 : 0.15;
  }
  program.rhs = rows.at[7];
  program.rows = count;
  LinearProgramResult result;
  linearProgramKernel(set)(program, 1e-9, result);
  hash.add(result.status);
  hash.add(result.x);
  hash.add(result.pivots);
}

/// Chords between two cells, and the step of the second one within their planes.
Hash growth(InstructionSet set, const FieldView& field) {
  constexpr int clusters = 70, most = clusters * 16 + 16;
  const Samples samples(clusters, axes);
  std::vector<std::uint16_t> distinct;
  for (int c = 0; c < clusters; ++c) distinct.push_back(c % 5 == 0 ? 0x5fff : 0xffff);
  const GrowthRowKernel kernel = growthRowKernel(set);
  Random random;
  Hash hash;
  for (int example = 0; example < 100; ++example) {
    ChordFrame frame{};
    place(frame.toSurface, 1.0f, random);
    random.rotation(frame.sampled);
    random.rotation(frame.surface);
    frame.limit = random.between(0.3f, 3.0f);
    frame.scale = 0.9f;
    frame.shortChord = 1e-4f;
    frame.share = 0.5f;
    Columns<float, 7> sampled(most), surface(most), reached(most);
    const int found =
        chordKernel(set)(samples.view(), distinct.data(), frame, field, {sampled.at, surface.at});
    hash.add(found);
    sampled.addTo(hash, found);
    surface.addTo(hash, found);
    float room = 0.0f;
    const StepReach reach{0.9f, 1.0f, 0.01f, 0.15f, 0.065f, 0.15f};
    const int count = kernel.reached(surface.at, found, reach, reached.at, room);
    hash.add(count);
    hash.add(room);
    for (const bool atBarrier : {false, true}) {
      Columns<double, 8> rows(most);
      kernel.rows(reached.at, count, frame.sampled, 0.9f, atBarrier, rows.at);
      rows.addTo(hash, count);
      for (int k = 0; k < 8; ++k)
        for (int i = count; i < most; ++i) rows.at[k][i] = k == 7 ? 1e300 : 0.0;
      solve(set, rows, count, atBarrier, random, hash);
    }
  }
  return hash;
}
#endif

/// A box of bricks that become known when they are asked for.
struct Bricks {
  static constexpr int count = 3;
  std::vector<std::int32_t> begins = std::vector<std::int32_t>(count * count * count, -1);
  std::vector<std::int16_t> values = std::vector<std::int16_t>(1);
  const std::int16_t* data = values.data();

  /// The distance from a round wall around the middle of the box.
  static void evaluate(const SampledDistance& sampled, int index) {
    auto& self = const_cast<Bricks&>(reinterpret_cast<const Bricks&>(sampled));
    if (self.begins[index] >= 0) return;
    const int first[3] = {index % count * BrickView::cells, index / count % count * BrickView::cells,
                          index / count / count * BrickView::cells};
    self.begins[index] = static_cast<std::int32_t>(self.values.size()) - 1;
    self.values.pop_back();
    for (int node = 0; node < BrickView::nodes; ++node) {
      const int at[3] = {node % BrickView::row, node / BrickView::row % BrickView::row,
                         node / BrickView::slab};
      float squared = 0.0f;
      for (int k = 0; k < 3; ++k) {
        const float u = static_cast<float>(first[k] + at[k]) - 12.0f;
        squared += u * u;
      }
      const float steps = (10.0f - std::sqrt(squared)) * BrickView::stepsPerSpacing;
      self.values.push_back(static_cast<std::int16_t>(steps));
    }
    self.values.push_back(0);
    self.data = self.values.data();
  }
  WallGrid grid(const float (&center)[3], float nodesPerLength) const {
    WallGrid grid{};
    grid.bricks = {begins.data(),
                   &data,
                   {count, count, count},
                   nodesPerLength,
                   reinterpret_cast<const SampledDistance*>(this),
                   evaluate};
    for (int k = 0; k < 3; ++k) {
      const float at = 12.0f + nodesPerLength * center[k];
      grid.base[k] = static_cast<int>(at) / 2;
      grid.start[k] = at - static_cast<float>(grid.base[k]);
      grid.first[k] = static_cast<float>(-grid.base[k]);
      grid.last[k] = static_cast<float>(count * BrickView::cells - grid.base[k]) - 0.001f;
    }
    return grid;
  }
};

Hash walls(InstructionSet set, WallFrame::Kind kind) {
  const auto kernel = wallKernel(set);
  const Samples samples(80, axes);
  const Bricks coarse, fine;
  Random random;
  Hash hash;
  int touching = 0, apart = 0;
  for (int example = 0; example < 100; ++example) {
    WallFrame frame{};
    random.rotation(frame.m);
    frame.scale = example % 3 == 0 ? 0.7f : 1.0f;
    for (float& m : frame.m) m *= frame.scale;
    frame.kind = kind;
    frame.slack = kind == WallFrame::Kind::sampled ? 0.3f : 0.0f;
    float center[3];
    for (float& x : center) x = random.between(-3.0f, 3.0f);
    frame.coarse = coarse.grid(center, 1.5f);
    frame.fine = fine.grid(center, 2.0f);
    frame.form = {{0.0f, 1.0f, 1.0f}, 6.0f, {0.0f, center[1], center[2]}, 0.0f, {}, {}};
    frame.form.excess = 36.0f - center[1] * center[1] - center[2] * center[2];
    for (int k = 0; k < 3; ++k) {
      frame.form.toLo[k] = k == 1 ? WallForm::none : center[k] + 4.5f;
      frame.form.toHi[k] = k == 0 ? 4.0f - center[k] : WallForm::none;
    }
    ClusterMask mask = allClusters;
    for (int look = 0; look < 2; ++look) {
      WallSums sums{};
      kernel(samples.view(), frame, 0.02f, look == 0 && example % 3 == 0 ? 0.3f : 0.0f, mask, sums);
      ++(sums.contacts > 0 ? touching : apart);
      hash.add(mask);
      hash.add(sums.contacts);
      hash.add(sums.nearest);
      for (int c = 0; c < sums.contacts; ++c) hash.add(sums.contact[c]);
    }
  }
  require(touching > 20 && apart > 20);
  return hash;
}

Hash triangles(InstructionSet set) {
  const auto kernels = triangleKernels(set);
  Random random;
  std::vector<TriangleFacts> facts(30);
  for (TriangleFacts& t : facts) {
    for (auto& corner : t.corner)
      for (float& x : corner) x = random.between(-2.0f, 2.0f);
    if (&t - facts.data() < 2) std::memcpy(t.corner[2], t.corner[1], sizeof t.corner[2]);  // no area
    if (&t == &facts[0]) std::memcpy(t.corner[0], t.corner[1], sizeof t.corner[0]);
    random.direction(t.normal);
    for (int e = 0; e < 3; ++e) {
      float squared = 0.0f;
      for (int k = 0; k < 3; ++k) {
        t.edge[e][k] = t.corner[(e + 1) % 3][k] - t.corner[e][k];
        squared += t.edge[e][k] * t.edge[e][k];
      }
      t.perSquare[e] = squared > 0.0f ? 1.0f / squared : 0.0f;
      for (int k = 0; k < 3; ++k)
        t.inward[e][k] =
            t.normal[(k + 1) % 3] * t.edge[e][(k + 2) % 3] - t.normal[(k + 2) % 3] * t.edge[e][(k + 1) % 3];
    }
  }
  TriangleCandidates candidates(facts);
  Hash hash;
  for (int example = 0; example < 100; ++example) {
    PointLanes points;
    for (int k = 0; k < 16; ++k) {
      points.x[k] = random.between(-3.0f, 3.0f);
      points.y[k] = random.between(-3.0f, 3.0f);
      points.z[k] = random.between(-3.0f, 3.0f);
    }
    float squared[16], nearest[16];
    candidates.nearest(kernels, points, squared, nearest);
    hash.add(squared);
    hash.add(nearest);
  }
  return hash;
}

/// A tree of quads over small triangles at the points of a lattice on an ellipsoid.
class Tree {
 public:
  Tree() {
    Random random;
    for (int t = 0; t < 256; ++t) {
      float at[3], aside[3];
      random.direction(at);
      float corners[9];
      for (int c = 0; c < 3; ++c) {
        random.direction(aside);
        for (int k = 0; k < 3; ++k) corners[3 * c + k] = axes[k] * at[k] + 0.4f * aside[k];
      }
      std::memcpy(corners_[t], corners, sizeof corners);
      for (int c = 0; c < 3; ++c) triangles_[t][c] = 3 * t + c;
    }
    quads_.resize(1);
    clear(quads_[0]);
    quads_[0].disc = 0;
    put(0, 0, 0, 256);
    quads_[0].size = quads_[0].discs.radius[0];
  }
  TreeView view() const {
    return {quads_.data(), reinterpret_cast<const float(*)[3]>(corners_), triangles_, discs_};
  }

 private:
  static void clear(DiscQuad& quad) {
    quad = {};
    for (int lane = 0; lane < 4; ++lane)
      quad.discs.radius[lane] = quad.discs.half[lane] = -emptyDisc, quad.content[lane] = -1;
  }
  /// Fills a lane of a quad with triangles [begin, end).
  void put(int quad, int lane, int begin, int end) {
    float center[3] = {}, radius = 0.0f;
    for (int k = 0; k < 3; ++k) {
      for (int t = begin; t < end; ++t) center[k] += corners_[t][k] + corners_[t][3 + k] + corners_[t][6 + k];
      center[k] /= static_cast<float>(3 * (end - begin));
    }
    for (int t = begin; t < end; ++t)
      for (int c = 0; c < 3; ++c) {
        float squared = 0.0f;
        for (int k = 0; k < 3; ++k) {
          const float d = corners_[t][3 * c + k] - center[k];
          squared += d * d;
        }
        radius = std::sqrt(squared) > radius ? std::sqrt(squared) : radius;
      }
    FourDiscs& discs = quads_[quad].discs;
    for (int k = 0; k < 3; ++k) {
      discs.center[k][lane] = center[k];
      discs.normal[k][lane] = k == (begin + lane) % 3 ? 1.0f : 0.0f;
    }
    discs.radius[lane] = 1.001f * radius;
    discs.half[lane] = discs.radius[lane];
    if (end - begin == 1) {
      quads_[quad].content[lane] = ~begin;
      discs_[begin] = 4 * quad + lane;
      return;
    }
    const int next = static_cast<int>(quads_.size());
    quads_[quad].content[lane] = next;
    const float size = discs.radius[lane];
    quads_.emplace_back();
    clear(quads_[next]);
    quads_[next].size = size;
    quads_[next].disc = 4 * quad + lane;
    for (int k = 0; k < 4; ++k)
      put(next, k, begin + (end - begin) / 4 * k, begin + (end - begin) / 4 * (k + 1));
  }

  std::vector<DiscQuad> quads_;
  float corners_[256][9];
  int triangles_[256][3];
  int discs_[256];
};

/// What the search shows, and the limit it goes on with.
struct Seen {
  Hash hash;
  float limit;
};

Hash hierarchies(InstructionSet set) {
  const auto search = pairSearch(set);
  const Tree tree;
  Random random;
  Hash hash;
  for (int example = 0; example < 20; ++example) {
    SeenFrom map{};
    float m[9];
    random.rotation(m);
    std::memcpy(map.point, m, sizeof m);
    std::memcpy(map.direction, m, sizeof m);
    random.direction(map.shift);
    const float apart = random.between(2.0f, 6.0f);
    for (float& x : map.shift) x *= apart;
    map.stretch = map.slab = map.skew = 1.0001f;
    Seen seen{{}, 0.3f};
    const bool toTheEnd = search(
        tree.view(), tree.view(), map, 1e-4f, seen.limit,
        [](void* context, int first, int second, bool mayMeet) {
          auto& all = *static_cast<Seen*>(context);
          all.hash.add(first);
          all.hash.add(second);
          all.hash.add(mayMeet);
          return all.limit *= 0.999f;
        },
        &seen);
    hash.add(toTheEnd);
    hash.add(seen.hash.value());
  }
  return hash;
}

struct Kernel {
  const char* name;
  Hash (*run)(InstructionSet);
};

const Kernel kernels[] = {
    {"contact", [](InstructionSet set) { return contacts(set, bounded(closedForm()), 50); }},
    {"contact-coarse-bits", [](InstructionSet set) { return contacts(set, bounded(closedForm()), 100); }},
    {"contact-grid", [](InstructionSet set) { return contacts(set, bounded(onGrid()), 50); }},
#if PACKMESH_CAT
    {"growth", [](InstructionSet set) { return growth(set, bounded(closedForm())); }},
    {"growth-grid", [](InstructionSet set) { return growth(set, bounded(onGrid())); }},
#endif
    {"hierarchy", hierarchies},
    {"membrane", membranes},
    {"proximity-edges", [](InstructionSet set) { return proximity(set, ContactKind::edgeEdge); }},
    {"proximity-triangles", [](InstructionSet set) { return proximity(set, ContactKind::vertexTriangle); }},
    {"triangles", triangles},
    {"wall-form", [](InstructionSet set) { return walls(set, WallFrame::Kind::form); }},
    {"wall-coarse", [](InstructionSet set) { return walls(set, WallFrame::Kind::coarse); }},
    {"wall-sampled", [](InstructionSet set) { return walls(set, WallFrame::Kind::sampled); }},
};

void print(std::uint64_t hash, const char* kernel) {
  std::printf("%016llx %s\n", static_cast<unsigned long long>(hash), kernel);
}

}  // namespace
}  // namespace packmesh

int main(int argc, char** argv) {
  using namespace packmesh;
  for (const Kernel& kernel : kernels) {
    if (argc > 3) {  // one kernel many times, for measuring
      if (std::strcmp(kernel.name, argv[2]) != 0) continue;
      std::uint64_t all = 0;
      for (int k = 0; k < std::atoi(argv[1]); ++k)
        all += kernel.run(static_cast<InstructionSet>(std::atoi(argv[3]))).value();
      print(all, kernel.name);
      continue;
    }
    const std::uint64_t expected = kernel.run(InstructionSet::portable).value();
    print(expected, kernel.name);
    for (const InstructionSet set : {InstructionSet::avx2, InstructionSet::avx512})
      if (available(set) && kernel.run(set).value() != expected) {
        std::fprintf(stderr, "%s: other bytes with instruction set %d\n", kernel.name, static_cast<int>(set));
        return 1;
      }
  }
  return 0;
}
