// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/soft/soft_cells.h"

#include <algorithm>
#include <cmath>
#include <functional>
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
constexpr double softening = 0.92;
constexpr float leastGap = 4e-6f;   // [µm] rounding of positions and distances
constexpr float notKnown = -1.0f;   // gap to the wall
constexpr std::size_t oneOf = 100;  // cells may have a larger force than usual

}  // namespace

/// Cells of one template, in lanes.
struct SoftCells::Batch {
  int membrane = 0;
  std::vector<int> cells;
  std::vector<float> position, listed, step;
  float scale[width], moves[width], volume[width], largestForce[width], farthest[width];
};

/// Memory for many short lists, all of which end together.
template <class T>
class SoftCells::Pages {
 public:
  /// For `size` of them, of which keep() says how many are used.
  T* room(std::size_t size) {
    if (page_ < pages_.size() && used_ + size > pages_[page_].size()) {
      ++page_;
      used_ = 0;
    }
    if (page_ == pages_.size()) pages_.emplace_back(firstSize << std::min(page_, mostDoubled));
    if (pages_[page_].size() < size) pages_[page_].resize(size);  // nothing is in it
    return pages_[page_].data() + used_;
  }
  void keep(std::size_t size) { used_ += size; }
  void clear() { page_ = used_ = 0; }
  /// Clears it, and frees all but one page.
  void shrink() {
    if (pages_.size() > 1) pages_.resize(1);
    clear();
  }

 private:
  /// Of pages: each is twice as large as the one before, so often.
  static constexpr std::size_t firstSize = (std::size_t(1) << 14) / sizeof(T), mostDoubled = 6;
  std::vector<std::vector<T>> pages_;
  std::size_t page_ = 0, used_ = 0;  ///< the one that is being filled, and how many are in it
};

/// What a thread needs.
struct SoftCells::Thread {
  explicit Thread(const ContactKernels& kernels) : lister(kernels) {}

  ContactLister lister;
  ContactFours listed;
  std::vector<Vec3f> normals;
  std::vector<float> numbers;
  std::vector<float> force, gap;  ///< of cells of other ranks, which are not needed
  Pages<std::int16_t> fours;
  Pages<float> until;
  Pages<Reaction> reactions;  ///< of the current step
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
    const Reaction *reactions = nullptr, *reactionsEnd = nullptr;  ///< in the last step
  };
  struct Source {
    int cell, group;
  };
  int number = 0, membrane = 0, batch = 0, lane = 0;
  int wallNumber = -1;
  float scale = 1.0f;
  float moved = 0.0f;  ///< sum of the largest steps since contacts were listed [µm]
  Vec3 anchor = Vec3::Zero();
  FloatBox box;  ///< around the vertices when contacts were listed
  std::vector<float>
      position;  ///< relative to the anchor, 4 per vertex; none if no cell of this rank is near
  // Of this rank's cells:
  std::vector<float> force;  ///< 4 per vertex
  std::vector<float> gap;    ///< see MembraneBatch
  std::vector<float> wall;   ///< lower bounds of the gap to the wall, if there is one
  const VertexFours* fours = nullptr;
  float* until = nullptr;  ///< of each block of them, see Approach
  std::vector<Group> groups;
  std::vector<Source> sources;
  Outline outline;
};

SoftCells::~SoftCells() = default;

SoftCells::SoftCells(std::vector<SoftCell> cells, const Vec3& period, std::vector<WallGap> walls,
                     const SoftSettings& settings, const Threads& threads, const Communicator& ranks)
    : walls_(std::move(walls)),
      period_(period),
      settings_(settings),
      threads_(threads),
      kernels_(proximityKernels(chosenInstructionSet())),
      membraneKernel_(membraneKernel(chosenInstructionSet())),
      cells_(cells.size()),
      ofThread_(threads.count(), Thread(kernels_)),
      stiffening_(settings.stiffening) {
  addCells(cells, ranks);
  fillBatches(cells);
  if (smallestScale() == 1.0) stiffening_ = 1.0;
}

