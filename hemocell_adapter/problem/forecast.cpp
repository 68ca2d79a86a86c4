// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <utility>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/parts.h"
#include "packMesh/core/box.h"
#include "packMesh/core/random.h"
#include "packMesh/packing/pack.h"
#include "packMesh/placement/placement.h"

namespace packmesh::hemocell {
namespace {

/// Packings are less dense along walls, as if a layer of this thickness were empty [µm]: at a smooth wall,
/// and at the faces of the nodes that HemoCell excludes, between which membranes can protrude.
constexpr double emptyLayer = 0.55, emptyLayerAtNodes = 0.40;

/// Number of points at which the distance to walls is sampled, exactly where it is less [spacings of the
/// samples]: far from walls it takes long, and is only compared.
constexpr int points = 16000;
constexpr double exactWithin = 2.5;

/// Where cells can be is larger than the volume of a vessel by the continuation of its ends; smaller
/// differences are those of the sample.
constexpr double leastContinuation = 1.02;

/// Maximum number of points from which a cell is tried.
constexpr std::size_t trials = 8;

/// Smaller parts of a space are those of its resolution.
constexpr double leastPart = 0.002;

/// Narrower places are not worth telling [µm]: blood has no smaller vessels.
constexpr double leastWidth = 2.0;

/// Whether points are near the parts of a space, by boxes around successive ones, and around those.
class Nearness {
 public:
  using Part = AccessibleSpace::Part;

  /// References `parts`, which must outlive it.
  Nearness(const std::vector<Part>& parts, double reach) : parts_(parts), squaredReach_(reach * reach) {
    for (std::size_t count = parts.size(); count > 1; count = around_.back().size()) {
      std::vector<Box> boxes((count + together - 1) / together);
      for (std::size_t i = 0; i < count; ++i)
        boxes[i / together].add(around_.empty() ? boxOf(parts[i]) : around_.back()[i]);
      around_.push_back(std::move(boxes));
    }
  }
  bool operator()(const Vec3& p) const { return !parts_.empty() && isNear(p, around_.size(), 0); }

 private:
  static constexpr std::size_t together = 8;

  static Box boxOf(const Part& part) {
    const Vec3 half = part.half.cast<double>();
    return {part.centre - half, part.centre + half};
  }

  /// @param height 0: a part, else one of around_[height - 1]
  bool isNear(const Vec3& p, std::size_t height, std::size_t index) const {
    const Box box = height == 0 ? boxOf(parts_[index]) : around_[height - 1][index];
    if (box.squaredDistance(p) > squaredReach_) return false;
    if (height == 0) return true;
    const std::size_t below = height == 1 ? parts_.size() : around_[height - 2].size();
    for (std::size_t i = together * index; i < std::min(below, together * (index + 1)); ++i)
      if (isNear(p, height - 1, i)) return true;
    return false;
  }

  const std::vector<Part>& parts_;
  double squaredReach_;                   ///< [µm²]
  std::vector<std::vector<Box>> around_;  ///< around parts, around those boxes, ...
};

}  // namespace

void LumenSample::draw() {
  const Container& container = *problem_.lumen.container;
  wall_ = container.wall();
  volume_ = container.volume();
  if (!wall_) return;
  if (wall_->closedForm())
    drawFromBounds(container.bounds());
  else
    drawFrom(AccessibleSpace(container, problem_.team, AccessibleSpace::Points::covered));
}

void LumenSample::drawFromBounds(const Box& bounds) {
  for (std::uint64_t i = 0; i < std::uint64_t(points); ++i) {
    const Vec3 p = bounds.lo + bounds.size().cwiseProduct(evenPoint({0.5, 0.5, 0.5, 0.5}, i + 1));
    const double distance = wall_->distance(p).distance;
    if (distance < 0.0) continue;
    inside_.push_back(p);
    distances_.push_back(distance);
  }
}

void LumenSample::drawFrom(const AccessibleSpace& cover) {
  if (cover.volume() == 0.0) return;
  const Container& container = *problem_.lumen.container;
  const SampledDistance& sampled = wall_->coarselySampled(container.surroundings(0.0));
  std::vector<Vec3> tried(points);
  std::vector<double> distances(points);
  problem_.team.forEachPart(points, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Vec3 within = evenPoint({0.5, 0.5, 0.5, 0.5}, std::uint64_t(i) + 1);
      tried[i] = cover
                     .pose(evenShare(0.5, std::uint64_t(i)), {within[0], within[1], within[2], 0.0},
                           Quaternion::Identity())
                     .position;
      distances[i] = sampled.sample(tried[i]).distance;
      if (std::abs(distances[i]) < exactWithin * sampled.spacing())
        distances[i] = wall_->distance(tried[i]).distance;
    }
  });
  for (int i = 0; i < points; ++i) {
    if (distances[i] < 0.0) continue;
    inside_.push_back(tried[i]);
    distances_.push_back(distances[i]);
  }
  interpolationError_ = sampled.spacing();
  const double found = double(inside_.size()) / points * cover.volume();
  if (found > leastContinuation * volume_) volume_ = found;
}

