// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/plan_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/problem/depth_profile.h"
#include "hemocell_adapter/problem/forecast.h"
#include "packMesh/container/side_wall.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/poll.h"
#include "packMesh/core/random.h"
#include "packMesh/packing/state_file.h"
#include "packMesh/placement/placement.h"
#include "packMesh/shape/surface_distance.h"

namespace packmesh::hemocell {
namespace {

constexpr double plateletsAtWall = 5.0;  ///< per concentration in the core

std::vector<std::string> wordsOf(std::string line) {
  line.resize(std::min(line.find('#'), line.size()));
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream text(line);
  std::vector<std::string> words;
  for (std::string word; text >> word;) words.push_back(word);
  return words;
}

/// Reads a table line by line. @throws InputError
class Reading {
 public:
  explicit Reading(const Source& file) : file_(file) {
    profile_.source = file.given ? "a table" : file.string();
  }

  ProfileSource operator()() {
    if (file_.given)
      readNumbers();
    else
      readLines();
    if (profile_.distance.empty())
      throw InputError(
          fmt::format("{}: expected a line such as 'distance RBC PLT' and rows of numbers", file_.string()));
    for (const ProfileSource::Column& column : profile_.columns)
      if (!(*std::max_element(column.value.begin(), column.value.end()) > 0.0))
        throw InputError(fmt::format("{}: the column '{}' has no value above 0: where are these cells to be?",
                                     file_.string(), column.species));
    return std::move(profile_);
  }

 private:
  void readLines() {
    std::istringstream lines(contentOf(file_.file, "a profile"));
    for (std::string line; std::getline(lines, line);) {
      ++line_;
      const std::vector<std::string> words = wordsOf(line);
      if (words.empty()) continue;
      if (profile_.columns.empty())
        head(words);
      else
        row(words);
    }
  }

  void readNumbers() {
    const std::vector<StateTable>& columns = file_.given->tables;
    std::vector<std::string> words;
    for (const StateTable& column : columns) words.push_back(column.name);
    if (words.empty()) return;
    head(words);
    for (const StateTable& column : columns)
      if (column.values.size() != columns[0].values.size()) refuse("columns of different lengths");
    for (std::size_t i = 0; i < columns[0].values.size(); ++i) {
      line_ = int(i) + 1;
      for (std::size_t c = 0; c < columns.size(); ++c) words[c] = fmt::format("{}", columns[c].values[i]);
      row(words);
    }
  }

  [[noreturn]] void refuse(const std::string& reason) const {
    if (file_.given)
      throw InputError(file_.string() + (line_ > 0 ? fmt::format(": row {}", line_) : "") + ": " + reason);
    throw InputError(fmt::format("{}:{}: {}", file_.string(), line_, reason));
  }

  void head(const std::vector<std::string>& words) {
    if (words[0] != "distance" && words[0] != "fraction")
      refuse(
          fmt::format("expected 'distance' (from the wall, in µm) or 'fraction' (of the largest distance), "
                      "then names of cells; found '{}'",
                      words[0]));
    profile_.isFraction = words[0] == "fraction";
    for (std::size_t i = 1; i < words.size(); ++i) {
      if (!isCellName(words[i])) refuse(fmt::format("expected {}, found '{}'", expectedCellName(), words[i]));
      if (profile_.columnOf(words[i])) refuse(fmt::format("a second column '{}'", words[i]));
      profile_.columns.push_back({words[i], {}});
    }
    if (profile_.columns.empty()) refuse(fmt::format("names of cells are missing: {} RBC", words[0]));
  }

  void row(const std::vector<std::string>& words) {
    if (words.size() != profile_.columns.size() + 1)
      refuse(fmt::format("expected {} numbers, found {}", profile_.columns.size() + 1, words.size()));
    for (std::size_t i = 0; i < words.size(); ++i) {
      const std::optional<double> number = toNumber(words[i]);
      constexpr double largest = 1e6;
      if (!number || !(*number >= 0.0 && *number <= largest))
        refuse(fmt::format("expected a number in [0, {:g}], found '{}'", largest, words[i]));
      if (i > 0) profile_.columns[i - 1].value.push_back(*number);
      if (i > 0) continue;
      if (profile_.isFraction && *number > 1.0)
        refuse(fmt::format("expected a fraction in [0, 1], found '{}'", words[i]));
      if (!profile_.distance.empty() && *number <= profile_.distance.back())
        refuse(fmt::format("the distances must increase; found {} after {:.15g}", words[i],
                           profile_.distance.back()));
      profile_.distance.push_back(*number);
    }
  }

