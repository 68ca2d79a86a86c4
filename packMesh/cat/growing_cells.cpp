// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/growing_cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "packMesh/parallel/blocks.h"

namespace packmesh {
namespace {

/// Number of blocks that still gives equal shares to many ranks, while lists of all blocks stay short.
constexpr double mostBlocks = 32768.0;

/// Blocks are redistributed if the load of a rank exceeds the mean by this factor.
constexpr double tolerableImbalance = 1.05;

double blockEdge(const Box& bounds, std::int64_t cells, std::int64_t cellsPerBlock) {
  const double perCell = bounds.volume() / static_cast<double>(std::max<std::int64_t>(1, cells));
  return std::cbrt(std::max(bounds.volume() / mostBlocks, perCell * static_cast<double>(cellsPerBlock)));
}

/// Divides cells into `parts` of about equal numbers by planes across the longest extent of their centres.
/// @param cells indices; their order changes
void divide(const std::vector<Body>& bodies, std::int64_t* begin, std::int64_t* end, std::int64_t parts,
            std::vector<std::vector<std::int64_t>>& out) {
  if (parts < 2) {
    out.emplace_back(begin, end);
    std::sort(out.back().begin(), out.back().end());
    return;
  }
  Box extent;
  for (const std::int64_t* cell = begin; cell != end; ++cell) extent.add(bodies[*cell].position);
  int axis = 0;
  extent.size().maxCoeff(&axis);
  std::int64_t* middle = begin + (end - begin) * (parts / 2) / parts;
  std::nth_element(begin, middle, end, [&](std::int64_t a, std::int64_t b) {
    const double x = bodies[a].position[axis], y = bodies[b].position[axis];
    return x != y ? x < y : bodies[a].id < bodies[b].id;
  });
  divide(bodies, begin, middle, parts / 2, out);
  divide(bodies, middle, end, parts - parts / 2, out);
}

}  // namespace

GrowingCells::GrowingCells(const Physics& physics, const Execution& execution, std::vector<Body> own,
                           double range, std::int64_t cellsPerBlock, double leastEdge)
    : physics_(physics),
      execution_(execution),
      range_(range),
      // Growth uses no colours, so edges of one range suffice: twice the argument of the grid.
      blocks_(physics.container->bounds(), physics.container->period(), 0.5 * std::max(range, leastEdge),
              blockEdge(physics.container->bounds(),
                        execution.communicator.sum(static_cast<std::int64_t>(own.size())), cellsPerBlock)),
      shared_(execution.communicator, blocks_),
      count_(0) {
  replace(std::move(own));
}

void GrowingCells::replace(std::vector<Body> own) {
  count_ = execution_.communicator.sum(static_cast<std::int64_t>(own.size()));
  bodies_ = std::move(own);
  own_.assign(bodies_.size(), true);
  work_.assign(blocks_.count(), 0);
  for (const Body& body : bodies_)
    ++work_[blocks_.blockOf(
        wrapped(body.position, physics_.container->bounds(), physics_.container->period()))];
  balance();
  distribute();
}

void GrowingCells::balance() {
  shared_.balance(work_);
  std::fill(work_.begin(), work_.end(), 0);
}

void GrowingCells::distribute() {
  const Communicator& ranks = execution_.communicator;
  if (!ranks.alone()) {
    const std::int64_t work = std::accumulate(work_.begin(), work_.end(), std::int64_t{0});
    const auto all = static_cast<double>(ranks.sum(work));
    if (ranks.max(static_cast<double>(work)) > tolerableImbalance * all / ranks.size()) balance();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (own_[i]) bodies_[kept++] = bodies_[i];
    bodies_.resize(kept);
  }
  for (Body& body : bodies_) {
    body.position = wrapped(body.position, physics_.container->bounds(), physics_.container->period());
    body.block = blocks_.blockOf(body.position);
    body.touched = body.changed = false;
  }
  shared_.distribute(bodies_, range_);
  own_.resize(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) own_[i] = shared_.owns(bodies_[i].block);
}

void GrowingCells::updateGhosts() {
  shared_.beginGhostUpdate(bodies_);
  shared_.finishGhostUpdate(bodies_);
  shared_.awaitGhostUpdate();
}

std::vector<Body> GrowingCells::own() const {
  std::vector<Body> own;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (own_[i]) own.push_back(bodies_[i]);
  std::sort(own.begin(), own.end(), [](const Body& a, const Body& b) { return a.id < b.id; });
  return own;
}

void GrowingCells::add(const std::vector<Body>& own) {
  count_ += execution_.communicator.sum(static_cast<std::int64_t>(own.size()));
  bodies_.insert(bodies_.end(), own.begin(), own.end());
  own_.resize(bodies_.size(), true);
}

std::vector<int> GrowingCells::ownBlocks() const {
  std::vector<std::pair<std::uint64_t, int>> order;
  for (int block = 0; block < blocks_.count(); ++block)
    if (shared_.owns(block)) order.emplace_back(blocks_.curvePosition(block), block);
  std::sort(order.begin(), order.end());
  std::vector<int> blocks;
  for (const auto& entry : order) blocks.push_back(entry.second);
  return blocks;
}

std::vector<GrowingCells::Block> GrowingCells::blocksOf(int colour) const {
  std::vector<Block> blocks;
  std::vector<std::int32_t> at(blocks_.count(), -1);
  for (const int block : ownBlocks()) {
    if (blocks_.colourOf(block) != colour) continue;
    at[block] = static_cast<std::int32_t>(blocks.size());
    blocks.push_back({block, {}, {}});
  }
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(bodies_.size()); ++i) {
    const Body& body = bodies_[i];
    if (at[body.block] >= 0) blocks[at[body.block]].cells.push_back(i);
    const BlockGrid::FaceDistances distances = blocks_.faceDistances(body.position, body.block);
    // As in SharedBodies::distribute(), so that a rank has all of them.
    for (const BlockGrid::Neighbor& neighbor : blocks_.neighbors(body.block)) {
      if (neighbor.block == body.block || at[neighbor.block] < 0) continue;
      if (BlockGrid::squaredDistance(distances, neighbor.step) >= range_ * range_) continue;
      std::vector<std::int64_t>& around = blocks[at[neighbor.block]].around;
      if (around.empty() || around.back() != i) around.push_back(i);
    }
  }
  for (Block& block : blocks)
    std::sort(block.around.begin(), block.around.end(),
              [&](std::int64_t a, std::int64_t b) { return bodies_[a].id < bodies_[b].id; });
  return blocks;
}

