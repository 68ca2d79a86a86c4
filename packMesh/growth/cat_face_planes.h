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
/// Many cells are cut into regions of a few hundred, which do not depend on the number of ranks; every rank
/// tetrahedralises regions of its own, each with the cells around it. When TetGen gives up, planes are those
/// of ChordPlanes.
class CatFacePlanes {
 public:
  /// References the scene and the sums, which must outlive this.
  /// @param sums what it takes is added here
  /// @param failingAttempts for tests: so many attempts of every run are taken to have failed
  /// @param cellsOfRegion at most so many cells are tetrahedralised together
  CatFacePlanes(const GrowthScene& scene, TetrahedraSums& sums, int failingAttempts = 0,
                int cellsOfRegion = defaultCellsOfRegion);

  /// As many as fit without the cells around them, which take part in several regions, being most of the
  /// work.
  static constexpr int defaultCellsOfRegion = 400;

  /// Pre: no two cells overlap
  PlaneConstraints operator()(const GrowthState& state, const PlaneRequest& request);

 private:
  /// Cells that are tetrahedralised together with those around them.
  using Region = std::vector<int>;
  std::vector<Region> regionsOf(const GrowthState& state) const;
  std::vector<Region> ownRegions(const GrowthState& state, const CellShares& shares) const;
  bool tetrahedraOf(const GrowthState& state, const Region& region, double detail);
  void chooseMembers(const GrowthState& state, const Region& region);

  const GrowthScene& scene_;
  int cellsOfRegion_;
  ChordPlanes chords_;
  std::vector<std::vector<std::unique_ptr<MeshHierarchy>>> levels_;  ///< per species, finest first
  TetrahedraInput input_;
  std::vector<int> members_;  ///< the cells that input_'s objects are
  Tetrahedra tetrahedra_;
  ChordalFaces split_;
  TetrahedraSums& sums_;
};

}  // namespace packmesh
