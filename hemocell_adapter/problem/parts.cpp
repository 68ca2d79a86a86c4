// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "hemocell_adapter/problem/blood.h"
#include "hemocell_adapter/problem/make_lumen.h"
#include "hemocell_adapter/problem/other_spacings.h"
#include "hemocell_adapter/problem/solid.h"
#include "packMesh/container/region.h"
#include "packMesh/container/side_wall.h"
#include "packMesh/core/error.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/random.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/placement/lumen_cut.h"
#include "packMesh/placement/placement.h"

namespace packmesh::hemocell {
namespace {

/// Relative deviation from a region's hematocrit that causes a warning.
constexpr double noticeable = 0.1;

/// Cells of a shell may leave it by this part of its thickness, so that no shell can be jammed by itself.
constexpr double overlapOfShells = 0.2;

/// Points that are tried, at most: for each cell, and besides.
constexpr std::int64_t triesOfCell = 2000, fewestTries = 100000;

/// Purposes of the random numbers of poses, beside those of placeRandomly().
constexpr std::uint32_t ownPurpose = 1 << 20;

/// A random subset of `count` of the cells, in their order.
std::vector<Cell> drawn(std::vector<Cell> cells, std::int64_t count, std::uint64_t seed,
                        std::uint64_t stream) {
  if (count >= std::int64_t(cells.size())) return cells;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < cells.size(); ++i)
    order.emplace_back(uniform4(seed, RandomStream::draw, i, std::uint32_t(stream))[0], i);
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> chosen;
  for (std::int64_t i = 0; i < count; ++i) chosen.push_back(order[i].second);
  std::sort(chosen.begin(), chosen.end());
  std::vector<Cell> some;
  for (const std::size_t i : chosen) some.push_back(cells[i]);
  return some;
}

/// Existing cells as those that packing starts from, numbered.
std::vector<Cell> initialCells(const std::vector<PresentCell>& present) {
  std::vector<Cell> cells;
  for (const PresentCell& cell : present)
    cells.push_back({std::int64_t(cells.size()), cell.species, poseOf(cell), {}, Scene::shapeOf(cell)});
  return cells;
}

/// Initial poses that coincide: all but the first are displaced slightly, because there is no direction in
/// which coinciding cells could be separated.
std::vector<Cell> startOf(const Scene& scene, int s) {
  constexpr double little = 1e-3;  // [µm]; any length that exceeds rounding errors suffices
  std::vector<Cell> cells = initialCells(scene.species[s].start);
  std::set<std::array<double, 3>> taken;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    Vec3& at = cells[i].pose.position;
    if (taken.insert({at.x(), at.y(), at.z()}).second) continue;
    const auto random = uniform4(scene.request.seed, RandomStream::draw, i, std::uint32_t(s));
    at += little * (Vec3(random[0], random[1], random[2]) - Vec3::Constant(0.5));
  }
  return cells;
}

/// `total` cells distributed in proportion to the weights, the largest remainders first.
std::vector<std::int64_t> sharedOut(std::int64_t total, const std::vector<double>& weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::vector<std::int64_t> counts;
  std::vector<std::pair<double, std::size_t>> remainders;
  std::int64_t left = total;
  for (std::size_t r = 0; r < weights.size(); ++r) {
    const double exact = sum > 0.0 ? double(total) * weights[r] / sum : 0.0;
    counts.push_back(std::int64_t(exact));
    remainders.emplace_back(double(counts[r]) - exact, r);
    left -= counts[r];
  }
  std::sort(remainders.begin(), remainders.end());
  for (std::size_t k = 0; left > 0; --left, ++k) ++counts[remainders[k % remainders.size()].second];
  return counts;
}

/// `total` cells distributed in proportion to the weights, of which `there` exist already.
/// @return the others
std::vector<std::int64_t> sharedOutBesides(std::int64_t total, std::vector<double> weights,
                                           const std::vector<std::int64_t>& there) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  std::int64_t others = total;
  for (std::size_t r = 0; r < weights.size(); ++r) {
    weights[r] = std::max(0.0, (sum > 0.0 ? double(total) * weights[r] / sum : 0.0) - double(there[r]));
    others -= there[r];
  }
  return sharedOut(std::max<std::int64_t>(0, others), weights);
}

std::vector<std::int64_t> countFixed(const CellSpecies& species, const std::vector<LumenRegion>& regions) {
  std::vector<std::int64_t> fixed(regions.size(), 0);
  for (const PosLine& line : species.fixed) ++fixed[regionAt(regions, line.position)];
  return fixed;
}

