// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "hemocell_adapter/scene.h"
#include "packMesh/error.h"
#include "packMesh/random.h"

namespace packmesh::hemocell {
namespace {

std::string bitsOf(const Pose& pose) {
  std::array<double, 7> numbers{};
  for (int k = 0; k < 3; ++k) numbers[k] = pose.position[k];
  for (int k = 0; k < 4; ++k) numbers[3 + k] = pose.orientation.coeffs()[k];
  return {reinterpret_cast<const char*>(numbers.data()), sizeof numbers};
}

/// `count` of the poses, drawn without bias, in their order.
std::vector<Pose> drawn(std::vector<Pose> poses, std::int64_t count, std::uint64_t seed,
                        std::uint64_t stream) {
  if (count >= std::int64_t(poses.size())) return poses;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < poses.size(); ++i)
    order.emplace_back(uniform4(seed, RandomStream::draw, i, std::uint32_t(stream))[0], i);
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> chosen;
  for (std::int64_t i = 0; i < count; ++i) chosen.push_back(order[i].second);
  std::sort(chosen.begin(), chosen.end());
  std::vector<Pose> some;
  for (const std::size_t i : chosen) some.push_back(poses[i]);
  return some;
}

std::vector<Pose> posesOf(const std::vector<PosLine>& lines) {
  std::vector<Pose> poses;
  for (const PosLine& line : lines) poses.push_back(poseOf(line));
  return poses;
}

/// `total` cells shared out in proportion to the weights, the largest remainders first.
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

class Parting {
 public:
  Parting(const Job& job, const Scene& scene) : job_(job), scene_(scene) {}

  std::vector<ScenePart> operator()() {
    for (std::size_t s = 0; s < scene_.species.size(); ++s) divide(int(s));
    return std::move(parts_);
  }

 private:
  Freedom freedomOf(const SceneSpecies& species) const {
    Freedom freedom;
    freedom.cone = species.job.cone;
    freedom.extraWallClearance = species.job.wallClearance - job_.wallClearance;
    return freedom;
  }

  void divide(int s) {
    const SceneSpecies& species = scene_.species[s];
    const auto fixed = posesOf(species.job.fixed);
    if (std::int64_t(fixed.size()) > species.count)
      throw InputError(fmt::format("{}: holds {} cells that are to stay, but only {} '{}' are asked for",
                                   species.job.fixedFrom, fixed.size(), species.count, species.job.name));
    if (!fixed.empty()) {
      ScenePart part{s, species.job.name + ", fixed", std::int64_t(fixed.size()), fixed, {}, -1};
      part.freedom.fixed = true;
      part.freedom.extraWallClearance = species.job.wallClearance - job_.wallClearance;
      parts_.push_back(std::move(part));
    }
    const bool filler = !species.job.count && !species.job.ratio;
    if (scene_.regions.empty() || !filler)
      free(s, -1, species.count - std::int64_t(fixed.size()), posesOf(species.job.start));
    else
      divideAmongRegions(s, fixed);
  }

  void divideAmongRegions(int s, const std::vector<Pose>& fixed) {
    const SceneSpecies& species = scene_.species[s];
    const std::vector<SceneRegion>& regions = scene_.regions;
    std::vector<double> weights;
    for (const SceneRegion& region : regions) weights.push_back(region.share * region.hematocrit);
    std::vector<std::int64_t> counts = sharedOut(species.count, weights);
    for (const Pose& pose : fixed) --counts[regionAt(regions, pose.position)];
    std::vector<std::vector<Pose>> start(regions.size());
    for (const Pose& pose : posesOf(species.job.start))
      start[regionAt(regions, pose.position)].push_back(pose);
    for (std::size_t r = 0; r < regions.size(); ++r) {
      if (counts[r] < 0)
        throw InputError(fmt::format("{}: more of its cells are in {} than the hematocrit there allows",
                                     species.job.fixedFrom, regions[r].name));
      free(s, int(r), counts[r], std::move(start[r]));
    }
  }

  /// A part of cells that may move.
  void free(int s, int region, std::int64_t count, std::vector<Pose> start) {
    if (count == 0 && region >= 0) return;
    const SceneSpecies& species = scene_.species[s];
    ScenePart part{s, species.job.name, count, {}, freedomOf(species), region};
    if (region >= 0) {
      part.name +=
          region + 1 < int(scene_.regions.size()) ? fmt::format(", region {}", region + 1) : ", rest";
      part.freedom.home = scene_.regions[region].region;
    }
    part.start = drawn(std::move(start), count, job_.seed, parts_.size());
    if (job_.rotate && part.freedom.cone)
      for (Pose& pose : part.start) pose.orientation = part.freedom.cone->nearest(pose.orientation);
    parts_.push_back(std::move(part));
  }

  const Job& job_;
  const Scene& scene_;
  std::vector<ScenePart> parts_;
};

}  // namespace

std::vector<SceneRegion> makeRegions(const Job& job, const Lumen& lumen) {
  std::vector<SceneRegion> regions;
  if (job.regions.empty()) return regions;
  const Box bounds = lumen.container->bounds();
  const Vec3 period = lumen.container->period();
  std::vector<std::shared_ptr<const Container>> earlier;
  std::vector<std::string> notices;
  double rest = 1.0;
  for (const RegionRequest& request : job.regions) {
    std::shared_ptr<const Container> body = makeSolid(request.body, {false, false, false}, notices);
    const auto region = std::make_shared<Region>(body, earlier, bounds, period);
    const double share = volumeInLumen(*region, *lumen.container) / lumen.container->volume();
    if (!(share > 0.0))
      throw InputError(
          fmt::format("{}: this region lies outside the lumen or in earlier ones", request.body.where));
    regions.push_back({fmt::format("region {}", regions.size() + 1), region, share, request.hematocrit});
    rest = std::max(0.0, rest - share);
    earlier.push_back(std::move(body));
  }
  regions.push_back({"the rest", std::make_shared<Region>(nullptr, earlier, bounds, period), rest,
                     job.hematocrit.value_or(0.0)});
  return regions;
}

int regionAt(const std::vector<SceneRegion>& regions, const Vec3& point) {
  for (std::size_t r = 0; r + 1 < regions.size(); ++r)
    if (regions[r].region->contains(point)) return int(r);
  return int(regions.size()) - 1;
}

std::vector<ScenePart> makeParts(const Job& job, const Scene& scene) {
  return Parting(job, scene)();
}

void ReadLines::add(const PosLine& line) {
  lines_.emplace(bitsOf(poseOf(line)), line);
}

PosLine ReadLines::lineOf(const Pose& pose) const {
  if (!lines_.empty()) {
    const auto found = lines_.find(bitsOf(pose));
    if (found != lines_.end()) return found->second;
  }
  return posLineOf(pose);
}

}  // namespace packmesh::hemocell
