// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes from the CAT faces of tetrahedra between the cells (thesis 3.1.2).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "packMesh/cat/chord_planes.h"
#include "packMesh/cat/reached_bodies.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/problem/execution.h"

namespace packmesh {

/// Statistics of tetrahedralisation on one rank.
struct TetrahedraSums {
  std::int64_t runs = 0;      ///< tetrahedralisations
  std::int64_t attempts = 0;  ///< of TetGen; more than runs if it had to be repeated in other modes
  std::int64_t finer = 0;     ///< runs repeated on a finer level because the coarse ones overlapped
  std::int64_t failures = 0;  ///< TetGen failed: planes were those of ChordPlanes
  std::string lastFailure;    ///< description, of the last request of those with failures
  double tetrahedraSeconds = 0.0, faceSeconds = 0.0;  ///< CPU [s]
};

/// Planes from CAT faces, except for those of slivers: TetGen divides the space between the cells. Planes at
/// walls are those of ChordPlanes: the distance to the wall is exact, a triangulation of it is not.
///
/// Cells that are requested together are tetrahedralised together with what is within their reach,
/// independently of the rank; as many requests at the same time as there are threads. If TetGen fails, their
/// planes are those of ChordPlanes.
class CatFacePlanes : public PlaneFunction {
 public:
  /// References physics, execution and sums, which must outlive this.
  /// @param sums statistics are added to this
  /// @param failingAttempts for tests: the number of attempts of every run that are treated as failed
  CatFacePlanes(const Physics& physics, const Execution& execution, TetrahedraSums& sums,
                int failingAttempts = 0);

  void begin(const std::vector<PlaneRequest>& requests) override;
  /// Pre: begin() was called for the last one of this batch that was `anew`
  void operator()(const PlaneRequest& request, std::vector<CellPlanes>& planes) override;
  std::int64_t cellsAtOnce() const override;
  std::int64_t lifetime() const override;

 private:
  /// The tetrahedra around one group of cells.
  struct Around {
    std::vector<std::int64_t> members;  ///< the cells included
    std::vector<PlacedMesh> objects;    ///< these, at their positions when the points were last moved
    Tetrahedra tetrahedra;
    TetrahedraSums sums;  ///< of this run
  };
  /// The level of detail of a species that is at most `coarsest`, and fine enough for the request.
  int levelOf(const PlaneRequest& request, int species, int coarsest) const;
  void tetrahedralise(const PlaneRequest& request, const std::function<bool()>& stop, Around& around) const;
  /// Places the members at a level of detail.
  void place(const PlaneRequest& request, const ReachedBodies& reached, int level,
             TetrahedraInput& input) const;
  void follow(const PlaneRequest& request, Around& around) const;

  const Physics& physics_;
  const Execution& execution_;
  ChordPlanes chords_;
  std::vector<std::vector<std::unique_ptr<const ReachingMesh>>> levels_;  ///< per species, finest first
  TetrahedraInput input_;                                                 ///< what is common to all
  std::vector<Around> around_;                                            ///< per batch
  TetrahedraSums& sums_;
  std::mutex sumsMutex_;  ///< of sums_.faceSeconds
};

}  // namespace packmesh