/// Poses of cells of a species with their centres in the shells of the profile, spread evenly over each: the
/// first points of one quasirandom sequence over the lumen that lie in it, with random orientations. Fewer
/// than asked for where hardly a point is in a shell. Every rank computes all of them.
/// @param counts for each shell
std::vector<std::vector<Pose>> startInShells(const Scene& scene, const DepthProfile& profile, int species,
                                             const std::vector<std::int64_t>& counts) {
  const CellSpecies& cells = scene.species[species];
  const std::uint32_t purpose = ownPurpose + std::uint32_t(species);
  const double room = cells.shape->halfThickness();  // between centre and walls, at least [µm]
  const double least = profile.species[species].freeLayer + room;
  const double reach = 2.0 * jitter * std::cbrt(cells.shape->volume());
  Box bounds = scene.lumen.container->bounds();
  const Vec3 period = scene.lumen.container->period();
  for (int k = 0; k < 3; ++k)
    if (period[k] == 0.0) bounds.lo[k] += room, bounds.hi[k] -= room;
  const auto begin = uniform4(scene.request.seed, RandomStream::begin, 0, purpose);
  std::int64_t missing = std::accumulate(counts.begin(), counts.end(), std::int64_t(0));
  const std::int64_t most = std::max(fewestTries, triesOfCell * missing);
  std::vector<std::vector<Pose>> start(counts.size());
  for (std::int64_t n = 0; n < most && missing > 0; ++n) {
    pollAt(std::size_t(n));
    Vec3 p = bounds.lo + bounds.size().cwiseProduct(evenPoint(begin, std::uint64_t(n)));
    const auto u = uniform4(scene.request.seed, RandomStream::position, std::uint64_t(n), purpose);
    p += reach * (Vec3(u[0], u[1], u[2]) - Vec3::Constant(0.5));
    const double depth = (*profile.depth)(p).distance;
    if (depth < least) continue;
    const int shell = profile.shellAt(depth);
    if (std::int64_t(start[shell].size()) >= counts[shell]) continue;
    Pose& pose = start[shell].emplace_back();
    pose.position = p.cwiseMax(bounds.lo).cwiseMin(bounds.hi);
    --missing;
    if (!scene.request.rotate) continue;
    const auto v = uniform4(scene.request.seed, RandomStream::orientation, std::uint64_t(n), purpose);
    pose.orientation = randomOrientation(cells.cone, v[0], v[1], v[2]);
  }
  return start;
}

class PartsMaker {
 public:
  PartsMaker(const Scene& scene, const Layout& layout, const PartsToPack& packed)
      : scene_(scene),
        profile_(layout.profile.get()),
        packed_(packed),
        regions_(layout.regions),
        dividesRedCells_(layout.dividesRedCells()) {}

  std::vector<Part> operator()() {
    if (dividesRedCells_) shareOutRedCells();
    for (std::size_t s = 0; s < scene_.species.size(); ++s) divide(int(s));
    return std::move(parts_);
  }

 private:
  void divide(int s) {
    const CellSpecies& species = scene_.species[s];
    const auto fixed = std::int64_t(species.fixed.size()), ofLumen = species.count - species.ofRegions;
    if (fixed > ofLumen)
      throw InputError(fmt::format("{}: contains {} fixed cells, but only {} '{}' are requested",
                                   species.fixedFrom, fixed, ofLumen, species.name));
    if (fixed > 0) {
      Part part{s, -1, freeCells(scene_, packed_, s, fixed)};
      part.cells.name += ", fixed";
      part.cells.freedom.fixed = true;
      part.cells.freedom.cone.reset();
      add(part, initialCells(species.fixed));
    }
    if (profile_ && profile_->species[s].isAsked())
      freeInShells(s);
    else if (dividesRedCells_ && species.redCell)
      return freeInRegions(s);
    else
      free(s, -1, ofLumen - fixed, withBlood(s, ofLumen - fixed, startOf(scene_, s)));
    for (std::size_t r = 0; r < regions_.size(); ++r)
      free(s, int(r), regions_[r].ofSpecies(species.name), {});
  }