const Room& LumenSample::room(int species) {
  if (volume_ == 0.0) draw();
  const auto [found, isNew] = rooms_.try_emplace(species);
  if (isNew) found->second = measured(species);
  return found->second;
}

const std::vector<double>& LumenSample::apart(int species) {
  room(species);
  const auto [found, isNew] = apart_.try_emplace(species);
  if (const auto& space = spaces_[species]; isNew && space && space->complete())
    for (const double share : space->apart())
      if (share >= leastPart) found->second.push_back(share);
  spaces_.erase(species);
  return found->second;
}

double LumenSample::width() {
  if (volume_ == 0.0) draw();
  double width = std::numeric_limits<double>::infinity();
  if (wall_) width = distances_.empty() ? 0.0 : 2.0 * *std::max_element(distances_.begin(), distances_.end());
  for (int k = 0; k < 3; ++k)
    if (const double period = problem_.lumen.container->period()[k]; period > 0.0)
      width = std::min(width, period);
  return width;
}

Room LumenSample::measured(int s) {
  Room room;
  room.volume = room.effective = volume_;
  if (!wall_) return room;
  const PartsToPack& packed = problem_.atDemanded;
  const double clearance = problem_.species[s].wallClearance(packed.clearances.wall);
  const Wall* const nodes = packed.walls[s].get();
  const Shape& shape = *problem_.species[s].shape;
  std::function<bool(const Vec3&)> reaches;
  if (!wall_->closedForm() || (nodes && !nodes->closedForm())) {
    Physics physics;
    physics.species = {freeCells(problem_, packed, s, 1)};
    physics.shapes = problem_.shapes;
    physics.container = problem_.lumen.container;
    physics.wallClearance = packed.clearances.wall;
    physics.rotate = problem_.request.rotate;
    const auto& space = spaces_[s] = std::make_unique<const AccessibleSpace>(physics, 0, problem_.team);
    if (space->complete()) {
      const auto near = std::make_shared<Nearness>(space->parts(), shape.radius());
      reaches = [near](const Vec3& p) { return (*near)(p); };
    }
  }
  std::vector<std::pair<double, std::size_t>> depths;
  std::size_t bodies = 0, effective = 0;
  for (std::size_t i = 0; i < inside_.size(); ++i) {
    const double smooth = distances_[i] - clearance;
    const double depth = nodes ? nodes->distance(inside_[i]).distance - clearance : smooth;
    depths.emplace_back(depth, i);
    if (depth < 0.0) continue;
    if (reaches && !reaches(inside_[i])) {
      const double widest = room.narrow ? room.narrow->width : leastWidth;
      if (2.0 * (distances_[i] + interpolationError_) < widest) continue;
      const double width = 2.0 * wall_->distance(inside_[i]).distance;
      if (width >= widest) room.narrow = {inside_[i], width};
      continue;
    }
    ++bodies;
    effective += depth >= (nodes ? emptyLayerAtNodes : emptyLayer) && smooth >= emptyLayer;
  }
  const double all = std::max<double>(1.0, double(inside_.size()));
  room.share = double(bodies) / all;
  room.volume = room.share * volume_;
  room.effective = double(effective) / all * volume_;
  const std::size_t some = std::min(trials, depths.size());
  std::partial_sort(depths.begin(), depths.begin() + std::ptrdiff_t(some), depths.end(), std::greater<>());
  for (std::size_t k = 0; k < some; ++k) room.deepest.push_back(inside_[depths[k].second]);
  return room;
}