  const Source& file_;
  int line_ = 0;
  ProfileSource profile_;
};

}  // namespace

double ProfileSource::at(const Column& column, double x) const {
  const std::size_t above = std::upper_bound(distance.begin(), distance.end(), x) - distance.begin();
  if (above == 0) return column.value.front();
  if (above == distance.size()) return column.value.back();
  const double t = (x - distance[above - 1]) / (distance[above] - distance[above - 1]);
  return column.value[above - 1] + t * (column.value[above] - column.value[above - 1]);
}

const ProfileSource::Column* ProfileSource::columnOf(const std::string& species) const {
  for (const Column& column : columns)
    if (column.species == species) return &column;
  return nullptr;
}

ProfileSource readProfile(const Source& source) {
  return Reading(source)();
}

ProfileSource developedFlow(double tubeHematocrit, double diameter, const std::vector<std::string>& redCells,
                            const std::vector<std::string>& platelets) {
  const double layer = freeLayerOf(tubeHematocrit, diameter);
  ProfileSource profile;
  profile.source = fmt::format(
      "developed flow: cell-free layer {:.3g} µm by the Fåhraeus effect (Pries 1990, Sutera "
      "1970) in {:.4g} µm at hematocrit {:.3g}, platelets {:g} times as concentrated there",
      layer, diameter, tubeHematocrit, plateletsAtWall);
  profile.distance = {0.0, 0.5 * layer, layer, 1.5 * layer, 2.0 * layer};
  for (const std::string& name : redCells) profile.columns.push_back({name, {0.0, 0.0, 0.5, 1.0, 1.0}});
  constexpr double between = 0.5 * (1.0 + plateletsAtWall);
  for (const std::string& name : platelets)
    profile.columns.push_back({name, {plateletsAtWall, plateletsAtWall, plateletsAtWall, between, 1.0}});
  return profile;
}

namespace {

/// Random points by which the lumen is measured; layers and shells [µm]; at most so many of them.
constexpr std::int64_t lumenPoints = 1 << 17;
constexpr double leastLayer = 0.25, leastShell = 2.0;
constexpr int mostLayers = 200, mostShells = 16;

/// Random poses of a species in each shell, rotations that are tried for each, and points of a cell: inner
/// ones, and vertices by which its distance from the wall is examined.
constexpr std::size_t posesOfShell = 400, fewestPoses = 20;
constexpr std::uint32_t rotations = 20;
constexpr int innerPointsOfCell = 64;
constexpr std::size_t verticesOfCell = 64;

/// Correction by a packing: so many random cells in each shell count, too, so that a few cells do not decide.
constexpr double randomCells = 2.0;

/// Iterations of the deconvolution: more would fit noise.
constexpr int iterations = 60;

/// Volumes are summed as multiples of this [µm³], so that the sum does not depend on the order.
constexpr double volumeStep = 0x1p-20;

/// The weights of the shells with which the volume has the profile that is asked for, as nearly as cells can;
/// starts from those that are there.
void fitWeights(const DepthProfile& plan, SpeciesProfile& species) {
  std::vector<double> wanted;
  for (std::size_t k = 0; k < plan.lumen.size(); ++k) wanted.push_back(plan.lumen[k] * species.asked[k]);
  const double all = std::accumulate(wanted.begin(), wanted.end(), 0.0);
  for (double& share : wanted) share /= all;
  for (int i = 0; i < iterations; ++i) {
    const double sum = std::accumulate(species.weight.begin(), species.weight.end(), 0.0);
    std::vector<double> made(wanted.size(), 0.0);
    for (int j = 0; j < plan.shells(); ++j)
      for (std::size_t k = 0; k < species.spread[j].size(); ++k)
        made[k] += species.weight[j] / sum * species.spread[j][k];
    for (int j = 0; j < plan.shells(); ++j) {
      double factor = 0.0;
      for (std::size_t k = 0; k < species.spread[j].size(); ++k)
        if (made[k] > 0.0) factor += species.spread[j][k] * wanted[k] / made[k];
      species.weight[j] *= factor;
    }
  }
}

class Planning {
 public:
  Planning(const Scene& scene, std::vector<std::string>& notices)
      : scene_(scene), notices_(notices), container_(*scene.lumen.container) {}

