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

namespace packmesh {

/// What tetrahedra took, on one rank.
struct TetrahedraSums {
  std::int64_t runs = 0;      ///< tetrahedralisations
  std::int64_t attempts = 0;  ///< of TetGen; more than runs when it had to be called in other ways
  std::int64_t finer = 0;     ///< a coarse level met another cell's, so that a finer one was taken
  std::int64_t failures = 0;  ///< TetGen gave up: planes were those of all cells that are near
  std::string lastFailure;    ///< why
  double tetrahedraSeconds = 0.0, faceSeconds = 0.0;  ///< CPU [s]
};

/// Planes from CAT faces, but for those of slivers: TetGen cuts up the space between the cells. Planes at
/// walls are those of ChordPlanes: the wall's distance is exact, its triangles are not.
///
/// Cells asked for together are tetrahedralised together with those around them, on whichever rank asks. When
/// TetGen fails, their planes are those of ChordPlanes.
class CatFacePlanes : public PlaneFunction {
 public:
  /// References the scene and the sums, which must outlive this.
  /// @param sums what it takes is added here
  /// @param failingAttempts for tests: so many attempts of every run are taken to have failed
  CatFacePlanes(const GrowthScene& scene, TetrahedraSums& sums, int failingAttempts = 0);

  PlaneConstraints operator()(const PlaneRequest& request) override;
  double range(std::int64_t count) const override;
  std::int64_t cellsAtOnce() const override;
  std::int64_t lifetime() const override;

 private:
  /// The tetrahedra around one group of cells.
  struct Around {
    std::vector<std::int64_t> members;  ///< the cells that take part
    std::vector<PlacedMesh> objects;    ///< these, where they were when the points were last moved
    Tetrahedra tetrahedra;
    bool failed = false;
  };

  void tetrahedralise(const PlaneRequest& request, Around& around);
  void chooseMembers(const PlaneRequest& request, Around& around);
  void follow(const PlaneRequest& request, Around& around) const;
  double margin(double largestRadius, std::int64_t count) const;

  const GrowthScene& scene_;
  ChordPlanes chords_;
  std::vector<std::vector<std::unique_ptr<MeshHierarchy>>> levels_;  ///< per species, finest first
  TetrahedraInput input_;
  std::vector<Around> around_;  ///< per batch
  ChordalFaces split_;
  TetrahedraSums& sums_;
};

}  // namespace packmesh