std::vector<std::vector<std::int64_t>> GrowingCells::batches(std::size_t most) const {
  struct Run {  // the own cells of a block
    std::uint64_t at;
    std::int64_t begin, end;
  };
  std::vector<Run> runs;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(bodies_.size()); ++i) {
    if (!own_[i]) continue;
    if (runs.empty() || runs.back().end < i || bodies_[runs.back().begin].block != bodies_[i].block)
      runs.push_back({blocks_.curvePosition(bodies_[i].block), i, i});
    runs.back().end = i + 1;
  }
  std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.at < b.at; });
  std::vector<std::vector<std::int64_t>> batches;
  for (const Run& run : runs) {
    const auto more = static_cast<std::size_t>(run.end - run.begin);
    if (batches.empty() || batches.back().size() + more > most) batches.emplace_back();
    for (std::int64_t i = run.begin; i < run.end; ++i) batches.back().push_back(i);
  }
  for (std::vector<std::int64_t>& batch : batches) std::sort(batch.begin(), batch.end());
  return batches;
}

std::vector<std::vector<std::int64_t>> GrowingCells::partsOfBlocks(std::size_t most) const {
  std::vector<std::vector<std::int64_t>> parts;
  for (std::vector<std::int64_t>& block : batches(0))
    divide(bodies_, block.data(), block.data() + block.size(),
           static_cast<std::int64_t>((block.size() + most - 1) / most), parts);
  return parts;
}

namespace {

/// @param extent becomes how much larger the spheres are than cells and their reach
std::vector<Sphere> spheresAround(const Physics& physics, const std::vector<Body>& cells,
                                  const std::vector<double>& reach, std::vector<double>& extent) {
  std::vector<Sphere> spheres;
  spheres.reserve(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double least = cells[i].scale * physics.shapeOf(cells[i]).radius() + reach[i];
    extent[i] = std::max(0.0, extent[i] - least);
    spheres.push_back({cells[i].position, least + extent[i]});
  }
  return spheres;
}

}  // namespace

CellSurroundings::CellSurroundings(const Physics& physics, const std::vector<Body>& cells,
                                   std::vector<double> reach, std::vector<double> extent)
    : cells_(cells),
      reach_(std::move(reach)),
      beyond_(std::move(extent)),
      clearance_(physics.clearance),
      neighbors_(spheresAround(physics, cells, reach_, beyond_), physics.container->period()) {}

template <class Wanted, class Visit>
void CellSurroundings::forEachNear(std::int64_t cell, const Wanted& wanted, const Visit& visit) const {
  neighbors_.forEachNear(cell, clearance_, wanted, [&](const NearPair& pair) {
    if (pair.apart + (beyond_[pair.first] + beyond_[pair.second]) < clearance_) visit(pair);
  });
}

bool CellSurroundings::isNear(std::int64_t cell, const std::vector<char>& marked) const {
  bool near = false;
  const auto isMarked = [&](std::int64_t other) { return !near && marked[other]; };
  forEachNear(cell, isMarked, [&](const NearPair&) { near = true; });
  return near;
}

std::vector<NearPair> CellSurroundings::pairsOf(const std::vector<std::int64_t>& wanted) const {
  std::vector<NearPair> pairs;
  for (const std::int64_t cell : wanted) {
    const auto notYet = [&](std::int64_t other) {
      return other >= cell || !std::binary_search(wanted.begin(), wanted.end(), other);
    };
    forEachNear(cell, notYet, [&](const NearPair& pair) { pairs.push_back(pair); });
  }
  std::sort(pairs.begin(), pairs.end(), [](const NearPair& a, const NearPair& b) {
    return std::tie(a.first, a.second, a.shift[0], a.shift[1], a.shift[2]) <
           std::tie(b.first, b.second, b.shift[0], b.shift[1], b.shift[2]);
  });
  return pairs;
}

}  // namespace packmesh