void SoftCells::addCells(const std::vector<SoftCell>& cells, const Communicator& ranks) {
  std::vector<Vec3> centers;
  std::vector<std::int64_t> work;
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
    cell.scale = float(cells[i].scale);
    smallestScale_ = std::min(smallestScale_, double(cell.scale));
    const std::vector<Vec3>& vertices = cells[i].vertices;
    cell.position.reserve(4 * vertices.size());
    cell.anchor =
        std::accumulate(vertices.begin(), vertices.end(), Vec3(Vec3::Zero())) / double(vertices.size());
    for (const Vec3& v : vertices) {
      const Vec3 local = v - cell.anchor;
      for (int k = 0; k < 3; ++k) cell.position.push_back(float(local[k]));
      cell.position.push_back(0.0f);
    }
    centers.push_back(cell.anchor);
    work.push_back(std::int64_t(vertices.size()));
  }
  shares_ = SoftShares(centers, work, ranks);
  for (const int i : mine()) {
    Cell& cell = cells_[i];
    cell.force.resize(cell.position.size());
    cell.gap.resize(cell.position.size() / 4);
    if (cell.wallNumber >= 0) cell.wall.assign(cell.gap.size(), notKnown);
  }
}

void SoftCells::fillBatches(const std::vector<SoftCell>& cells) {
  for (std::size_t m = 0; m < membranes_.size(); ++m)
    for (const int i : mine()) {
      if (cells_[i].membrane != int(m)) continue;
      if (batches_.empty() || batches_.back().membrane != int(m) || batches_.back().cells.size() == width) {
        batches_.emplace_back();
        batches_.back().membrane = int(m);
      }
      cells_[i].batch = int(batches_.size()) - 1;
      cells_[i].lane = int(batches_.back().cells.size());
      batches_.back().cells.push_back(i);
    }
  for (Batch& batch : batches_) {
    const MembraneView& m = views_[batch.membrane];
    const std::size_t n = std::size_t(m.vertices) * width;
    batch.position.resize(3 * n);
    batch.step.assign(3 * n, 0.0f);
    for (int lane = 0; lane < width; ++lane) {
      // Lanes without a cell repeat the first one, and stay.
      const bool present = lane < int(batch.cells.size());
      const int i = batch.cells[present ? lane : 0];
      batch.scale[lane] = cells_[i].scale;
      batch.moves[lane] = present && !cells[i].fixed ? 1.0f : 0.0f;
      batch.farthest[lane] = batch.largestForce[lane] = batch.volume[lane] = 0.0f;
      for (int v = 0; v < m.vertices; ++v)
        for (int k = 0; k < 3; ++k)
          batch.position[(3 * v + k) * width + lane] = cells_[i].position[4 * v + k];
    }
    batch.listed = batch.position;
  }
}

double SoftCells::scale(std::size_t cell) const {
  return cells_[cell].scale;
}

/// What the batches of all ranks have in common.
void SoftCells::summarize() {
  float farthest = 0.0f;
  double scale = 1.0;
  for (const Batch& batch : batches_)
    for (int lane = 0; lane < int(batch.cells.size()); ++lane) {
      farthest = std::max(farthest, batch.farthest[lane]);
      scale = std::min(scale, double(batch.scale[lane]));
    }
  std::vector<std::int64_t> none;
  std::vector<double> most = {farthest, -scale};
  team().sumAndMax(none, most);
  farthest_ = float(most[0]);
  smallestScale_ = -most[1];
}

double SoftCells::usualForce() const {
  std::vector<float> own;
  for (const Batch& batch : batches_)
    for (int lane = 0; lane < int(batch.cells.size()); ++lane)
      if (batch.moves[lane] > 0.0f) own.push_back(batch.largestForce[lane]);
  std::vector<float> all = team().gatherAll(own);
  const auto at = all.begin() + std::ptrdiff_t(all.size() / oneOf);
  if (at == all.end()) return 0.0;
  std::nth_element(all.begin(), at, all.end(), std::greater<float>());
  return *at;
}

std::vector<Vec3> SoftCells::vertices(std::size_t i) const {
  std::vector<Vec3> out;
  const Cell& cell = cells_[i];
  for (std::size_t v = 0; 4 * v < cell.position.size(); ++v)
    out.push_back(cell.anchor +
                  Vec3(cell.position[4 * v], cell.position[4 * v + 1], cell.position[4 * v + 2]));
  return out;
}

