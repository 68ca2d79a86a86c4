// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/growth.h"

#include <algorithm>
#include <cmath>

#include "packMesh/core/error.h"
#include "packMesh/core/random.h"
#include "packMesh/core/timer.h"
#include "packMesh/growth/barrier_relaxation.h"
#include "packMesh/growth/growth_program.h"
#include "packMesh/growth/require_valid.h"
#include "packMesh/growth/resampling.h"

namespace packmesh {
namespace {

/// Steps seldom use all their bounds at once. Planes are asked for within this share of what they could
/// reach; more of them bring nothing (25³ at 0.45: 1344, 581, 354, 253 planes per cell and 1, 0, 0, 12
/// violating pairs for 1, 0.6, 0.4, 0.3).
constexpr double expectedShare = 0.4;

/// Triangles larger than this [fraction of the cube root of the volume] are large because they are flat, and
/// need no padding for their size.
constexpr double largestFacet = 0.1;

/// The state is offered for keeping every so many iterations.
constexpr std::int64_t iterationsPerCheckpoint = 4;

/// Each relaxation that failed at a barrier is followed by one of so many times as many sweeps.
constexpr double moreSweeps = 1.5;

/// Lengths that scale with a species' mesh [µm].
struct SpeciesLengths {
  double radius, size, facet;  ///< bounding radius, cube root of the volume, root of the mean triangle's area
};

/// One run of grow().
class Growth {
 public:
  Growth(const GrowthScene& scene, const GrowthSettings& settings, const PlaneFunction& planeFunction,
         const GrowthCallbacks& callbacks, GrowthState& state, GrowthStatistics& statistics,
         const GrowthProgress& from)
      : scene_(scene),
        settings_(settings),
        planeFunction_(planeFunction),
        callbacks_(callbacks),
        state_(state),
        statistics_(statistics),
        stepHalving_(scene),
        at_(from) {
    at_.taken.resize(state.size(), 1.0);
    for (const Shape* shape : scene.shapes) {
      const double size = std::cbrt(shape->volume());
      const double meanArea =
          surfaceArea(shape->mesh()) / static_cast<double>(shape->mesh().triangles.size());
      lengths_.push_back({shape->radius(), size, std::min(std::sqrt(meanArea), largestFacet * size)});
    }
  }

  bool operator()() {
    requireValid();
    for (const auto barriers = static_cast<std::int64_t>(settings_.barriers.size()); at_.barrier < barriers;
         ++at_.barrier, at_.iteration = 0) {
      const double barrier = settings_.barriers[at_.barrier];
      if (barrier <= settings_.initialScale) continue;
      growTo(barrier);
      if (stopped() || gaveUp_) break;
    }
    return missing(1.0) == 0.0;
  }

 private:
  void requireValid() {
    const Certificate faults = stepHalving_.examine(state_);
    if (!faults.overlapping.empty())
      throw InputError("cells " + std::to_string(faults.overlapping[0].first) + " and " +
                       std::to_string(faults.overlapping[0].second) + " overlap before growth");
    if (!faults.misplaced.empty())
      throw InputError("cell " + std::to_string(faults.misplaced[0].cell) + " " + faults.misplaced[0].reason +
                       " before growth");
  }

  bool stopped() const { return callbacks_.stop && callbacks_.stop(); }

  /// What cells lack of a scale, in total.
  double missing(double scale) const {
    double sum = 0.0;
    for (const GrowingCell& cell : state_)
      if (!cell.frozen) sum += std::max(0.0, scale - cell.pose.scale);
    return sum;
  }

  bool anyFrozen() const {
    return std::any_of(state_.begin(), state_.end(), [](const GrowingCell& cell) { return cell.frozen; });
  }

  void growTo(double barrier) {
    if (at_.iteration == 0) {
      at_.reference = missing(barrier);
      at_.since = at_.failures = 0;
      at_.sweeps = settings_.relaxationSweeps;
    }
    for (; at_.iteration < settings_.maxIterations && !stopped(); ++at_.iteration) {
      if (callbacks_.checkpoint && statistics_.iterations % iterationsPerCheckpoint == 0)
        callbacks_.checkpoint(state_, at_);
      iterate(barrier);
      const double lacks = missing(barrier);
      if (lacks == 0.0) return;
      if (++at_.since < settings_.patience) continue;
      const bool stalled = lacks > (1.0 - settings_.stalledGrowth) * at_.reference;
      at_.reference = lacks;
      at_.since = 0;
      if (!stalled) continue;
      if (at_.sweeps > 0.0 && !anyFrozen() && relaxed(barrier, static_cast<int>(at_.sweeps))) return;
      at_.sweeps *= moreSweeps;
      gaveUp_ = ++at_.failures == settings_.giveUpAfter;
      if (gaveUp_) return;
    }
  }

