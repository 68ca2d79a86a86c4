// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/certificate/certify.h"

#include "packMesh/certificate/certifier.h"
#include "packMesh/parallel/per_thread.h"

namespace packmesh {
namespace {

/// Cells that a thread examines at a time.
constexpr std::int64_t cellsPerPart = 64;

}  // namespace

Certificate certify(const CertificateInput& input, double largestGap) {
  return Certifier(input, largestGap).certificate();
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input,
                                          const std::vector<std::int64_t>& movedCells) {
  const CertifiedCells cells(input);
  const PeriodicNeighbors neighbors = cells.neighbors();
  std::vector<bool> moved(cells.count(), false);
  for (std::int64_t i : movedCells) moved[i] = true;
  PerThread<std::vector<OverlappingPair>> found(input.threads);
  const auto examine = [&](std::int64_t i, std::vector<OverlappingPair>& faults) {
    neighbors.forEachNear(i, input.requiredGap, false, [&](const NearPair& pair) {
      const std::int64_t other = pair.first == i ? pair.second : pair.first;
      if (other < i && moved[other]) return;  // already examined from the other cell
      if (!cells.isOwn(i) && !cells.isOwn(other)) return;
      const MeshPairResult result = cells.relation(pair, input.requiredGap);
      if (const auto fault = cells.faultOf(pair, result)) faults.push_back(*fault);
    });
  };
  input.threads.forEachPart(
      static_cast<std::int64_t>(movedCells.size()),
      [&](std::int64_t begin, std::int64_t end, int thread) {
        for (std::int64_t k = begin; k < end; ++k) examine(movedCells[k], found[thread]);
      },
      cellsPerPart);
  std::vector<OverlappingPair> out;
  found.forEach([&](const auto& faults) { out.insert(out.end(), faults.begin(), faults.end()); });
  sortByCells(out);
  return out;
}

std::vector<OverlappingPair> findOverlaps(const CertificateInput& input) {
  std::vector<std::int64_t> all(input.cells->size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
  return findOverlaps(input, all);
}

}  // namespace packmesh