namespace {

/// Time per red cell in a periodic box of 50 µm [ms], by volume fraction: one core at 2.5 GHz, AVX-512. (From
/// 0.60 on 2.5 times the value measured on an EPYC that is 2.5 times as fast.)
struct Measured {
  double fraction, milliseconds;
};
constexpr Measured measured[] = {{0.10, 0.02},  {0.20, 0.025}, {0.30, 0.037}, {0.35, 0.047},
                                 {0.45, 0.085}, {0.50, 0.14},  {0.55, 0.28},  {0.58, 0.75},
                                 {0.60, 3.4},   {0.61, 26.0},  {0.62, 98.0}};

/// Per factor of ten in the number of cells beyond a thousand: larger packings take more sweeps.
constexpr double increasePerDecade = 0.15;

/// Memory [MB]: of the program, of undeformed cells, and of deformed ones with as many vertices as red cells.
constexpr double ofProgram = 25.0, ofThousandCells = 1.3, ofThousandDeformed = 140.0;

/// CPU time of a deformed cell [s] (docs/explanation/soft.md): in wide lumens and in capillaries.
constexpr double leastOfDeformed = 0.01, mostOfDeformed = 0.1;

constexpr double redCellVertices = 642.0;

/// Lumens less wide than this many lengths of a cell are narrow: tubes of red cells up to 10 µm, where
/// densest packings have effective fractions from 0.53 to 0.90; in wider ones 0.60 to 0.67.
constexpr double narrowly = 1.3;

/// Parallel efficiency of several ranks or threads.
constexpr double efficiency = 0.85;

double millisecondsAt(double fraction) {
  const Measured* upper = std::find_if(std::begin(measured), std::end(measured) - 1,
                                       [&](const Measured& m) { return m.fraction >= fraction; });
  if (upper == std::begin(measured)) return upper->milliseconds;
  const Measured* lower = upper - 1;
  const double t = (fraction - lower->fraction) / (upper->fraction - lower->fraction);
  return lower->milliseconds * std::pow(upper->milliseconds / lower->milliseconds, t);
}

/// Whether a single cell of the species can be moved into the lumen, from the points furthest from the wall,
/// and between its own images in a periodic box that is thinner than the cell.
bool findsPlace(const Problem& problem, int s, const Room& room) {
  constexpr std::int64_t sweeps = 300;
  const CellSpecies& species = problem.species[s];
  const Container& lumen = *problem.lumen.container;
  std::vector<Vec3> starts = room.deepest;
  if (!lumen.wall() && lumen.period().minCoeff() < 2.0 * species.shape->radius())
    starts.assign(trials, lumen.bounds().center());
  PackingProblem packing;
  packing.physics.species.push_back(freeCells(problem, problem.atDemanded, s, 1));
  packing.physics.species.front().start = {Pose()};
  packing.physics.shapes = problem.shapes;
  packing.physics.container = problem.lumen.container;
  packing.physics.wallClearance = problem.atDemanded.clearances.wall;
  packing.physics.rotate = problem.request.rotate;
  packing.execution.limits.maxSweeps = sweeps;
  packing.execution.limits.fewerCells = false;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    Pose& start = packing.physics.species.front().start.front();
    start.position = starts[i];
    const auto u = uniform4(1, RandomStream::orientation, i, 0);
    if (problem.request.rotate) start.orientation = uniformRotation(u[0], u[1], u[2]);
    if (species.cone) start.orientation = species.cone->nearest(start.orientation);
    if (pack(packing).outcome == Outcome::certified) return true;
  }
  return starts.empty();
}

/// An estimate, with a suitable number of digits.
std::string about(double seconds) {
  if (seconds < 1.0) return "less than a second";
  const double unit = std::pow(10.0, std::floor(std::log10(seconds)) - 1.0);
  return "about " + durationText(std::round(seconds / unit) * unit);
}

/// An estimate between two numbers [s].
std::string range(double least, double most) {
  if (most < 1.0) return "less than a second";
  return (least < 1.0 ? "up to " : durationText(std::round(least)) + " to ") + durationText(std::round(most));
}

/// Of each rank, as given: the machine of a dry run may have fewer cores.
int threadsOf(const Problem& problem) {
  return int(problem.request.threads.value_or(problem.team.count()));
}

/// By how much several ranks or threads are faster than one core.
double speedup(const Problem& problem, int ranks) {
  const int cores = ranks * threadsOf(problem);
  return cores > 1 ? efficiency * cores : 1.0;
}

