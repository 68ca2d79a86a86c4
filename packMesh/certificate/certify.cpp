// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certify.h"

#include "packMesh/certificate/certifier.h"
#include "packMesh/certificate/overlap_finder.h"

namespace packmesh {
Certificate certify(const CertificateInput& input) {
  return Certifier(input).certificate();
}

Certificate certify(CertificateInput input, double largestGap) {
  input.largestGap = input.largestWallGap = largestGap;
  return certify(input);
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input,
                                          const std::vector<std::int64_t>& movedCells) {
  const PeriodicNeighbors neighbors = CertifiedCells(input).neighbors();
  std::vector<Vec3> positions;
  for (const PlacedCell& cell : *input.cells) positions.push_back(cell.placement.translation);
  return OverlapFinder(input, neighbors, std::move(positions))(movedCells);
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input) {
  std::vector<std::int64_t> all(input.cells->size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
  return findOverlaps(input, all);
}

}  // namespace packmesh
