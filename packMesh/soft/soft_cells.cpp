// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace packmesh {
namespace {

constexpr int width = MembraneBatch::cells;

/// Stiffness of the links around a vertex, in units of that of one: the largest eigenvalue of a plane
/// lattice.
constexpr double linksAround = 6.0;
/// Share of the stiffness against changes of volume that steps allow for: with momentum they are stable up to
/// 2 (1 + momentum) times the inverse stiffness.
constexpr double volumeShare = 0.4;
/// Contacts are listed again when a vertex has moved by this share of the skin; half of it is the limit.
constexpr double listedFor = 0.45;
/// Decrease of the additional stiffness of bending in each iteration after cells have grown.
constexpr double softening = 0.95;
constexpr float leastGap = 4e-6f;  // [µm] rounding of positions and distances

}  // namespace

/// Cells of one template, in lanes.
struct SoftCells::Batch {
  int membrane = 0;
  std::vector<int> cells;
  std::vector<float> position, listed, step, force, gap;
  float scale[width], moves[width], volume[width], largestForce[width], farthest[width];
};

struct SoftCells::Cell {
  /// Contacts of a kind with another cell, or with itself.
  struct Group {
    int other;
    ContactKind kind;
    bool own;
    float offset[3];
    std::int64_t begin;  ///< block
    int size;
    std::size_t reactions = 0, reactionsEnd = 0;
  };
  struct Source {
    int cell, group;
  };
  int number = 0, membrane = 0, batch = 0, lane = 0;
  int wallNumber = -1;
  Vec3 anchor = Vec3::Zero();
  std::vector<float> position;  ///< relative to the anchor, 4 per vertex
  std::vector<float> force;     ///< 4 per vertex
  std::vector<float> gap;       ///< see MembraneBatch
  std::vector<float> wall;      ///< lower bounds of the gap to the wall
  ContactFours fours;
  std::vector<Group> groups;
  std::vector<Reaction> reactions;
  std::vector<Source> sources;
  Outline outline;
};

SoftCells::~SoftCells() = default;

SoftCells::SoftCells(std::vector<SoftCell> cells, const Vec3& period, std::vector<WallGap> walls,
                     const SoftSettings& settings, const Threads& threads)
    : walls_(std::move(walls)),
      period_(period),
      settings_(settings),
      threads_(threads),
      kernels_(proximityKernels(chosenInstructionSet())),
      membraneKernel_(membraneKernel(chosenInstructionSet())),
      cells_(cells.size()),
      scratch_(threads.count()),
      stiffening_(settings.stiffening) {
  addCells(cells);
  fillBatches(cells);
  if (smallestScale() == 1.0) stiffening_ = 1.0;
}

void SoftCells::addCells(const std::vector<SoftCell>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Cell& cell = cells_[i];
    const auto known = std::find(membranes_.begin(), membranes_.end(), cells[i].membrane);
    cell.membrane = int(known - membranes_.begin());
    if (known == membranes_.end()) {
      membranes_.push_back(cells[i].membrane);
      views_.push_back(cells[i].membrane->view());
      clusters_.emplace_back(*cells[i].membrane);
    }
    cell.number = int(i);
    cell.wallNumber = cells[i].wall;
    const std::vector<Vec3>& vertices = cells[i].vertices;
    cell.anchor =
        std::accumulate(vertices.begin(), vertices.end(), Vec3(Vec3::Zero())) / double(vertices.size());
    for (const Vec3& v : vertices) {
      const Vec3 local = v - cell.anchor;
      for (int k = 0; k < 3; ++k) cell.position.push_back(float(local[k]));
      cell.position.push_back(0.0f);
    }
    cell.force.resize(cell.position.size());
    cell.gap.resize(vertices.size());
    cell.wall.assign(vertices.size(), -1.0f);
  }
}

void SoftCells::fillBatches(const std::vector<SoftCell>& cells) {
  for (std::size_t m = 0; m < membranes_.size(); ++m)
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells_[i].membrane != int(m)) continue;
      if (batches_.empty() || batches_.back().membrane != int(m) || batches_.back().cells.size() == width) {
        batches_.emplace_back();
        batches_.back().membrane = int(m);
      }
      cells_[i].batch = int(batches_.size()) - 1;
      cells_[i].lane = int(batches_.back().cells.size());
      batches_.back().cells.push_back(int(i));
    }
  for (Batch& batch : batches_) {
    const MembraneView& m = views_[batch.membrane];
    const std::size_t n = std::size_t(m.vertices) * width;
    batch.position.resize(3 * n);
    batch.step.assign(3 * n, 0.0f);
    batch.force.resize(4 * n);
    batch.gap.assign(n, 0.0f);
    for (int lane = 0; lane < width; ++lane) {
      // Lanes without a cell repeat the first one, and stay.
      const bool present = lane < int(batch.cells.size());
      const int i = batch.cells[present ? lane : 0];
      batch.scale[lane] = float(cells[i].scale);
      batch.moves[lane] = present && !cells[i].fixed ? 1.0f : 0.0f;
      batch.farthest[lane] = batch.largestForce[lane] = batch.volume[lane] = 0.0f;
      for (int v = 0; v < m.vertices; ++v)
        for (int k = 0; k < 3; ++k)
          batch.position[(3 * v + k) * width + lane] = cells_[i].position[4 * v + k];
    }
    batch.listed = batch.position;
  }
}