/// ", about 3 s on 4 ranks with 2 threads each"; empty on one core. @param time there
std::string wallText(const Problem& problem, int ranks, const std::string& time) {
  const int threads = threadsOf(problem);
  if (ranks * threads == 1) return {};
  if (ranks == 1) return fmt::format(", {} on {} threads", time, threads);
  return fmt::format(", {} on {} ranks", time, ranks) +
         (threads > 1 ? fmt::format(" with {} threads each", threads) : "");
}

std::string memoryText(double megabytes) {
  return megabytes < 1000.0 ? fmt::format("about {:.0f} MB", megabytes)
                            : fmt::format("about {:.3g} GB", 1e-3 * megabytes);
}

/// Constraints whose effect on packing is unknown.
std::string leftOut(const Problem& problem) {
  std::int64_t fixed = 0;
  bool cones = !problem.request.rotate;
  for (const CellSpecies& species : problem.species) {
    fixed += std::int64_t(species.fixed.size());
    cones = cones || species.cone;
  }
  std::vector<std::string> reasons;
  if (fixed > 0) reasons.push_back(fmt::format("{} fixed cell{}", fixed, fixed == 1 ? "" : "s"));
  if (cones) reasons.push_back("constrained orientations");
  if (!problem.request.regions.empty()) reasons.push_back("regions denser than the mean");
  return fmt::format("{}", fmt::join(reasons, ", "));
}

/// How much of the lumen these species can reach, where that is much less than all of it. The volumes and the
/// hematocrit are those of the lumen without the continuation of its ends.
std::vector<std::string> speciesLines(const Problem& problem, LumenSample& sample, bool redCellsAlone) {
  constexpr double worthTelling = 0.95;
  const double lumen = problem.lumen.container->volume();
  std::vector<std::string> lines;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& species = problem.species[s];
    if (species.count == 0 || (redCellsAlone && !species.redCell)) continue;
    const Room& room = sample.room(int(s));
    if (room.share < worthTelling) {
      std::string line = fmt::format("{} can reach {:.1f} % of the lumen ({:.0f} of {:.0f} µm³)",
                                     species.name, 100.0 * room.share, room.share * lumen, lumen);
      if (species.redCell && room.share > 0.0)
        line += fmt::format(", where their hematocrit is {:.3f}",
                            double(species.count) * species.meanVolume / (room.share * lumen));
      line += "; gaps to the wall, HemoCell's rules and narrow places exclude the rest";
      if (room.narrow)
        line += fmt::format(
            ". The widest place that they cannot enter is {:.1f} µm wide, near ({:.1f}, {:.1f}, {:.1f}) µm",
            room.narrow->width, room.narrow->at.x(), room.narrow->at.y(), room.narrow->at.z());
      lines.push_back(line);
    }
    if (const std::vector<double>& apart = sample.apart(int(s)); apart.size() > 1)
      lines.push_back(fmt::format(
          "{}: the places that they can reach are {} parts, not connected, the largest with {:.3f} of them",
          species.name, apart.size(), apart.front()));
  }
  return lines;
}

/// How much of the lumen all cells fill, and in how much of it they can be if that is less.
std::vector<std::string> roomLines(const Problem& problem, const Forecast& forecast, LumenSample& sample) {
  std::string cells = fmt::format("{} cell{} with {:.4f} of the lumen's volume", forecast.cells,
                                  forecast.cells == 1 ? "" : "s", forecast.fraction);
  if (forecast.effectiveFraction < 1.0)
    cells += fmt::format(", effective fraction {:.3f}", forecast.effectiveFraction);
  std::vector<std::string> lines = speciesLines(problem, sample, false);
  lines.insert(lines.begin(), cells);
  return lines;
}

/// Why the cells cannot be packed by any method; nothing if this is not known.
std::optional<std::string> impossible(const Problem& problem, const Forecast& forecast, LumenSample& sample) {
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& species = problem.species[s];
    const std::int64_t count = species.toPack();
    if (count == 0 || species.count <= std::int64_t(species.fixed.size())) continue;
    const double volume = double(count) * species.shape->volume();
    if (volume > forecast.roomVolumes[s])
      return fmt::format("{} {} have {:.4g} µm³, more than the available volume", count, species.name,
                         volume);
    if (!findsPlace(problem, int(s), sample.room(int(s))))
      return fmt::format("not even one {} fits into the lumen", species.name);
  }
  return {};
}