  std::shared_ptr<const DepthProfile> operator()() {
    makeDepth();
    sampleLumen();
    const ProfileSource source = sourceOf();
    plan_.source = source.source;
    plan_.species.resize(scene_.species.size());
    bool any = false;
    for (std::size_t s = 0; s < scene_.species.size(); ++s) {
      const CellSpecies& species = scene_.species[s];
      const ProfileSource::Column* column = source.columnOf(species.name);
      if (!column || species.count == 0) continue;
      any = true;
      ask(source, *column, plan_.species[s], double(species.count) * species.meanVolume);
    }
    for (const ProfileSource::Column& column : source.columns)
      if (std::none_of(scene_.species.begin(), scene_.species.end(),
                       [&](const CellSpecies& s) { return s.name == column.species && s.count > 0; }))
        notices_.push_back(
            fmt::format("{}: there are no cells '{}' to distribute", source.source, column.species));
    if (!any) throw InputError(fmt::format("{}: none of the cells to pack has a profile", source.source));
    for (std::size_t s = 0; s < scene_.species.size(); ++s)
      if (plan_.species[s].isAsked()) distribute(int(s));
    return std::make_shared<const DepthProfile>(std::move(plan_));
  }

 private:
  void makeDepth() {
    const auto refuse = [] {
      throw InputError("a profile is over the distance from the wall, and this lumen has none (see " +
                       named("walls") + ")");
    };
    if (!container_.wall() || !scene_.lumen.solidWalls) refuse();
    const auto wall = std::make_shared<const SideWall>(scene_.lumen.container, endAxes(scene_));
    if (!wall->exists()) refuse();
    plan_.depth = std::make_shared<const SideDepth>(wall, container_.bounds());
  }

  double depthAt(const Vec3& p) const { return (*plan_.depth)(p).distance; }

  void sampleLumen() {
    const Box bounds = container_.bounds();
    std::vector<double> depths;
    for (std::int64_t i = 0; i < lumenPoints; ++i) {
      if (i % 1024 == 0) poll();
      const auto u = uniform4(0, RandomStream::sample, std::uint64_t(i), 1);
      const Vec3 p = bounds.lo + bounds.size().cwiseProduct(Vec3(u[0], u[1], u[2]));
      const double depth = depthAt(p);
      if (!(depth > 0.0)) continue;
      inside_.push_back(p);
      depths.push_back(depth);
    }
    const double deepest = depths.empty() ? 0.0 : *std::max_element(depths.begin(), depths.end());
    if (!(deepest > 0.0)) throw InputError("the lumen is too thin for a profile");
    const auto parts = [&](double least, int most) {
      return std::clamp(int(std::ceil(deepest / least)), 1, most);
    };
    const int layers = parts(leastLayer, mostLayers), shells = parts(leastShell, mostShells);
    plan_.width = deepest / layers;
    plan_.lumen.assign(layers, 0.0);
    for (int k = 0; k <= shells; ++k) plan_.edges.push_back(deepest * k / shells);
    pointsOfShell_.resize(shells);
    for (std::size_t i = 0; i < depths.size(); ++i) {
      plan_.lumen[plan_.layerAt(depths[i])] += bounds.volume() / double(lumenPoints);
      std::vector<std::size_t>& here = pointsOfShell_[plan_.shellAt(depths[i])];
      if (here.size() < posesOfShell) here.push_back(i);
    }
  }

  ProfileSource sourceOf() {
    const Source& source = *scene_.request.profile;
    if (source.given || source.file != developedProfile) return readProfile(source);
    std::vector<std::string> red, platelets;
    double volume = 0.0;
    for (const CellSpecies& species : scene_.species) {
      if (species.redCell) red.push_back(species.name);
      if (species.redCell) volume += double(species.count) * species.meanVolume;
      if (!species.redCell && species.name.rfind("PLT", 0) == 0) platelets.push_back(species.name);
    }
    if (!(volume > 0.0)) throw InputError("a developed profile is that of red cells, and there are none");
    const double diameter = *hydraulicDiameter(container_, endAxes(scene_));
    if (const auto warning = fahraeusWarning(diameter)) notices_.push_back("developed profile: " + *warning);
    return developedFlow(volume / container_.volume(), diameter, red, platelets);
  }

