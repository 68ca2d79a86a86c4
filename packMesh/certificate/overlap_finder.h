// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Search for the overlaps of moving cells, several times with the same neighbours.
#pragma once

#include <cstdint>
#include <vector>

#include "packMesh/certificate/certified_cells.h"

namespace packmesh {

/// Finds overlapping pairs among cells that move a little between searches.
class OverlapFinder {
 public:
  /// References its arguments. The cells may be changed between searches.
  /// @param neighbors of spheres that contain the cells in all searches, up to whole periods
  /// @param positions of the cells when the neighbours were listed
  OverlapFinder(const CertificateInput& input, const PeriodicNeighbors& neighbors,
                std::vector<Vec3> positions);

  /// The overlapping pairs that contain at least one of `moved` (each once), sorted by cell; without gaps and
  /// walls.
  std::vector<OverlappingPair> operator()(const std::vector<std::int64_t>& moved) const;

 private:
  NearPair asPlaced(const NearPair& pair) const;

  const CertificateInput& input_;
  CertifiedCells cells_;
  std::vector<Vec3> listed_;
  const PeriodicNeighbors& neighbors_;
};

}  // namespace packmesh