/// What other ranks need of a cell: its scale, steps and positions.
void SoftCells::pack(int i, std::vector<float>& to) const {
  const std::vector<float>& position = cells_[i].position;
  to.insert(to.end(), {cells_[i].scale, cells_[i].moved});
  for (std::size_t at = 0; at < position.size(); at += 4)
    to.insert(to.end(), &position[at], &position[at + 3]);
}

/// @return after the numbers of the cell
const float* SoftCells::unpack(int i, const float* from) {
  Cell& cell = cells_[i];
  cell.scale = *from++;
  cell.moved = *from++;
  cell.position.resize(4 * std::size_t(views_[cell.membrane].vertices));
  for (std::size_t at = 0; at < cell.position.size(); at += 4, from += 3)
    std::copy(from, from + 3, &cell.position[at]);
  return from;
}

void SoftCells::gather() {
  shares_.gather([&](int i, std::vector<float>& to) { pack(i, to); },
                 [&](int i, const float* from) { return unpack(i, from); });
}

void SoftCells::forgetContacts() {
  for (Thread& thread : ofThread_) {
    thread.fours.shrink();
    thread.until.shrink();
    thread.reactions.shrink();
  }
  returnFreedMemory();
}

/// Sends scales and positions to the ranks that need them.
void SoftCells::exchange() {
  shares_.exchange([&](int i, std::vector<float>& to) { pack(i, to); },
                   [&](int i, const float* from) { return unpack(i, from); });
}

SoftCellsState SoftCells::state() const {
  SoftCellsState to;
  to.iterations = iterations_;
  to.stiffening = stiffening_;
  to.skin = listed_ ? skin_ : 0.0;
  const auto numbersOf = [&](int i, std::vector<double>& all) {
    const Cell& cell = cells_[i];
    const Batch& batch = batches_[cell.batch];
    all.insert(all.end(), cell.anchor.begin(), cell.anchor.end());
    all.insert(all.end(), {batch.scale[cell.lane], batch.farthest[cell.lane]});
  };
  const auto numbersOfVertices = [&](int i, std::vector<float>& all) {
    const Cell& cell = cells_[i];
    const Batch& batch = batches_[cell.batch];
    for (std::size_t v = 0; v < cell.gap.size(); ++v) {
      for (const std::vector<float>* of : {&batch.position, &batch.listed, &batch.step})
        for (std::size_t k = 0; k < 3; ++k) all.push_back((*of)[(3 * v + k) * width + cell.lane]);
      all.push_back(cell.wall.empty() ? notKnown : cell.wall[v]);
    }
  };
  to.cells = shares_.byIds<double>(numbersOf, [](int) { return SoftCellsState::perCell; });
  to.vertices = shares_.byIds<float>(numbersOfVertices, [&](int i) {
    return SoftCellsState::perVertex * views_[cells_[i].membrane].vertices;
  });
  return to;
}

void SoftCells::restore(const SoftCellsState& from) {
  iterations_ = from.iterations;
  stiffening_ = from.stiffening;
  skin_ = from.skin;
  listed_ = skin_ > 0.0;
  const double* ofCell = from.cells.data();
  const float* ofVertex = from.vertices.data();
  for (Cell& cell : cells_) {
    cell.anchor = Vec3(ofCell);
    cell.scale = float(ofCell[3]);
    const bool own = shares_.isMine(cell.number);
    if (own) batches_[cell.batch].scale[cell.lane] = cell.scale;
    if (own) batches_[cell.batch].farthest[cell.lane] = float(ofCell[4]);
    ofCell += SoftCellsState::perCell;
    for (std::size_t v = 0; 4 * v < cell.position.size(); ++v, ofVertex += SoftCellsState::perVertex) {
      for (std::size_t k = 0; k < 3; ++k) {
        cell.position[4 * v + k] = ofVertex[3 + k];
        if (!own) continue;
        Batch& batch = batches_[cell.batch];
        const std::size_t at = (3 * v + k) * width + cell.lane;
        batch.position[at] = ofVertex[k];
        batch.listed[at] = ofVertex[3 + k];
        batch.step[at] = ofVertex[6 + k];
      }
      if (!cell.wall.empty()) cell.wall[v] = ofVertex[9];
    }
  }
  if (!computes()) return;
  summarize();
  if (listed_) listContacts();  // for where the vertices were then
  for (const int i : mine()) {
    Cell& cell = cells_[i];
    for (std::size_t v = 0; v < cell.gap.size(); ++v)
      for (std::size_t k = 0; k < 3; ++k)
        cell.position[4 * v + k] = batches_[cell.batch].position[(3 * v + k) * width + cell.lane];
  }
  exchange();
}