  /// With flowing blood, the starts of all cells: further ones are those of the blood that meet others, or
  /// else like those there.
  std::vector<Cell> withBlood(int s, std::int64_t count, std::vector<Cell> start) const {
    if (scene_.species[s].blood.cells == 0) return start;
    const auto missing = [&] { return std::max<std::int64_t>(0, count - std::int64_t(start.size())); };
    for (const Cell& cell : drawn(initialCells(scene_.species[s].blood.crowded), missing(),
                                  scene_.request.seed, std::uint64_t(s)))
      start.push_back(cell);
    for (const Cell& cell : addLike(start, missing(), scene_, std::uint32_t(s))) start.push_back(cell);
    return start;
  }

  void freeInRegions(int s) {
    const CellSpecies& species = scene_.species[s];
    const std::size_t regions = regions_.size();
    std::vector<std::vector<Cell>> start(regions);
    for (const Cell& cell : startOf(scene_, s)) start[regionAt(regions_, cell.pose.position)].push_back(cell);
    for (std::size_t r = 0; r < regions; ++r) {
      if (toPlace_[s][r] < 0)
        throw InputError(fmt::format("{}: more of its cells are in {} than the hematocrit there allows",
                                     species.fixedFrom, regions_[r].name));
      free(s, int(r), toPlace_[s][r], std::move(start[r]));
    }
  }

  void freeInShells(int s) {
    const CellSpecies& species = scene_.species[s];
    const DepthProfile& profile = *profile_;
    const SpeciesProfile& planned = profile.species[s];
    const auto shellOf = [&](const Vec3& p) { return profile.shellAt((*profile.depth)(p).distance); };
    std::vector<std::int64_t> fixed(profile.shells(), 0);
    for (const PosLine& line : species.fixed) ++fixed[shellOf(line.position)];
    std::vector<std::vector<Cell>> start(profile.shells());
    for (const Cell& cell : startOf(scene_, s)) start[shellOf(cell.pose.position)].push_back(cell);
    const std::vector<std::int64_t> counts = sharedOutBesides(species.count, planned.weight, fixed);
    std::vector<std::int64_t> others = counts;
    for (int j = 0; j < profile.shells(); ++j)
      others[j] = std::max<std::int64_t>(0, counts[j] - std::int64_t(start[j].size()));
    const std::vector<std::vector<Pose>> placed = startInShells(scene_, profile, s, others);
    for (int j = 0; j < profile.shells(); ++j) {
      if (counts[j] == 0) continue;
      constexpr double endless = std::numeric_limits<double>::infinity();
      const double overlap = overlapOfShells * (profile.edges[1] - profile.edges[0]);
      const double from = j == 0 ? -endless : profile.edges[j] - overlap,
                   to = j + 1 == profile.shells() ? endless : profile.edges[j + 1] + overlap;
      Part part{s, j, freeCells(scene_, packed_, s, counts[j])};
      part.cells.name += fmt::format(", {:.3g} to {:.3g} µm deep", profile.edges[j], profile.edges[j + 1]);
      part.cells.freedom.region = std::make_shared<DepthShell>(profile.depth, from, to);
      if (planned.freeLayer > 0.0)
        part.cells.freedom.freeLayer = FreeLayer{profile.depth->wall(), planned.freeLayer};
      for (const Pose& pose : placed[j])
        start[j].push_back({0, s, pose, {}, furtherShape(s, std::int64_t(start[j].size()))});
      addFree(std::move(part), std::move(start[j]));
    }
  }

  /// Distributes the red cells over the regions: those with a count or a ratio in proportion to the requested
  /// hematocrits, then those determined by the hematocrit, so that the total of each region matches. The last
  /// of them make the numbers of regions exact.
  void shareOutRedCells() {
    std::vector<int> order;
    for (const bool byHematocrit : {false, true})
      for (std::size_t s = 0; s < scene_.species.size(); ++s) {
        const CellSpecies& species = scene_.species[s];
        if (species.redCell && byHematocrit == isByHematocrit(species)) order.push_back(int(s));
      }
    if (order.empty()) return;
    const std::vector<double> asked = volumesOfRedCells(order);
    std::vector<double> left =
        asked;  // remaining volume of each region's red cells, over the reference volume
    const std::vector<std::optional<std::int64_t>> numbers = numbersOfRedCells(left);
    std::vector<std::optional<std::int64_t>> open = numbers;  // still to be placed
    toPlace_.resize(scene_.species.size());
    for (const int s : order) {
      const CellSpecies& species = scene_.species[s];
      const std::vector<std::int64_t> fixed = countFixed(species, regions_);
      const std::vector<double>& weights = isByHematocrit(species) ? left : asked;
      toPlace_[s] = shareOut(species, weights, fixed, open, s == order.back());
      for (std::size_t r = 0; r < left.size(); ++r) {
        left[r] = std::max(0.0, left[r] - volumeOf(species) * double(toPlace_[s][r] + fixed[r]));
        if (open[r]) *open[r] -= toPlace_[s][r];
        toPlace_[s][r] += regions_[r].ofSpecies(species.name);
      }
    }
  }