  /// Volume fractions with the ratios of a column, and `volume` [µm³] in all.
  void ask(const ProfileSource& source, const ProfileSource::Column& column, SpeciesProfile& species,
           double volume) const {
    const double unit = source.isFraction ? plan_.edges.back() : 1.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < plan_.lumen.size(); ++k) {
      species.asked.push_back(source.at(column, (double(k) + 0.5) * plan_.width / unit));
      sum += plan_.lumen[k] * species.asked.back();
    }
    if (!(sum > 0.0))
      throw InputError(fmt::format("{}: '{}' is 0 everywhere in the lumen, which is at most {:.4g} µm deep",
                                   source.source, column.species, plan_.edges.back()));
    const double all = std::accumulate(plan_.lumen.begin(), plan_.lumen.end(), 0.0);
    for (double& fraction : species.asked) fraction *= volume / container_.volume() * all / sum;
    for (std::size_t i = 0; i < column.value.size() && column.value[i] == 0.0; ++i)
      species.freeLayer = unit * source.distance[i];
  }

  /// The part of the volume of cells in each layer, [shell][layer], if their centre is in a shell; empty
  /// where no cell fits.
  std::vector<std::vector<double>> spreadOf(int s) const {
    const CellSpecies& species = scene_.species[s];
    const std::vector<Vec3> inner = innerPoints(*species.shape, innerPointsOfCell);
    const std::vector<Vec3>& all = species.shape->mesh().vertices;
    std::vector<Vec3> vertices;
    const std::size_t every = std::max<std::size_t>(1, all.size() / verticesOfCell);
    for (std::size_t i = 0; i < all.size(); i += every) vertices.push_back(all[i]);
    const Request& request = scene_.request;
    const double wall = request.choosesWallClearance() ? request.dx : scene_.demanded.wall;
    const double least = std::max(plan_.species[s].freeLayer, species.wallClearance(wall));
    std::vector<std::vector<double>> spread(plan_.shells());
    for (int j = 0; j < plan_.shells(); ++j) {
      poll();
      std::vector<double> layers(plan_.lumen.size(), 0.0);
      std::size_t poses = 0;
      for (const std::size_t i : pointsOfShell_[j])
        if (const auto pose = fittingPose(species, i, vertices, least)) {
          ++poses;
          for (const Vec3& p : inner)
            layers[plan_.layerAt(depthAt((*pose)(p)))] += 1.0 / double(inner.size());
        }
      if (poses < std::min(fewestPoses, pointsOfShell_[j].size())) continue;
      for (double& share : layers) share /= double(poses);
      spread[j] = std::move(layers);
    }
    return spread;
  }

  /// A random pose with the centre at a point of the lumen and the membrane at least `least` deep, if one is
  /// found.
  std::optional<Placement> fittingPose(const CellSpecies& species, std::size_t point,
                                       const std::vector<Vec3>& vertices, double least) const {
    for (std::uint32_t attempt = 0; attempt < rotations; ++attempt) {
      Pose pose;
      pose.position = inside_[point];
      const auto u = uniform4(0, RandomStream::orientation, point, attempt);
      if (scene_.request.rotate) pose.orientation = randomOrientation(species.cone, u[0], u[1], u[2]);
      const Placement placed = pose.placement();
      if (std::all_of(vertices.begin(), vertices.end(),
                      [&](const Vec3& v) { return depthAt(placed(v)) >= least; }))
        return placed;
    }
    return {};
  }

  void distribute(int s) {
    SpeciesProfile& species = plan_.species[s];
    species.spread = spreadOf(s);
    for (int j = 0; j < plan_.shells(); ++j)
      species.weight.push_back(species.spread[j].empty() ? 0.0 : double(pointsOfShell_[j].size()));
    if (std::accumulate(species.weight.begin(), species.weight.end(), 0.0) == 0.0)
      throw InputError(fmt::format("{}: no cell '{}' fits more than {:.3g} µm from the wall", plan_.source,
                                   scene_.species[s].name, species.freeLayer));
    fitWeights(plan_, species);
  }

  const Scene& scene_;
  std::vector<std::string>& notices_;
  const Container& container_;
  DepthProfile plan_;
  std::vector<Vec3> inside_;                             ///< sample points in the lumen
  std::vector<std::vector<std::size_t>> pointsOfShell_;  ///< some of them
};

}  // namespace

