// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Certificates of given cells.
#pragma once

#include <vector>

#include "packMesh/certificate/certificate_input.h"

namespace packmesh {

/// Examines every pair of cells that could meet (periodic images included) and every cell against its wall.
///
/// Overlap is decided by exact predicates on the world vertices `placement(v)` of the template meshes:
/// triangles are closed sets, so meshes that share a single point overlap; a mesh inside another one overlaps
/// it, too.
/// Results are sorted by cell. Memory: about 130 bytes per cell; meshes are placed one at a time.
Certificate certify(const CertificateInput& input);

/// The same, but no gaps larger than `largestGap` are measured [µm].
Certificate certify(CertificateInput input, double largestGap);

/// The overlapping pairs that contain at least one of `movedCells` (each once), sorted by cell; without gaps
/// and walls. For stages that move a few cells at a time: all other pairs are unchanged.
std::vector<OverlappingPair> findOverlaps(const CertificateInput& input,
                                          const std::vector<std::int64_t>& movedCells);

/// All overlapping pairs.
std::vector<OverlappingPair> findOverlaps(const CertificateInput& input);

}  // namespace packmesh