/// Lists the contacts of cells where they are, up to their range and a skin.
void SoftCells::listContacts() {
  for (Thread& thread : ofThread_) {
    thread.fours.clear();
    thread.until.clear();
    thread.reactions.shrink();  // outlines need as much memory
  }
  const auto fit = [&](Cell& cell, Thread& thread) {
    findNormals(*membranes_[cell.membrane], cell.position.data(), thread.normals);
    cell.outline.fit(clusters_[cell.membrane], cell.position.data(), thread.normals);
    cell.box = cell.outline.all;
  };
  threads_.forEach(std::int64_t(mine().size()),
                   [&](std::int64_t n, int thread) { fit(cells_[mine()[n]], ofThread_[thread]); });
  struct Boxed {
    int cell;
    FloatBox box;
  };
  std::vector<Boxed> boxes;
  if (!team().alone())
    for (const int i : mine()) boxes.push_back({i, cells_[i].box});
  for (const Boxed& one : team().gatherAll(boxes)) cells_[one.cell].box = one.box;
  SoftNeighbors near = neighbors();
  shares_.find(near);
  forgetOthers();
  exchange();
  const std::vector<int>& others = shares_.others();
  threads_.forEach(std::int64_t(others.size()),
                   [&](std::int64_t n, int thread) { fit(cells_[others[n]], ofThread_[thread]); });
  for (Cell& cell : cells_) {
    cell.sources.clear();
    cell.groups.clear();
    cell.moved = 0.0f;
  }
  listing_ = mine();
  listing_.insert(listing_.end(), others.begin(), others.end());
  std::sort(listing_.begin(), listing_.end());
  threads_.forEach(std::int64_t(listing_.size()), [&](std::int64_t n, int thread) {
    listFor(listing_[n], near[listing_[n]], ofThread_[thread]);
  });
  for (Cell& cell : cells_) cell.outline = {};
  for (const int i : listing_) {
    near[i].clear();
    for (std::size_t g = 0; g < cells_[i].groups.size(); ++g) {
      near[i].emplace_back(cells_[i].groups[g].other, Vec3::Zero());
      cells_[near[i].back().first].sources.push_back({i, int(g)});
    }
  }
  shares_.find(near);  // until the next lists, only cells with contacts
}

/// Of cells that are not near those of this rank.
void SoftCells::forgetOthers() {
  const std::vector<int>& others = shares_.others();
  for (Cell& cell : cells_)
    if (!shares_.isMine(cell.number) && !std::binary_search(others.begin(), others.end(), cell.number))
      std::vector<float>().swap(cell.position);
}

SoftNeighbors SoftCells::neighbors() const {
  const double reach = std::max(settings_.range, settings_.edgeRange) + skin_ + settings_.clearance;
  std::vector<Box> boxes;
  for (const Cell& c : cells_)
    boxes.push_back({c.anchor + Vec3f(c.box.lo).cast<double>(), c.anchor + Vec3f(c.box.hi).cast<double>()});
  return nearBoxes(boxes, period_, reach, threads_);
}

