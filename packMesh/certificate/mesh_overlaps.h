// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The exact test of cells that each have a mesh of their own, such as the deformed cells of a
/// simulation.
#pragma once

#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/mesh/triangle_mesh.h"
#include "packMesh/parallel/threads.h"

namespace packmesh {

/// All pairs of meshes that overlap, in ascending order, with first < second and without shifts and gaps.
///
/// Overlap is decided as in certify(), by exact predicates on the vertices: triangles are closed sets, and a
/// mesh inside another one overlaps it, too. Only triangles where the boxes of two meshes have a common part
/// are tested, without a hierarchy, whose construction takes longer than the few tests of one mesh. Not
/// periodic: images are meshes of the list.
/// Pre: the meshes are closed, connected, outward, of finite vertices. If one intersects itself, whether
/// others are inside it is decided by the number of crossings of a ray.
std::vector<OverlappingPair> findMeshOverlaps(const std::vector<TriangleMesh>& meshes,
                                              const Threads& threads = {});

}  // namespace packmesh
