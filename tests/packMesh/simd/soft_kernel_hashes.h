// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Hashes of what the kernels of soft cells return.
#pragma once

#include <vector>

#include "packMesh/soft/soft_kernels.h"
#include "tests/packMesh/simd/kernel_inputs.h"

namespace packmesh {

/// What could touch of two cells with random vertices, and its forces.
inline Hash proximity(InstructionSet set, ContactKind kind) {
  const ContactKernels kernels = proximityKernels(set);
  constexpr int vertices = 48, width = 16, listed = 256;
  const int ofFirst = kind == ContactKind::edgeEdge ? 2 : 1, ofSecond = 4 - ofFirst;
  Random random;
  Hash hash;
  for (int example = 0; example < 100; ++example) {
    std::vector<float> cells[2];
    for (std::vector<float>& cell : cells)
      for (int i = 0; i < 4 * vertices; ++i) cell.push_back(random.between(-1.0f, 1.0f));
    const float offset[3] = {0.4f, -0.2f, 0.1f}, none[3] = {};
    std::int16_t numbers[3][width];
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < width; ++k) numbers[c][k] = std::int16_t(width * c + k);
    Cluster clusters[2] = {};
    for (int i = 0; i < 2; ++i) {
      Cluster& one = clusters[i];
      one.vertex = numbers;
      one.count = width - i;
      for (int k = 0; k < 3; ++k) {
        one.lo[k] = -1.0f, one.hi[k] = 1.0f;
        one.axis[k] = random.between(-0.6f, 0.6f);
      }
      for (auto& normals : one.normal)
        for (float& x : normals) x = random.between(-1.0f, 1.0f);
      kernels.load(cells[i].data(), i == 0 ? none : offset, i == 0 ? ofFirst : ofSecond, one);
    }
    BoxBlock boxes;
    for (int k = 0; k < 3; ++k)
      for (int n = 0; n < width; ++n) {
        boxes.lo[k][n] = random.between(-1.0f, 1.0f);
        boxes.hi[k][n] = boxes.lo[k][n] + 0.5f;
      }
    hash.add(int(kernels.boxes(boxes, offset, clusters[0].hi)));
    std::int16_t found[listed][4];
    const int count = kernels.list(kind, clusters[0], clusters[1], 0.3f, example % 2 == 0, found);
    hash.add(count);
    VertexFours blocks[listed / width] = {};
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < 4; ++k) {
        hash.add(found[i][k]);
        blocks[i / width][k][i % width] = found[i][k];
      }
    const CellPair pair{cells[0].data(), cells[1].data(), {offset[0], offset[1], offset[2]}};
    std::vector<float> forces(4 * vertices), gaps(vertices, 1.0f);
    std::vector<Reaction> reactions(listed, Reaction{});
    std::vector<float> until(listed / width, 0.0f);
    const int reacting = kernels.forces(kind, pair, blocks, count, {0.02f, 0.25f, 20.0f},
                                        {0.0f, until.data()}, forces.data(), gaps.data(), reactions.data());
    hash.add(reacting);
    for (const float x : forces) hash.add(x);
    for (const float x : gaps) hash.add(x);
    for (int i = 0; i < reacting; ++i) {
      const float second = reactions[i].second, third = reactions[i].third;
      const float weight[3] = {1.0f - second - third, second, third};
      for (int c = 0; c < ofSecond; ++c) hash.add(reactions[i].vertex[c]), hash.add(weight[c]);
      hash.add(reactions[i].force);
      hash.add(reactions[i].stiffness);
      hash.add(reactions[i].gap);
    }
  }
  return hash;
}

/// Steps of sixteen octahedra that are deformed and pushed at random.
inline Hash membranes(InstructionSet set) {
  constexpr int vertices = 6, edges = 12, triangles = 8, neighbors = 4, cells = MembraneBatch::cells;
  const std::int16_t corner[3 * triangles] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4,
                                              2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  const std::int16_t end[2 * edges] = {0, 2, 2, 1, 1, 3, 3, 0, 0, 4, 1, 4,
                                       2, 4, 3, 4, 0, 5, 1, 5, 2, 5, 3, 5};
  const std::int16_t ring[vertices * neighbors] = {2, 4, 3, 5, 3, 4, 2, 5, 1, 4, 0, 5,
                                                   0, 4, 1, 5, 0, 2, 1, 3, 3, 1, 2, 0};
  const std::int16_t between[vertices * neighbors] = {0, 3, 7, 4, 2, 1, 5, 6, 1, 0, 4, 5,
                                                      3, 2, 6, 7, 0, 1, 2, 3, 6, 5, 4, 7};
  const int begin[vertices + 1] = {0, 4, 8, 12, 16, 20, 24};
  const std::vector<float> share(vertices * neighbors, 0.25f), inverseLength(edges, 0.7071f),
      inverseArea(triangles, 1.1547f), deviation(vertices, 0.7f);
  const MembraneLaw link{9.0f, 2.9f, 50.0f}, bend{0.0555f, 0.2f, 60.0f}, area{0.0625f, 0.24f, 80.0f},
      volumeLaw{0.01f, 0.09f, 100.0f};
  const MembraneView view{vertices,
                          edges,
                          triangles,
                          corner,
                          end,
                          begin,
                          ring,
                          between,
                          share.data(),
                          inverseLength.data(),
                          inverseArea.data(),
                          deviation.data(),
                          0.7071f,
                          1.1547f,
                          0.75f,
                          0.05f,
                          0.4f,
                          0.2f,
                          3.0f,
                          link,
                          bend,
                          area,
                          volumeLaw,
                          2.0f};
  constexpr float at[vertices][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  Random random;
  std::vector<float> position, force(4 * vertices * cells), gap, scale, moves;
  for (const auto& vertex : at)
    for (const float x : vertex)
      for (int c = 0; c < cells; ++c) position.push_back(x + random.between(-0.2f, 0.2f));
  for (int i = 0; i < vertices * cells; ++i) gap.push_back(random.between(0.0f, 0.3f));
  for (int c = 0; c < cells; ++c) {
    scale.push_back(random.between(0.8f, 1.0f));
    moves.push_back(c == 3 ? 0.0f : 1.0f);
  }
  const std::vector<float> listed = position;
  std::vector<float> step(3 * vertices * cells), scratch(view.scratch() * cells);
  float volume[cells], largest[cells], farthest[cells];
  Hash hash;
  for (int n = 0; n < 20; ++n) {
    for (float& x : force) x = random.between(0.0f, 0.5f);
    const MembraneBatch batch{position.data(), listed.data(),  step.data(),  force.data(),
                              gap.data(),      scratch.data(), scale.data(), moves.data(),
                              volume,          largest,        farthest};
    membraneKernel(set)(view, batch, {0.9f, 0.4f, 0.05f, 5.0f});
    for (const float x : position) hash.add(x);
    hash.add(volume);
    hash.add(largest);
    hash.add(farthest);
  }
  return hash;
}

}  // namespace packmesh