double SoftCells::scaleOf(const Cell& cell) const {
  return batches_[cell.batch].scale[cell.lane];
}

double SoftCells::scale(std::size_t cell) const {
  return scaleOf(cells_[cell]);
}

double SoftCells::smallestScale() const {
  double least = 1.0;
  for (const Cell& cell : cells_) least = std::min(least, scaleOf(cell));
  return least;
}

double SoftCells::largestForce() const {
  float most = 0.0f;
  for (const Batch& batch : batches_)
    for (int lane = 0; lane < width; ++lane)
      most = std::max(most, batch.moves[lane] * batch.largestForce[lane]);
  return most;
}

std::vector<Vec3> SoftCells::vertices(std::size_t i) const {
  std::vector<Vec3> out;
  const Cell& cell = cells_[i];
  for (std::size_t v = 0; v < cell.gap.size(); ++v)
    out.push_back(cell.anchor +
                  Vec3(cell.position[4 * v], cell.position[4 * v + 1], cell.position[4 * v + 2]));
  return out;
}

void SoftCells::listContacts() {
  skin_ = settings_.skin * smallestScale();
  threads_.forEach(std::int64_t(cells_.size()), [&](std::int64_t i, int) {
    Cell& cell = cells_[i];
    cell.outline.fit(*membranes_[cell.membrane], clusters_[cell.membrane], cell.position.data());
    cell.sources.clear();
  });
  const auto near = neighbors();
  threads_.forEach(std::int64_t(cells_.size()), [&](std::int64_t i, int) { listFor(int(i), near[i]); });
  for (std::size_t i = 0; i < cells_.size(); ++i)
    for (std::size_t g = 0; g < cells_[i].groups.size(); ++g)
      cells_[cells_[i].groups[g].other].sources.push_back({int(i), int(g)});
  for (Batch& batch : batches_) {
    batch.listed = batch.position;
    std::fill(batch.farthest, batch.farthest + width, 0.0f);
  }
  listed_ = true;
}

/// Of each cell: the cells and their displacements to periodic images whose boxes are near its own; among
/// them the cell itself.
std::vector<std::vector<std::pair<int, Vec3>>> SoftCells::neighbors() const {
  struct Image {
    double lo, hi;  ///< along x
    int cell;
    Vec3 shift;
  };
  const double reach = std::max(settings_.range, settings_.edgeRange) + skin_ + settings_.clearance;
  const auto low = [](const Cell& c, int k) { return c.anchor[k] + c.outline.all.lo[k]; };
  const auto high = [](const Cell& c, int k) { return c.anchor[k] + c.outline.all.hi[k]; };
  Vec3 lo = Vec3::Constant(std::numeric_limits<double>::max()), hi = -lo;
  for (const Cell& c : cells_)
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], low(c, k));
      hi[k] = std::max(hi[k], high(c, k));
    }
  std::vector<Image> images;
  double longest = 0.0;
  for (const Cell& c : cells_) {
    int first[3] = {0, 0, 0}, last[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      if (period_[k] <= 0.0) continue;
      first[k] = int(std::ceil((lo[k] - reach - high(c, k)) / period_[k]));
      last[k] = int(std::floor((hi[k] + reach - low(c, k)) / period_[k]));
    }
    longest = std::max(longest, high(c, 0) - low(c, 0));
    for (int x = first[0]; x <= last[0]; ++x)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int z = first[2]; z <= last[2]; ++z) {
          const Vec3 shift = Vec3(x, y, z).cwiseProduct(period_);
          images.push_back({low(c, 0) + shift[0], high(c, 0) + shift[0], c.number, shift});
        }
  }
  std::stable_sort(images.begin(), images.end(), [](const Image& a, const Image& b) { return a.lo < b.lo; });
  std::vector<std::vector<std::pair<int, Vec3>>> near(cells_.size());
  threads_.forEach(std::int64_t(cells_.size()), [&](std::int64_t i, int) {
    const Cell& a = cells_[i];
    auto at = std::lower_bound(images.begin(), images.end(), low(a, 0) - reach - longest,
                               [](const Image& image, double x) { return image.lo < x; });
    for (; at != images.end() && at->lo <= high(a, 0) + reach; ++at) {
      const Cell& b = cells_[at->cell];
      bool overlap = at->hi >= low(a, 0) - reach;
      for (int k = 1; k < 3; ++k)
        overlap = overlap && low(b, k) + at->shift[k] <= high(a, k) + reach &&
                  high(b, k) + at->shift[k] >= low(a, k) - reach;
      if (overlap) near[i].emplace_back(at->cell, at->shift);
    }
    std::sort(near[i].begin(), near[i].end(), [](const auto& p, const auto& q) {
      return std::tuple(p.first, p.second[0], p.second[1], p.second[2]) <
             std::tuple(q.first, q.second[0], q.second[1], q.second[2]);
    });
  });
  return near;
}

