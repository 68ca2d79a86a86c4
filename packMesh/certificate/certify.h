// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Certificates of cells, made at once.
#pragma once

#include <vector>

#include "packMesh/certificate/certificate.h"

namespace packmesh {

/// Examines every pair of cells that could meet (periodic images included) and every cell against its wall.
///
/// Overlap is decided by exact predicates on the world vertices `placement(v)` of the template meshes: closed
/// triangles that share a single point already meet, and a mesh inside another one meets it.
/// Reports are ordered by cells. Memory: some 130 bytes per cell; meshes are placed one at a time.
/// @param largestGap gaps above this are not measured [µm]
Certificate certify(const CertificateInput& input, double largestGap = gapOfInterest);

/// The overlapping pairs among those with at least one of `movedCells`, ordered by cells; no gaps, no walls.
/// For stages that move a few cells at a time: pairs of cells that stayed keep the verdict they had.
std::vector<OverlappingPair> findOverlaps(const CertificateInput& input,
                                          const std::vector<std::int64_t>& movedCells);

/// All overlapping pairs.
std::vector<OverlappingPair> findOverlaps(const CertificateInput& input);

}  // namespace packmesh