void SoftCells::listFor(int i, const std::vector<std::pair<int, Vec3>>& near, Thread& thread) {
  Cell& cell = cells_[i];
  thread.listed.clear();
  findNormals(*membranes_[cell.membrane], cell.position.data(), thread.normals);
  const ListedCell first{&clusters_[cell.membrane], &cell.outline, cell.position.data(), &thread.normals};
  for (const auto& [j, shift] : near) {
    if (!shares_.isMine(i) && !shares_.isMine(j)) continue;
    const Cell& other = cells_[j];
    const Vec3 apart = other.anchor + shift - cell.anchor;
    const float offset[3] = {float(apart[0]), float(apart[1]), float(apart[2])};
    const ListedCell second{&clusters_[other.membrane], &other.outline, other.position.data(),
                            &thread.normals};
    const bool same = j == i && shift.isZero();
    // Pairs of edges are listed by one of the two cells, with one of two opposite images of itself.
    const bool listsEdges =
        j > i || same || (j == i && std::tuple(shift[0], shift[1], shift[2]) > std::tuple(0.0, 0.0, 0.0));
    for (const ContactKind kind : {ContactKind::vertexTriangle, ContactKind::edgeEdge}) {
      if (kind == ContactKind::edgeEdge && !listsEdges) continue;
      const double range = kind == ContactKind::edgeEdge ? settings_.edgeRange : settings_.range;
      const float limit = float(range + skin_ + (same ? 0.0 : settings_.clearance));
      const int found = thread.lister.list(kind, first, second, offset, limit, same, thread.listed);
      if (found > 0)
        cell.groups.push_back({j,
                               kind,
                               same,
                               {offset[0], offset[1], offset[2]},
                               (thread.listed.size() - found) / ContactFours::width,
                               found});
    }
  }
  const auto blocks = std::size_t((thread.listed.size() + ContactFours::width - 1) / ContactFours::width);
  const std::size_t numbers = blocks * sizeof(VertexFours) / sizeof(std::int16_t);
  std::int16_t* const fours = thread.fours.room(numbers);
  std::copy_n(thread.listed.numbers(), numbers, fours);
  thread.fours.keep(numbers);
  cell.fours = reinterpret_cast<const VertexFours*>(fours);
  cell.until = thread.until.room(blocks);
  std::fill_n(cell.until, blocks, 0.0f);
  thread.until.keep(blocks);
}

/// The forces on a cell of the contacts that it lists, and their reactions.
void SoftCells::contacts(Cell& cell, Thread& thread) const {
  const float scale = cell.scale;
  std::vector<float>& force = shares_.isMine(cell.number) ? cell.force : thread.force;
  std::vector<float>& gap = shares_.isMine(cell.number) ? cell.gap : thread.gap;
  force.assign(cell.position.size(), 0.0f);
  // What is not listed is farther away than the shorter range.
  gap.assign(cell.position.size() / 4, float(std::min(settings_.edgeRange, settings_.range)) * scale);
  for (Cell::Group& group : cell.groups) {
    const Cell& other = cells_[group.other];
    const CellPair pair{
        cell.position.data(), other.position.data(), {group.offset[0], group.offset[1], group.offset[2]}};
    const double range = group.kind == ContactKind::edgeEdge ? settings_.edgeRange : settings_.range;
    const Barrier barrier{group.own ? 0.0f : float(settings_.clearance),
                          float(range * 0.5 * (scale + double(other.scale))), float(settings_.stiffness)};
    Reaction* const reactions = thread.reactions.room(std::size_t(group.size));
    const int found = kernels_.forces(group.kind, pair, cell.fours + group.begin, group.size, barrier,
                                      {cell.moved + other.moved, cell.until + group.begin}, force.data(),
                                      gap.data(), reactions);
    thread.reactions.keep(std::size_t(found));
    group.reactions = reactions;
    group.reactionsEnd = reactions + found;
  }
}