/// @param never why undeformed cells cannot be packed
bool deforms(const Problem& problem, const Forecast& f, const std::optional<std::string>& never) {
  return problem.request.deforms() && (never || f.effectiveFraction > Forecast::easy);
}

/// Of lumens in which the calibration of effective fractions does not hold.
std::string uncertain(const Forecast& f) {
  return fmt::format(
      "Uncertain: effective fraction {:.3f}, in a lumen hardly wider than a cell. Such packings have failed "
      "from {:.2f} on, and have been found up to {:.2f}; " +
          named("max-time") + " and " + named("best-effort") + " limit the effort",
      f.effectiveFraction, Forecast::doubtful, Forecast::ordered);
}

/// Whether the cells can be packed.
std::string verdict(const Problem& problem, const Forecast& f, const std::optional<std::string>& never) {
  if (deforms(problem, f, never))
    return fmt::format("Undeformed cells probably cannot be packed ({}): cells will be soft",
                       never ? *never : fmt::format("effective fraction {:.3f}", f.effectiveFraction));
  if (never) return fmt::format("Infeasible: {}{}", *never, deformedInstead(problem));
  if (f.narrow && f.effectiveFraction > Forecast::doubtful && f.effectiveFraction <= Forecast::ordered)
    return uncertain(f);
  if (f.effectiveFraction <= Forecast::easy)
    return fmt::format("Feasible: effective fraction {:.3f}; slow above {:.2f}", f.effectiveFraction,
                       Forecast::easy);
  const double possible = f.narrow                   ? Forecast::ordered
                          : f.cells <= Forecast::few ? Forecast::possibleForFew
                                                     : Forecast::possible;
  if (f.effectiveFraction <= possible)
    return fmt::format(
        "At the limit: between {:.2f} and {:.2f} packing takes thousands of sweeps, or fails; " +
            named("max-time") + " and " + named("best-effort") + " limit the effort{}",
        Forecast::easy, possible, denserInstead(problem));
  return fmt::format("Probably infeasible: {}, the densest achieved so far; " + named("max-time") + " and " +
                         named("best-effort") + " give the densest packing found{}",
                     f.effectiveFraction < 1.0
                         ? fmt::format("{:.3f} above {:.2f}", f.effectiveFraction - possible, possible)
                         : fmt::format("far above {:.2f}", possible),
                     denserInstead(problem));
}

}  // namespace

Forecast forecastOf(const Problem& problem, LumenSample& sample) {
  Forecast forecast;
  const double lumen = problem.lumen.container->volume();
  double volume = 0.0, toPack = 0.0;
  for (const CellSpecies& species : problem.species) {
    volume += double(species.count) * species.meanVolume;
    toPack += double(species.toPack()) * species.shape->volume();
  }
  const double left = 1.0 - std::max(0.0, volume - toPack) / lumen;  // by cells that have shapes of their own
  for (std::size_t i = 0; i < problem.species.size(); ++i) {
    const CellSpecies& species = problem.species[i];
    forecast.cells += species.count;
    forecast.roomShares.push_back(1.0);
    forecast.roomVolumes.push_back(lumen);
    const double n = double(species.toPack()), own = species.shape->volume();
    if (n == 0.0) continue;
    const Room& room = sample.room(static_cast<int>(i));
    forecast.roomShares.back() = room.share;
    forecast.roomVolumes.back() = room.volume;
    if (n * own >= 0.5 * toPack)
      forecast.narrow = sample.width() < narrowly * boundingBox(species.shape->mesh()).size().maxCoeff();
    const double grown = n * (own + 0.5 * problem.demanded.membranes * surfaceArea(species.shape->mesh()));
    forecast.effectiveFraction +=
        room.effective > 0.0 ? grown / (left * room.effective) : std::numeric_limits<double>::infinity();
  }
  for (int j = 0; problem.layout.profile && j < problem.layout.profile->shells();
       ++j)  // the densest part decides
    forecast.effectiveFraction = std::max(forecast.effectiveFraction, problem.layout.profile->askedIn(j));
  forecast.fraction = volume / lumen;
  forecast.megabytes = ofProgram + 1e-3 * ofThousandCells * double(forecast.cells);
  forecast.deformedMegabytes = forecast.megabytes;
  for (const CellSpecies& species : problem.species)
    if (!species.rigid)
      forecast.deformedMegabytes += 1e-3 * ofThousandDeformed * double(species.count) *
                                    double(species.shape->mesh().vertices.size()) / redCellVertices;
  if (forecast.effectiveFraction > Forecast::possible) return forecast;
  double milliseconds = 0.0;
  for (const CellSpecies& species : problem.species) {
    constexpr double fixedShare = 0.3;
    const double vertices = double(species.shape->mesh().vertices.size()) / redCellVertices;
    milliseconds += double(species.count) * (fixedShare + (1.0 - fixedShare) * std::min(vertices, 3.0)) *
                    millisecondsAt(forecast.effectiveFraction);
  }
  const double decades = std::max(0.0, std::log10(double(forecast.cells) / 1000.0));
  forecast.seconds = 1e-3 * milliseconds * (1.0 + increasePerDecade * decades);
  return forecast;
}

