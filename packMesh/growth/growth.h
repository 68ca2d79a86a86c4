// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth: small cells grow, each within its own planes, barrier by barrier.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/growth/growing_cells.h"
#include "packMesh/growth/growth_settings.h"
#include "packMesh/growth/plane_function.h"
#include "packMesh/growth/step_halving.h"

namespace packmesh {

/// How growth went: sums over all ranks, CPU times of this rank.
struct GrowthStatistics {
  std::int64_t iterations = 0;
  std::int64_t relaxations = 0, relaxationsKept = 0;  ///< at a barrier; whose result was free of overlap
  std::int64_t planes = 0, pivots = 0;                ///< over all iterations
  StepHalvingSums stepHalving;
  double planeSeconds = 0.0, programSeconds = 0.0, stepHalvingSeconds = 0.0,
         relaxationSeconds = 0.0;  ///< CPU [s]
};

/// How far growth has come; with the cells and the number of iterations all that its future depends on.
struct GrowthProgress {
  std::int64_t barrier = 0;                             ///< which
  std::int64_t iteration = 0, since = 0, failures = 0;  ///< at this barrier: done; since it was asked whether
                                                        ///< growth stalled; relaxations in vain
  double sweeps = 0.0;                                  ///< of the next relaxation
  std::int64_t reference = 0;  ///< what was missing when that was asked last [2^-24 of full size]
  bool gaveUp = false;
};

/// When growth stops, and whom it tells. The functions are called on all ranks together.
struct GrowthCallbacks {
  std::function<bool()> stop;  ///< polled before every iteration; the same on all ranks
  /// Called after every iteration with the barrier and the number of cells below it.
  std::function<void(double barrier, std::int64_t below, const GrowthStatistics&)> progress;
  /// Called with this rank's cells of every state that is accepted, in the order of their ids.
  std::function<void(const std::vector<Body>&)> accepted;
  /// Called before every few iterations: growth can go on from there.
  std::function<void()> checkpoint;
};

/// Algorithm 1 of the thesis.
///
/// For each barrier: planes are built from the state, every cell grows in its own as far as the barrier,
/// steps are taken as far as no meshes meet (StepHalving), until all cells are at the barrier or the
/// iterations are used up. Every state is free of overlap by the exact test; no cell ever shrinks. When
/// growth stalls, all cells take the barrier's scale, are relaxed as rigid bodies, and if the exact test
/// finds them free of overlap this is the next state.
///
/// All ranks call its functions together. States do not depend on the number of ranks.
class Growth {
 public:
  /// References all but `own` and `from`, which must outlive it.
  /// @param own this rank's cells, whichever; all together free of overlap, no scale above 1
  /// @param statistics is added to; the iterations so far decide on random numbers
  /// @param from where to go on
  /// @throws InputError naming the cell when the first state is not valid
  Growth(const GrowthScene& scene, const GrowthSettings& settings, PlaneFunction& planeFunction,
         const GrowthCallbacks& callbacks, std::vector<Body> own, GrowthStatistics& statistics,
         const GrowthProgress& from = {});

  /// Grows until all cells are full, growth has ended, it is stopped, or the statistics have so many
  /// iterations; called again, it goes on as if it had not stopped. @return whether all cells are full
  bool run(std::int64_t iterations);

  /// Whether more iterations could change anything.
  bool ended() const;

  const GrowthProgress& progress() const { return at_; }
  /// This rank's cells, in the order of their ids.
  std::vector<Body> cells() const { return cells_.own(); }

 private:
  /// Lengths that scale with a species' mesh [µm].
  struct SpeciesLengths {
    double radius, size, facet;  ///< bounding radius, cube root of the volume, root of the mean triangle's area
  };
  /// What is missing to a scale, over all ranks.
  struct Missing {
    std::int64_t cells = 0, scale = 0;  ///< scale: the sum [2^-24]
  };

  static std::vector<SpeciesLengths> lengthsOf(const GrowthScene& scene);
  double range(std::int64_t count) const;
  void requireValid() const;
  bool stopped(std::int64_t iterations) const;
  Missing missing(double scale) const;
  bool growTo(double barrier, std::int64_t iterations);
  void iterate(double barrier);
  void propose(double barrier, bool anew, std::vector<GrowthStep>& steps);
  std::vector<char> awakeCells(double barrier, const CellSurroundings& surroundings) const;
  double largestRadius() const;
  double detailAt(double barrier) const;
  double paddingAt(double barrier, const SpeciesLengths& lengths) const;
  double rotationBound() const { return scene_.rotate ? settings_.rotationBound : 0.0; }
  double farthest(double barrier, const SpeciesLengths& lengths) const;
  double reachOf(const Body& cell, double barrier) const;
  GrowthBounds boundsOf(const Body& cell, double barrier) const;
  bool relaxed(double barrier);

  const GrowthScene& scene_;
  const GrowthSettings& settings_;
  PlaneFunction& planeFunction_;
  const GrowthCallbacks& callbacks_;
  GrowthStatistics& statistics_;
  GrowthProgress at_;
  std::vector<SpeciesLengths> lengths_;
  GrowingCells cells_;
  bool anyFrozen_;
  std::vector<std::vector<std::int64_t>> batches_;  ///< of cells_, since they were distributed
  StepHalving stepHalving_;
  GrowthProgram program_;
};

/// Growth of cells from the beginning to its end. All ranks call. @return whether all cells reached scale 1
bool grow(const GrowthScene& scene, const GrowthSettings& settings, PlaneFunction& planeFunction,
          const GrowthCallbacks& callbacks, std::vector<Body>& own, GrowthStatistics& statistics);

}  // namespace packmesh