  static bool isByHematocrit(const CellSpecies& species) { return !species.statedCount && !species.ratio; }
  double volumeOf(const CellSpecies& species) const {
    return species.countedVolume / scene_.referenceVolume();
  }

  /// The volume of red cells that is asked for in each region, over the reference volume. Without a
  /// hematocrit the regions without a number have equal ones.
  std::vector<double> volumesOfRedCells(const std::vector<int>& red) const {
    const double cell = volumeOf(scene_.species[red.back()]);
    double all = 0.0, numbered = 0.0, share = 0.0;
    for (const int s : red)
      all += double(scene_.species[s].count - scene_.species[s].ofRegions) * volumeOf(scene_.species[s]);
    for (const LumenRegion& region : regions_)
      (region.count ? numbered : share) += region.count ? double(*region.count) * cell : region.share;
    std::vector<double> volumes;
    for (const LumenRegion& region : regions_)
      volumes.push_back(region.count        ? double(*region.count) * cell
                        : region.hematocrit ? region.share * *region.hematocrit
                        : share > 0.0       ? region.share * std::max(0.0, all - numbered) / share
                                            : 0.0);
    return volumes;
  }

  /// Red cells that are yet to be placed in the regions that have a number of them: without fixed ones and
  /// cells of their own, which are also taken from the volumes of regions with a hematocrit of their own.
  std::vector<std::optional<std::int64_t>> numbersOfRedCells(std::vector<double>& volumes) const {
    std::vector<std::optional<std::int64_t>> numbers;
    for (std::size_t r = 0; r < regions_.size(); ++r) {
      const LumenRegion& region = regions_[r];
      std::optional<std::int64_t>& number = numbers.emplace_back(region.count);
      double own = 0.0;
      for (const CellSpecies& species : scene_.species) {
        if (!species.redCell) continue;
        const std::int64_t cells = region.ofSpecies(species.name);
        own += double(cells) * volumeOf(species);
        if (number) *number -= cells + countFixed(species, regions_)[r];
      }
      if (!region.own) continue;
      if (number && *number < 0)
        throw InputError(fmt::format("{}: the fixed red cells in it are more than its count allows",
                                     scene_.request.regions[r].body.where));
      volumes[r] = std::max(0.0, volumes[r] - own);
    }
    return numbers;
  }

  /// The movable cells of a species of the lumen in each region.
  /// @param open of regions with a number of red cells: those yet to be placed @param last all of them
  std::vector<std::int64_t> shareOut(const CellSpecies& species, std::vector<double> weights,
                                     std::vector<std::int64_t> fixed,
                                     const std::vector<std::optional<std::int64_t>>& open, bool last) const {
    std::int64_t total = species.count - species.ofRegions;
    const auto shared = [&] {
      if (!isByHematocrit(species)) return sharedOutBesides(total, weights, fixed);
      std::vector<std::int64_t> cells = sharedOut(total, weights);
      for (std::size_t r = 0; r < cells.size(); ++r) cells[r] -= fixed[r];
      return cells;
    };
    const std::vector<std::int64_t> even = shared();
    std::vector<std::int64_t> cells = even;
    bool anyNumber = false;
    for (std::size_t r = 0; r < cells.size(); ++r) {
      if (!open[r]) continue;
      anyNumber = true;
      cells[r] = last ? *open[r] : std::min(even[r], *open[r]);
      total -= cells[r] + fixed[r];
      weights[r] = 0.0;
      fixed[r] = 0;
    }
    if (!anyNumber) return cells;
    const std::int64_t allFixed = std::accumulate(fixed.begin(), fixed.end(), std::int64_t(0));
    const double others = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (total < allFixed || (total > allFixed && !(others > 0.0)))
      throw InputError(fmt::format(
          "the counts of the regions take {} red cells than there are: {} '{}' are requested for the lumen",
          total < allFixed ? "more" : "fewer", species.count - species.ofRegions, species.name));
    const std::vector<std::int64_t> rest = shared();
    for (std::size_t r = 0; r < cells.size(); ++r)
      if (!open[r]) cells[r] = rest[r];
    return cells;
  }