std::string roomText(const Problem& problem, const Forecast& forecast, LumenSample& sample) {
  return fmt::format("The request: {}", fmt::join(roomLines(problem, forecast, sample), ". "));
}

std::vector<std::string> reachLines(const Problem& problem, LumenSample& sample) {
  const Wall* const wall = problem.lumen.container->wall();
  if (!wall || wall->closedForm()) return {};
  const Forecast forecast = forecastOf(problem, sample);
  std::vector<std::string> lines = speciesLines(problem, sample, true);
  lines.push_back(verdict(problem, forecast, impossible(problem, forecast, sample)));
  return lines;
}

ForecastText forecastText(const Problem& problem, int ranks) {
  LumenSample sample(problem);
  const Forecast f = forecastOf(problem, sample);
  std::vector<std::string> lines = roomLines(problem, f, sample);
  if (problem.request.inColumns)
    lines.push_back(
        "In columns: the feasible fraction depends on the box, up to 0.65 at 50 µm, less in small ones. The "
        "figures below are for random packings");
  const std::optional<std::string> never = impossible(problem, f, sample);
  lines.push_back(verdict(problem, f, never));
  const bool soft = deforms(problem, f, never);
  if (soft)
    lines.push_back(fmt::format("Time: {} of CPU{}; soft cells usually take {} to {} s each",
                                range(leastOfDeformed * double(f.cells), mostOfDeformed * double(f.cells)),
                                wallText(problem, ranks,
                                         range(leastOfDeformed * double(f.cells) / speedup(problem, ranks),
                                               mostOfDeformed * double(f.cells) / speedup(problem, ranks))),
                                leastOfDeformed, mostOfDeformed));
  else if (problem.request.method == Method::cat)
    lines.push_back("Time: unknown for " + named("method", "cat") +
                    ", which takes 4 to 50 times as long as the default method");
  else if (never || !f.seconds)
    lines.push_back("Time: unknown; " + named("max-time") + " limits it");
  else
    lines.push_back(fmt::format(
        "Time: {} of CPU{}, on a core at 2.5 GHz; accurate to a factor of 3, less accurate near the limit",
        about(*f.seconds), wallText(problem, ranks, about(*f.seconds / speedup(problem, ranks)))));
  const double megabytes = soft ? f.deformedMegabytes : f.megabytes;
  lines.push_back(
      fmt::format("Memory: {} for each rank", memoryText(ofProgram + (megabytes - ofProgram) / ranks)));
  const double tiles = double(problem.request.tiles[0]) * problem.request.tiles[1] * problem.request.tiles[2];
  if (tiles > 1.0)
    lines.push_back(
        fmt::format("Then repeated {} x {} x {} times: {:.0f} cells, {} in all; the certificate "
                    "of the larger "
                    "box takes additional time",
                    problem.request.tiles[0], problem.request.tiles[1], problem.request.tiles[2],
                    tiles * double(f.cells), memoryText(ofProgram + tiles * (megabytes - ofProgram))));
  if (const std::string left = leftOut(problem); !left.empty())
    lines.push_back(
        fmt::format("Not included in these figures: {}; packing then is harder and takes longer", left));
  if (problem.request.realisations > 1)
    lines.push_back(fmt::format("{} realisations, one after the other: each takes this time",
                                problem.request.realisations));
  return {std::move(lines), never && !problem.request.deforms(), f.seconds, megabytes};
}

}  // namespace packmesh::hemocell
