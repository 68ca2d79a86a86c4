// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Growth: small cells grow, each within its own planes, from barrier to barrier.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "packMesh/cat/cat_settings.h"
#include "packMesh/cat/growing_cells.h"
#include "packMesh/cat/step_halving.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

/// Statistics of growth: sums over all ranks, CPU times of this rank with all its threads.
struct GrowthStatistics {
  std::int64_t iterations = 0;
  std::int64_t relaxations = 0, relaxationsKept = 0;  ///< at a barrier; whose result was free of overlap
  std::int64_t planes = 0, pivots = 0;                ///< over all iterations
  StepHalvingSums stepHalving;
  double planeSeconds = 0.0, programSeconds = 0.0, stepHalvingSeconds = 0.0,
         relaxationSeconds = 0.0;  ///< CPU [s]
};

/// Progress of growth; with the cells and the number of iterations, everything that its future depends on.
struct GrowthProgress {
  std::int64_t barrier = 0;                             ///< index
  std::int64_t iteration = 0, since = 0, failures = 0;  ///< at this barrier: iterations done; since the last
                                                        ///< test for a stall; failed relaxations
  double sweeps = 0.0;                                  ///< of the next relaxation
  std::int64_t reference = 0;  ///< total deficit at the last test for a stall [2^-24 of full size]
  bool gaveUp = false;
};

/// When growth stops, and its callbacks. The functions are called on all ranks together.
struct GrowthCallbacks {
  std::function<bool()> stop;  ///< polled before every iteration; the same on all ranks
  /// Called after every iteration with the barrier and the number of cells below it.
  std::function<void(double barrier, std::int64_t below, const GrowthStatistics&)> progress;
  /// Called with this rank's cells of every state that is accepted, sorted by id.
  std::function<void(const std::vector<Body>&)> accepted;
  /// Called every few iterations, before the next one: growth can be resumed from there.
  std::function<void()> checkpoint;
};

/// Algorithm 1 of the thesis.
///
/// For each barrier: planes are constructed from the state, every cell grows within its own up to the
/// barrier, and steps are taken as far as no meshes overlap (StepHalving), until all cells are at the barrier
/// or the maximum number of iterations is reached. Every state is free of overlap by the exact test; no cell
/// ever shrinks. When growth stalls, all cells are set to the barrier's scale and relaxed as rigid bodies; if
/// the exact test finds them free of overlap, this becomes the next state.
///
/// All ranks call its functions together. States do not depend on the number of ranks.
class Growth {
 public:
  /// References all but `own` and `from`, which must outlive it.
  /// @param own this rank's cells, in any distribution; all together free of overlap, no scale above 1
  /// @param statistics is added to; its number of iterations determines the random numbers
  /// @param from where to continue
  /// @throws InputError naming the cell if the first state is not valid
  Growth(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
         PlaneFunction& planeFunction, const GrowthCallbacks& callbacks, std::vector<Body> own,
         GrowthStatistics& statistics, const GrowthProgress& from = {});

  /// Grows until all cells are full, growth has ended, it is stopped, or the statistics contain this many
  /// iterations; if called again, it continues as if it had not stopped. @return whether all cells are full
  bool run(std::int64_t iterations);

  /// Whether growth has ended, so that more iterations change nothing.
  bool ended() const;

  const GrowthProgress& progress() const { return at_; }
  /// This rank's cells, sorted by id.
  std::vector<Body> cells() const { return cells_.own(); }

 private:
  /// Lengths that scale with a mesh [µm].
  struct ShapeLengths {
    double radius, reach, size, facet;  ///< bounding radius, Shape::reach(), cube root of the volume, root of
                                        ///< the mean facet area
  };
  /// Deficit with respect to a scale, over all ranks.
  struct Missing {
    std::int64_t cells = 0, scale = 0;  ///< scale: the sum [2^-24]
  };

  static std::vector<ShapeLengths> lengthsOf(const Physics& physics);
  double range() const;
  void requireValid() const;
  bool stopped(std::int64_t iterations) const;
  Missing missing(double scale) const;
  bool growTo(double barrier, std::int64_t iterations);
  void iterate(double barrier);
  std::size_t batchSize() const;
  /// What a thread sums while it makes planes and solves programmes.
  struct ProposalSums {
    std::int64_t planes = 0, pivots = 0;
    double programSeconds = 0.0;
  };
  CellSurroundings surroundingsFor(double barrier) const;
  void propose(const CellSurroundings& surroundings, double barrier, bool anew,
               std::vector<GrowthStep>& steps);
  void proposeFor(const PlaneRequest& request, double barrier, std::vector<GrowthStep>& steps,
                  std::vector<std::int32_t>& work, ProposalSums& sums);
  void wake(double barrier, const CellSurroundings& surroundings);
  double detailAt(double barrier) const;
  double paddingAt(double barrier, const ShapeLengths& lengths) const;
  double rotationBound() const { return physics_.rotate ? settings_.rotationBound : 0.0; }
  double farthest(double barrier, const ShapeLengths& lengths) const;
  double largestMotion(double barrier) const;
  double reachOf(const Body& cell, double barrier) const;
  GrowthBounds boundsOf(const Body& cell, double barrier) const;
  bool relaxed(double barrier);

  const Physics& physics_;
  const Execution& execution_;
  const GrowthSettings& settings_;
  PlaneFunction& planeFunction_;
  const GrowthCallbacks& callbacks_;
  GrowthStatistics& statistics_;
  GrowthProgress at_;
  std::vector<ShapeLengths> lengths_;  ///< per shape; 0 of those that are not in use
  GrowingCells cells_;
  bool anyFrozen_;
  std::vector<std::vector<std::int64_t>> batches_;  ///< of cells_, since the last distribution
  std::vector<char> awake_;                         ///< per cell of cells_: those that take steps
  StepHalving stepHalving_;
  PerThread<std::vector<CellPlanes>> planes_;  ///< of the cells of a batch
  PerThread<GrowthProgram> programs_;
};

/// Complete growth of cells. All ranks call. @return whether all cells reached scale 1
bool grow(const Physics& physics, const Execution& execution, const GrowthSettings& settings,
          PlaneFunction& planeFunction, const GrowthCallbacks& callbacks, std::vector<Body>& own,
          GrowthStatistics& statistics);

}  // namespace packmesh