std::shared_ptr<const DepthProfile> planProfile(const Scene& scene, std::vector<std::string>& notices) {
  return Planning(scene, notices)();
}

void refuseTooDense(const Scene& scene, const DepthProfile& plan) {
  for (int j = 0; j < plan.shells(); ++j) {
    const double fraction = plan.askedIn(j);
    if (fraction > Forecast::possible)
      throw InfeasibleError(fmt::format(
          "{}: between {:.3g} and {:.3g} µm from the wall the cells would have {:.3f} of the volume; no "
          "random packing beyond {:.2f} is known. Ask for fewer cells, or for a flatter profile{}",
          plan.source, plan.edges[j], plan.edges[j + 1], fraction, Forecast::possible,
          deformedInstead(scene)));
  }
}

std::shared_ptr<const DepthProfile> correctedProfile(const Problem& problem, const PackingResult& packed) {
  DepthProfile plan = *problem.layout.profile;
  const std::size_t shells = plan.shells(), layers = plan.lumen.size();
  std::vector<std::int64_t> points(plan.species.size() * shells * layers, 0);
  std::vector<std::vector<Vec3>> inner;
  for (const CellSpecies& species : problem.species)
    inner.push_back(innerPoints(*species.shape, innerPointsOfCell));
  const auto depthAt = [&](const Vec3& p) { return (*plan.depth)(p).distance; };
  std::size_t i = 0;
  for (std::size_t p = 0; p < packed.counts.size(); ++p) {
    const Part& part = problem.atDemanded.parts[p];
    for (const std::size_t end = i + std::size_t(packed.counts[p]); i < end; ++i) {
      if (part.region < 0) continue;
      const std::size_t row = part.species * shells + part.region;
      for (const Vec3& inCell : inner[part.species])
        ++points[row * layers + plan.layerAt(depthAt(packed.cells[i].placement(inCell)))];
    }
  }
  problem.ranks.sum(points);
  for (std::size_t s = 0; s < plan.species.size(); ++s) {
    SpeciesProfile& species = plan.species[s];
    if (!species.isAsked()) continue;
    for (std::size_t j = 0; j < shells; ++j) {
      if (species.spread[j].empty()) continue;
      const std::int64_t* here = &points[(s * shells + j) * layers];
      const double found = double(std::accumulate(here, here + layers, std::int64_t(0)));
      const double random = randomCells * double(inner[s].size());
      for (std::size_t k = 0; k < layers; ++k)
        species.spread[j][k] = (double(here[k]) + random * species.spread[j][k]) / (found + random);
    }
    fitWeights(plan, species);
  }
  return std::make_shared<const DepthProfile>(std::move(plan));
}

std::vector<std::vector<double>> reachedProfile(const Problem& problem,
                                                const std::vector<PlacedCell>& cells) {
  const DepthProfile& plan = *problem.layout.profile;
  const std::size_t shells = plan.shells();
  std::vector<std::int64_t> steps(plan.species.size() * shells, 0);
  std::vector<std::vector<Vec3>> points;
  for (const CellSpecies& species : problem.species)
    points.push_back(innerPoints(*species.shape, innerPointsOfCell));
  for (const PlacedCell& cell : cells) {
    if (!plan.species[cell.species].isAsked()) continue;
    const std::vector<Vec3>& inner = points[cell.species];
    const auto each = std::llround(problem.shapes[cell.shape]->volume() / double(inner.size()) / volumeStep);
    for (const Vec3& p : inner)
      steps[cell.species * shells + plan.shellAt((*plan.depth)(cell.placement(p)).distance)] += each;
  }
  problem.ranks.sum(steps);
  std::vector<double> volume(shells, 0.0);
  for (std::size_t k = 0; k < plan.lumen.size(); ++k)
    volume[plan.shellAt((double(k) + 0.5) * plan.width)] += plan.lumen[k];
  const double all = std::accumulate(volume.begin(), volume.end(), 0.0) / problem.lumen.container->volume();
  std::vector<std::vector<double>> reached(plan.species.size());
  for (std::size_t s = 0; s < plan.species.size(); ++s)
    for (std::size_t j = 0; plan.species[s].isAsked() && j < shells; ++j)
      reached[s].push_back(volumeStep * double(steps[s * shells + j]) / volume[j] * all);
  return reached;
}

}  // namespace packmesh::hemocell