  void iterate(double barrier) {
    PlaneRequest request;
    request.shares = scene_.sharesOf(state_);
    for (const GrowingCell& cell : state_) request.reach.push_back(reachOf(cell, barrier));
    request.detail = detailAt(barrier);
    PlaneConstraints planes;
    {
      const Timer watch(statistics_.planeSeconds);
      planes = planeFunction_(state_, request);
    }
    std::vector<std::int64_t> counts = {0, program_.pivots()};
    for (const std::vector<PlaneConstraint>& of : planes) counts[0] += static_cast<std::int64_t>(of.size());

    std::vector<GrowthStep> steps;
    {
      const Timer watch(statistics_.programSeconds);
      for (std::size_t i = 0; i < state_.size(); ++i)
        steps.push_back(state_[i].frozen || !request.shares.own(static_cast<std::int64_t>(i))
                            ? GrowthStep{state_[i].pose.scale}
                            : program_.solve(state_[i].pose, planes[i], boundsOf(i, barrier)));
      shareSteps(request.shares, steps);
    }
    counts[1] = program_.pivots() - counts[1];
    scene_.communicator.sum(counts);
    statistics_.planes += counts[0];
    statistics_.pivots += counts[1];
    {
      const Timer watch(statistics_.stepHalvingSeconds);
      at_.taken = stepHalving_.take(steps, state_, statistics_.stepHalving, request.shares);
    }
    ++statistics_.iterations;
    if (callbacks_.accepted) callbacks_.accepted(state_, barrier, statistics_);
  }

  /// Every rank gets the steps of all cells.
  void shareSteps(const CellShares& shares, std::vector<GrowthStep>& steps) const {
    if (shares.alone()) return;
    struct PlainStep {
      double scale, rotation[3], translation[3];
      std::int64_t cell;
    };
    std::vector<PlainStep> mine;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (!shares.own(static_cast<std::int64_t>(i))) continue;
      PlainStep plain{};
      plain.scale = steps[i].scale;
      Eigen::Map<Vec3>(plain.rotation) = steps[i].rotation;
      Eigen::Map<Vec3>(plain.translation) = steps[i].translation;
      plain.cell = static_cast<std::int64_t>(i);
      mine.push_back(plain);
    }
    for (const PlainStep& plain : scene_.communicator.gatherAll(mine))
      steps[plain.cell] = {plain.scale, Eigen::Map<const Vec3>(plain.rotation),
                           Eigen::Map<const Vec3>(plain.translation)};
  }

  double detailAt(double barrier) const {
    const double first = settings_.initialScale;
    return resamplingFactor((barrier - first) / (1.0 - first), settings_.alpha, settings_.beta);
  }

  /// p of eq. 3.10 [µm].
  double paddingAt(double barrier, const SpeciesLengths& lengths) const {
    return settings_.padding * barrier * lengths.facet / std::sqrt(detailAt(barrier));
  }

  double rotationBound() const { return scene_.rotate ? settings_.rotationBound : 0.0; }

  /// How far points of a cell may be expected to move in one iteration, and how far planes are padded [µm].
  double reachOf(const GrowingCell& cell, double barrier) const {
    const SpeciesLengths& l = lengths_[cell.species];
    const double farthest =
        std::sqrt(3.0) * (settings_.translationBound * l.size + rotationBound() * barrier * l.radius);
    return expectedShare * farthest + std::max(0.0, barrier - cell.pose.scale) * l.radius +
           paddingAt(barrier, l);
  }

  GrowthBounds boundsOf(std::size_t i, double barrier) const {
    const SpeciesLengths& l = lengths_[state_[i].species];
    GrowthBounds bounds;
    // Who ran into something first makes room: otherwise the same step would be proposed again.
    bounds.scale = at_.taken[i] < 1.0 ? state_[i].pose.scale : std::max(barrier, state_[i].pose.scale);
    bounds.rotation = rotationBound();
    bounds.translation = settings_.translationBound * l.size;
    bounds.padding = paddingAt(barrier, l) + 0.5 * scene_.clearance;
    bounds.linearisations = settings_.linearisations;
    if (settings_.centring) bounds.margin = bounds.translation;
    // Pushes compare with the growth that they could cost: per µm for translations, per turn for rotations.
    const auto u =
        uniform4(scene_.seed, RandomStream::turn, i, static_cast<std::uint32_t>(statistics_.iterations));
    const auto v =
        uniform4(scene_.seed, RandomStream::kick, i, static_cast<std::uint32_t>(statistics_.iterations));
    bounds.turn = settings_.shaking * uniformDirection(u[0], u[1]);
    bounds.push = settings_.shaking / l.radius * uniformDirection(v[0], v[1]);
    return bounds;
  }

  bool relaxed(double barrier, int sweeps) {
    ++statistics_.relaxations;
    bool kept = false;
    {
      const Timer watch(statistics_.relaxationSeconds);
      kept = relaxAtScale(scene_, barrier, sweeps, callbacks_.stop, stepHalving_, state_);
    }
    statistics_.relaxationsKept += kept;
    if (kept && callbacks_.accepted) callbacks_.accepted(state_, barrier, statistics_);
    return kept;
  }

  const GrowthScene& scene_;
  const GrowthSettings& settings_;
  const PlaneFunction& planeFunction_;
  const GrowthCallbacks& callbacks_;
  GrowthState& state_;
  GrowthStatistics& statistics_;
  StepHalving stepHalving_;
  GrowthProgram program_;
  std::vector<SpeciesLengths> lengths_;
  GrowthProgress at_;
  bool gaveUp_ = false;
};

}  // namespace

bool grow(const GrowthScene& scene, const GrowthSettings& settings, const PlaneFunction& planeFunction,
          const GrowthCallbacks& callbacks, GrowthState& state, GrowthStatistics& statistics,
          const GrowthProgress& from) {
  return Growth(scene, settings, planeFunction, callbacks, state, statistics, from)();
}

}  // namespace packmesh
