// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Planes from the CAT faces of tetrahedra between the cells (thesis 3.1.2).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "packMesh/growth/chord_planes.h"
#include "packMesh/growth/chordal_split.h"
#include "packMesh/growth/tetrahedra.h"
#include "packMesh/problem/execution.h"

namespace packmesh {

/// Statistics of tetrahedralisation on one rank.
struct TetrahedraSums {
  std::int64_t runs = 0;      ///< tetrahedralisations
  std::int64_t attempts = 0;  ///< of TetGen; more than runs if it had to be repeated in other modes
  std::int64_t finer = 0;     ///< runs repeated on a finer level because the coarse ones overlapped
  std::int64_t failures = 0;  ///< TetGen failed: planes were those of ChordPlanes
  std::string lastFailure;    ///< description
  double tetrahedraSeconds = 0.0, faceSeconds = 0.0;  ///< CPU [s]
};

/// Planes from CAT faces, except for those of slivers: TetGen divides the space between the cells. Planes at
/// walls are those of ChordPlanes: the distance to the wall is exact, a triangulation of it is not.
///
/// Cells that are requested together are tetrahedralised together with those that they can reach before the
/// next run, independently of the rank. If TetGen fails, their planes are those of ChordPlanes.
class CatFacePlanes : public PlaneFunction {
 public:
  /// References physics, execution and sums, which must outlive this.
  /// @param sums statistics are added to this
  /// @param failingAttempts for tests: the number of attempts of every run that are treated as failed
  CatFacePlanes(const Physics& physics, const Execution& execution, TetrahedraSums& sums,
                int failingAttempts = 0);

  PlaneConstraints operator()(const PlaneRequest& request) override;
  std::int64_t cellsAtOnce() const override;
  std::int64_t lifetime() const override;

 private:
  /// The tetrahedra around one group of cells.
  struct Around {
    std::vector<std::int64_t> members;  ///< the cells included
    std::vector<NearPair> pairs;        ///< that can come within reach
    std::vector<PlacedMesh> objects;    ///< these, at their positions when the points were last moved
    Tetrahedra tetrahedra;
    bool failed = false;
  };

  /// The level of detail of a species that is at most `coarsest`, and fine enough for the request.
  int levelOf(const PlaneRequest& request, int species, int coarsest) const;
  void choosePoints(const PlaneRequest& request, const Around& around, int coarsest);
  void tetrahedralise(const PlaneRequest& request, Around& around);
  void chooseBodies(const PlaneRequest& request, Around& around);
  void follow(const PlaneRequest& request, Around& around) const;

  const Physics& physics_;
  const Execution& execution_;
  ChordPlanes chords_;
  std::vector<std::vector<std::unique_ptr<MeshHierarchy>>> levels_;  ///< per species, finest first
  /// Per species and level, which vertices are those of the coarsest level.
  std::vector<std::vector<std::vector<char>>> outlines_;
  TetrahedraInput input_;
  std::vector<Around> around_;  ///< per batch
  ChordalFaces split_;
  TetrahedraSums& sums_;
};

}  // namespace packmesh