/// The reactions of contacts that other cells list, or the cell itself.
void SoftCells::reactions(Cell& cell) const {
  for (const Cell::Source& source : cell.sources) {
    const Cell& from = cells_[source.cell];
    const Cell::Group& group = from.groups[source.group];
    const int corners = group.kind == ContactKind::edgeEdge ? 2 : 3;
    for (const Reaction* reaction = group.reactions; reaction != group.reactionsEnd; ++reaction) {
      const Reaction& one = *reaction;
      const float weight[3] = {1.0f - one.second - one.third, one.second, one.third};
      for (int c = 0; c < corners; ++c) {
        float* f = cell.force.data() + 4 * one.vertex[c];
        for (int k = 0; k < 3; ++k) f[k] -= weight[c] * one.force[k];
        f[3] += weight[c] * one.stiffness;
        float& gap = cell.gap[one.vertex[c]];
        gap = std::min(gap, one.gap);
      }
    }
  }
  if (cell.wallNumber >= 0) wallForces(cell, cell.scale);
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
  const std::size_t numbers = std::size_t(m.vertices) * width;
  scratch.resize(std::max(scratch.size(), m.scratch() * width + 5 * numbers));
  float* const forces = scratch.data() + m.scratch() * width;
  float* const gaps = forces + 4 * numbers;
  Cell* cells[width];
  for (int lane = 0; lane < width; ++lane)
    cells[lane] = &cells_[batch.cells[lane < int(batch.cells.size()) ? lane : 0]];
  for (int v = 0; v < m.vertices; ++v)
    for (int lane = 0; lane < width; ++lane) {
      const float* f = cells[lane]->force.data() + 4 * v;
      for (int k = 0; k < 4; ++k) forces[(4 * v + k) * width + lane] = f[k];
      gaps[v * width + lane] = cells[lane]->gap[v];
    }
  const double ofLinks = linksAround * (1.0 + 1.0 / MembraneLimits::link) * m.linkForce * m.inverseMeanEdge;
  const double stiffness = std::max(ofLinks, volumeShare * m.volumeStiffness);
  membraneKernel_(
      m,
      {batch.position.data(), batch.listed.data(), batch.step.data(), forces, gaps, scratch.data(),
       batch.scale, batch.moves, batch.volume, batch.largestForce, batch.farthest},
      {float(settings_.momentum), float(settings_.shareOfGap), mostStep_, float(stiffness)});
  float largest[width] = {};
  for (int v = 0; v < m.vertices; ++v)
    for (int lane = 0; lane < int(batch.cells.size()); ++lane) {
      float squared = 0.0f;
      for (int k = 0; k < 3; ++k) {
        cells[lane]->position[4 * v + k] = batch.position[(3 * v + k) * width + lane];
        const float s = batch.step[(3 * v + k) * width + lane];
        squared += s * s;
      }
      if (!cells[lane]->wall.empty()) cells[lane]->wall[v] -= std::sqrt(squared);
      largest[lane] = std::max(largest[lane], squared);
    }
  for (int lane = 0; lane < int(batch.cells.size()); ++lane) cells[lane]->moved += std::sqrt(largest[lane]);
}

void SoftCells::grow() {
  for (Batch& batch : batches_)
    for (int lane = 0; lane < int(batch.cells.size()); ++lane) {
      float& scale = batch.scale[lane];
      const double atRest = membranes_[batch.membrane]->volume() * scale * scale * scale;
      if (scale < 1.0f && batch.volume[lane] > (1.0 - settings_.mostCompressed) * atRest)
        scale = std::min(1.0f, scale * float(1.0 + settings_.swelling));
      cells_[batch.cells[lane]].scale = scale;
    }
  summarize();
  if (smallestScale() == 1.0) stiffening_ = std::max(1.0, softening * stiffening_);
}

void SoftCells::step() {
  // What is not listed stays out of range as long as no vertex moves by more than half a skin.
  if (!listed_ || farthest_ > float(listedFor * skin_)) {
    skin_ = settings_.skin * smallestScale();
    listContacts();
    for (Batch& batch : batches_) {
      batch.listed = batch.position;
      std::fill(batch.farthest, batch.farthest + width, 0.0f);
    }
    listed_ = true;
    farthest_ = 0.0f;
  }
  mostStep_ = 0.5f * float(skin_) - farthest_;
  for (std::size_t m = 0; m < views_.size(); ++m)
    views_[m].bendForce = membranes_[m]->view().bendForce * float(stiffening_);
  for (Thread& thread : ofThread_) thread.reactions.clear();
  threads_.forEach(std::int64_t(listing_.size()),
                   [&](std::int64_t n, int thread) { contacts(cells_[listing_[n]], ofThread_[thread]); });
  threads_.forEach(std::int64_t(mine().size()), [&](std::int64_t n, int) { reactions(cells_[mine()[n]]); });
  threads_.forEach(std::int64_t(batches_.size()),
                   [&](std::int64_t b, int thread) { advance(batches_[b], ofThread_[thread].numbers); });
  grow();
  exchange();
  ++iterations_;
}

}  // namespace packmesh
