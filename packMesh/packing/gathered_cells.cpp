// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/gathered_cells.h"

namespace packmesh {

std::vector<PlacedCell> gatheredCells(const std::vector<PlacedCell>& own, const Communicator& ranks) {
  if (ranks.alone()) return own;
  struct Plain {
    int species;
    double linear[9], translation[3];
  };
  std::vector<Plain> plain;
  for (const PlacedCell& cell : own) {
    Plain p{};
    p.species = cell.species;
    Eigen::Map<Mat3>(p.linear) = cell.placement.linear;
    Eigen::Map<Vec3>(p.translation) = cell.placement.translation;
    plain.push_back(p);
  }
  std::vector<PlacedCell> all;
  for (const Plain& p : ranks.gatherAll(plain)) {
    PlacedCell cell{p.species, {}};
    cell.placement.linear = Eigen::Map<const Mat3>(p.linear);
    cell.placement.translation = Eigen::Map<const Vec3>(p.translation);
    all.push_back(cell);
  }
  return all;
}

}  // namespace packmesh