  /// A part with cells that can move.
  void free(int s, int region, std::int64_t count, std::vector<Cell> start) {
    if (count == 0 && region >= 0) return;
    Part part{s, region, freeCells(scene_, packed_, s, count)};
    if (region >= 0) {
      part.cells.name +=
          region + 1 < int(regions_.size()) ? fmt::format(", region {}", region + 1) : ", rest";
      part.cells.freedom.region = regions_[region].region;
    }
    addFree(std::move(part), std::move(start));
  }

  void addFree(Part part, std::vector<Cell> start) {
    start = drawn(std::move(start), part.cells.count, scene_.request.seed, stream_);
    if (const auto& cone = part.cells.freedom.cone; scene_.request.rotate && cone)
      for (Cell& cell : start) cell.pose.orientation = cone->nearest(cell.pose.orientation);
    add(std::move(part), start);
  }

  /// The shape of a further cell of a species: that of a random one of the blood, if there is blood.
  int furtherShape(int s, std::int64_t n) const {
    const std::vector<int>& shapes = scene_.species[s].blood.shapes;
    if (shapes.empty()) return s;
    const double u = uniform4(scene_.request.seed, RandomStream::draw, n, stream_)[1];
    return shapes[std::size_t(u * double(shapes.size()))];
  }

  /// A part with these cells at the start, and with further ones. Deformed cells are in the order of their
  /// shapes.
  void add(Part part, const std::vector<Cell>& start) {
    Species& cells = part.cells;
    for (const Cell& cell : start) {
      if (cell.shape == part.species)
        cells.start.push_back(cell.pose);
      else
        cells.deformed.push_back({cell.shape, cell.pose});
    }
    const std::int64_t further = cells.count - std::int64_t(start.size());
    for (std::int64_t n = 0; n < further; ++n)
      if (const int shape = furtherShape(part.species, n); shape != part.species)
        cells.deformed.push_back({shape, {}});
    std::stable_sort(cells.deformed.begin(), cells.deformed.end(),
                     [](const DeformedCell& a, const DeformedCell& b) { return a.shape < b.shape; });
    stream_ += cells.usesTemplate();
    for (std::size_t i = 0; i < cells.deformed.size(); ++i)
      stream_ += i == 0 || cells.deformed[i].shape != cells.deformed[i - 1].shape;
    parts_.push_back(std::move(part));
  }

  const Scene& scene_;
  const DepthProfile* profile_;  ///< nullptr: none
  const PartsToPack& packed_;    ///< with its walls
  const std::vector<LumenRegion>& regions_;
  bool dividesRedCells_;
  std::vector<Part> parts_;
  std::uint32_t stream_ = 0;  ///< of random numbers: one for each shape of the parts so far
  std::vector<std::vector<std::int64_t>> toPlace_;  ///< movable red cells, by species and region
};

std::shared_ptr<const Region> makeRegion(const SolidRequest& body, const Container& lumen,
                                         const Threads& team, std::vector<std::string>& repairs) {
  const Box bounds = lumen.bounds();
  if (body.kind == SolidRequest::Kind::halfSpace)
    return std::make_shared<HalfSpace>(body.point, body.direction.normalized(), bounds, lumen.period());
  if (body.kind == SolidRequest::Kind::beyond)
    return located(body.where,
                   [&] { return std::make_shared<LumenCut>(lumen, body.point, body.direction, team); });
  return std::make_shared<BodyRegion>(makeSolid(body, {false, false, false}, repairs), bounds,
                                      lumen.period());
}

}  // namespace

std::vector<LumenRegion> makeRegions(const Request& asked, std::optional<double> hematocrit,
                                     const Lumen& lumen, const Threads& team,
                                     std::vector<std::string>& repairs) {
  std::vector<LumenRegion> regions;
  if (asked.regions.empty()) return regions;
  const Box bounds = lumen.container->bounds();
  std::vector<std::shared_ptr<const Region>> earlier;
  double rest = 1.0;
  for (const RegionRequest& request : asked.regions) {
    std::shared_ptr<const Region> body = makeRegion(request.body, *lumen.container, team, repairs);
    const auto region = std::make_shared<RegionDifference>(body, earlier, bounds);
    const double share = volumeInLumen(*region, *lumen.container) / lumen.container->volume();
    if (!(share > 0.0))
      throw InputError(
          fmt::format("{}: this region lies outside the lumen or in earlier ones", request.body.where));
    LumenRegion& made = regions.emplace_back();
    made = {fmt::format("region {}", regions.size()),
            region,
            share,
            request.hematocrit,
            request.count,
            request.statesRedCells(),
            request.species};
    if (!made.own) made.hematocrit = hematocrit;
    rest = std::max(0.0, rest - share);
    earlier.push_back(std::move(body));
  }
  regions.push_back({"the rest",
                     std::make_shared<RegionDifference>(nullptr, earlier, bounds),
                     rest,
                     hematocrit,
                     {},
                     false,
                     {}});
  return regions;
}