void SoftCells::listFor(int i, const std::vector<std::pair<int, Vec3>>& near) {
  Cell& cell = cells_[i];
  ContactLister lister(kernels_);
  cell.fours.clear();
  cell.groups.clear();
  const ListedCell first{&clusters_[cell.membrane], &cell.outline, cell.position.data()};
  for (const auto& [j, shift] : near) {
    const Cell& other = cells_[j];
    const Vec3 apart = other.anchor + shift - cell.anchor;
    const float offset[3] = {float(apart[0]), float(apart[1]), float(apart[2])};
    const ListedCell second{&clusters_[other.membrane], &other.outline, other.position.data()};
    const bool same = j == i && shift.isZero();
    // Pairs of edges are listed by one of the two cells, with one of two opposite images of itself.
    const bool listsEdges =
        j > i || same || (j == i && std::tuple(shift[0], shift[1], shift[2]) > std::tuple(0.0, 0.0, 0.0));
    for (const ContactKind kind : {ContactKind::vertexTriangle, ContactKind::edgeEdge}) {
      if (kind == ContactKind::edgeEdge && !listsEdges) continue;
      const double range = kind == ContactKind::edgeEdge ? settings_.edgeRange : settings_.range;
      const float limit = float(range + skin_ + (same ? 0.0 : settings_.clearance));
      const int found = lister.list(kind, first, second, offset, limit, same, cell.fours);
      if (found > 0)
        cell.groups.push_back({j,
                               kind,
                               same,
                               {offset[0], offset[1], offset[2]},
                               (cell.fours.size() - found) / ContactFours::width,
                               found});
    }
  }
}

/// The forces on a cell of the contacts that it lists, and their reactions.
void SoftCells::contacts(Cell& cell) const {
  const float scale = float(scaleOf(cell));
  std::fill(cell.force.begin(), cell.force.end(), 0.0f);
  // What is not listed is farther away than the shorter range.
  std::fill(cell.gap.begin(), cell.gap.end(), float(std::min(settings_.edgeRange, settings_.range)) * scale);
  std::size_t used = 0;
  for (Cell::Group& group : cell.groups) {
    const Cell& other = cells_[group.other];
    const CellPair pair{
        cell.position.data(), other.position.data(), {group.offset[0], group.offset[1], group.offset[2]}};
    const double range = group.kind == ContactKind::edgeEdge ? settings_.edgeRange : settings_.range;
    const Barrier barrier{group.own ? 0.0f : float(settings_.clearance),
                          float(range * 0.5 * (scale + scaleOf(other))), float(settings_.stiffness)};
    if (cell.reactions.size() < used + std::size_t(group.size)) cell.reactions.resize(used + group.size);
    group.reactions = used;
    used += kernels_.forces(group.kind, pair, cell.fours.blocks() + group.begin, group.size, barrier,
                            cell.force.data(), cell.gap.data(), cell.reactions.data() + used);
    group.reactionsEnd = used;
  }
}

/// The reactions of contacts that other cells list, or the cell itself.
void SoftCells::reactions(Cell& cell) const {
  for (const Cell::Source& source : cell.sources) {
    const Cell& from = cells_[source.cell];
    const Cell::Group& group = from.groups[source.group];
    const int corners = group.kind == ContactKind::edgeEdge ? 2 : 3;
    for (std::size_t r = group.reactions; r < group.reactionsEnd; ++r) {
      const Reaction& one = from.reactions[r];
      for (int c = 0; c < corners; ++c) {
        float* f = cell.force.data() + 4 * one.vertex[c];
        for (int k = 0; k < 3; ++k) f[k] -= one.weight[c] * one.force[k];
        f[3] += one.weight[c] * one.stiffness;
        float& gap = cell.gap[one.vertex[c]];
        gap = std::min(gap, one.gap);
      }
    }
  }
  if (cell.wallNumber >= 0) wallForces(cell, float(scaleOf(cell)));
}