int regionAt(const std::vector<LumenRegion>& regions, const Vec3& point) {
  for (std::size_t r = 0; r + 1 < regions.size(); ++r)
    if (regions[r].region->contains(point)) return int(r);
  return int(regions.size()) - 1;
}

Species freeCells(const Scene& scene, const PartsToPack& packed, int species, std::int64_t count) {
  const CellSpecies& one = scene.species[species];
  Species cells{one.name, species, count, packed.walls[species], one.redCell};
  cells.freedom.cone = one.cone;
  cells.freedom.extraWallClearance = one.extraWallClearance(packed.clearances.wall);
  return cells;
}

PartsToPack partsAt(const Scene& scene, const Layout& layout, const Clearances& clearances) {
  PartsToPack packed;
  packed.clearances = clearances;
  double reach = 0.0;
  for (const auto& shape : scene.shapes) reach = std::max(reach, 2 * shape->radius());
  std::map<std::pair<int, double>, std::shared_ptr<const Wall>>
      walls;  // by distance from solid and clearance
  for (const CellSpecies& species : scene.species) {
    packed.walls.emplace_back();
    if (species.mostCells() == 0) continue;
    const int distance = species.minimumDistanceFromSolid;
    const double clearance = species.wallClearance(clearances.wall);
    auto [wall, isNew] = walls.try_emplace({distance, clearance});
    // Relaxation aims at the clearance plus a margin and stops within its tolerance of that; for the voxel
    // faces it then suffices that no vertex is beyond them.
    constexpr double margin = tolerance::relaxationMargin - tolerance::relaxationTolerance;
    if (isNew) wall->second = speciesWall(scene.lumen, distance, reach, clearance + margin);
    packed.walls.back() =
        wallAtAllSpacings(wall->second, species, scene.lumen, scene.request.dx, clearance + margin);
  }
  packed.parts = PartsMaker(scene, layout, packed)();
  return packed;
}

std::vector<std::string> examineRegions(const Scene& scene, const Layout& layout,
                                        const std::vector<Part>& parts) {
  std::vector<std::string> warnings;
  for (std::size_t r = 0; r < layout.regions.size(); ++r) {
    const LumenRegion& region = layout.regions[r];
    const bool listed = r < scene.request.regions.size();
    if (!region.hematocrit || !layout.dividesRedCells() || (listed && !region.own)) continue;
    double volume = 0.0;
    std::int64_t cells = 0;
    for (const Part& part : parts) {
      const CellSpecies& species = scene.species[part.species];
      if (!species.redCell) continue;
      std::int64_t here = part.region == int(r) ? part.cells.count : 0;
      if (part.cells.freedom.fixed)
        part.cells.forEachStart(
            [&](int, const Pose& pose) { here += regionAt(layout.regions, pose.position) == int(r); });
      cells += here;
      volume += double(here) * species.countedVolume;
    }
    const double size = region.share * scene.referenceVolume(), asked = *region.hematocrit * size;
    if (cells == 0 && asked > 0.0) {
      const std::string what = fmt::format(
          "a hematocrit of {:.15g} in {:.4g} µm³ is too little for a red cell", *region.hematocrit, size);
      if (listed)
        throw InputError(fmt::format("{}: {}; enlarge the region or remove it",
                                     scene.request.regions[r].body.where, what));
      warnings.push_back(fmt::format("outside the regions there will be no red cell: {}", what));
    } else if (std::abs(volume - asked) > noticeable * asked) {
      warnings.push_back(
          fmt::format("{} is so small that whole cells cannot meet its hematocrit: {:.4f} with {} "
                      "red cell{}, {:.15g} requested",
                      region.name, volume / size, cells, cells == 1 ? "" : "s", *region.hematocrit));
    }
  }
  return warnings;
}

}  // namespace packmesh::hemocell