void SoftCells::wallForces(Cell& cell, float scale) const {
  const float range = float(settings_.wallRange) * scale;
  for (std::size_t v = 0; v < cell.gap.size(); ++v) {
    if (cell.wall[v] > range) continue;
    const float* p = cell.position.data() + 4 * v;
    const WallDistance at = walls_[cell.wallNumber](cell.anchor + Vec3(p[0], p[1], p[2]));
    cell.wall[v] = float(at.distance);
    const float gap = std::max(float(at.distance), leastGap);
    cell.gap[v] = std::min(cell.gap[v], std::max(float(at.distance) - leastGap, 0.0f));
    if (gap >= range) continue;
    const float slope = float(settings_.stiffness) * range / gap;
    float* f = cell.force.data() + 4 * v;
    for (int k = 0; k < 3; ++k) f[k] += slope * (range - gap) * float(at.gradient[k]);
    f[3] += slope * range / gap;
  }
}

void SoftCells::advance(Batch& batch, std::vector<float>& scratch) {
  const MembraneView& m = views_[batch.membrane];
  scratch.resize(std::max(scratch.size(), m.scratch() * width));
  Cell* cells[width];
  for (int lane = 0; lane < width; ++lane)
    cells[lane] = &cells_[batch.cells[lane < int(batch.cells.size()) ? lane : 0]];
  for (int v = 0; v < m.vertices; ++v)
    for (int lane = 0; lane < width; ++lane) {
      const float* f = cells[lane]->force.data() + 4 * v;
      for (int k = 0; k < 4; ++k) batch.force[(4 * v + k) * width + lane] = f[k];
      batch.gap[v * width + lane] = cells[lane]->gap[v];
    }
  const double ofLinks = linksAround * (1.0 + 1.0 / MembraneLimits::link) * m.linkForce * m.inverseMeanEdge;
  const double stiffness = std::max(ofLinks, volumeShare * m.volumeStiffness);
  membraneKernel_(
      m,
      {batch.position.data(), batch.listed.data(), batch.step.data(), batch.force.data(), batch.gap.data(),
       scratch.data(), batch.scale, batch.moves, batch.volume, batch.largestForce, batch.farthest},
      {float(settings_.momentum), float(settings_.shareOfGap), mostStep_, float(stiffness)});
  for (int v = 0; v < m.vertices; ++v)
    for (int lane = 0; lane < int(batch.cells.size()); ++lane) {
      float squared = 0.0f;
      for (int k = 0; k < 3; ++k) {
        cells[lane]->position[4 * v + k] = batch.position[(3 * v + k) * width + lane];
        const float s = batch.step[(3 * v + k) * width + lane];
        squared += s * s;
      }
      cells[lane]->wall[v] -= std::sqrt(squared);
    }
}

void SoftCells::grow() {
  for (Batch& batch : batches_)
    for (int lane = 0; lane < int(batch.cells.size()); ++lane) {
      float& scale = batch.scale[lane];
      const double atRest = membranes_[batch.membrane]->volume() * scale * scale * scale;
      if (scale < 1.0f && batch.volume[lane] > (1.0 - settings_.mostCompressed) * atRest)
        scale = std::min(1.0f, scale * float(1.0 + settings_.swelling));
    }
  if (smallestScale() == 1.0) stiffening_ = std::max(1.0, softening * stiffening_);
}

void SoftCells::step() {
  // What is not listed stays out of range as long as no vertex moves by more than half a skin.
  float farthest = 0.0f;
  for (const Batch& batch : batches_)
    farthest = std::max(farthest, *std::max_element(batch.farthest, batch.farthest + width));
  if (!listed_ || farthest > float(listedFor * skin_)) {
    listContacts();
    farthest = 0.0f;
  }
  mostStep_ = 0.5f * float(skin_) - farthest;
  for (std::size_t m = 0; m < views_.size(); ++m)
    views_[m].bendForce = membranes_[m]->view().bendForce * float(stiffening_);
  const std::int64_t cells = std::int64_t(cells_.size());
  threads_.forEach(cells, [&](std::int64_t i, int) { contacts(cells_[i]); });
  threads_.forEach(cells, [&](std::int64_t i, int) { reactions(cells_[i]); });
  threads_.forEach(std::int64_t(batches_.size()),
                   [&](std::int64_t b, int thread) { advance(batches_[b], scratch_[thread]); });
  grow();
  ++iterations_;
}

}  // namespace packmesh
