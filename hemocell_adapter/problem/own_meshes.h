// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Shapes of existing cells that have meshes of their own.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// An existing cell with vertices.
struct OwnMesh {
  PresentCell* cell = nullptr;
  int species = 0;                                   ///< index into Problem::species
  const std::vector<Triangle>* triangles = nullptr;  ///< as the file states them
};

/// What becomes of cells that intersect themselves.
enum class SelfIntersecting {
  keep,     ///< they are to be examined
  undeform  ///< they get the mesh of the template, which is told
};

/// Replaces the vertices of cells by shapes of the problem. Pre: it has those of its species
/// @param file from which they are, for messages
/// @throws InputError if the triangles are not those of the template, or a cell is inside out
void addOwnMeshes(Problem& problem, const std::vector<OwnMesh>& meshes, const std::string& file,
                  SelfIntersecting selfIntersecting);

/// @throws InputError if any of these cells, which are fixed, intersect themselves
void refuseSelfIntersecting(const Problem& problem, const std::vector<PresentCell>& cells, int species,
                            const std::string& file);

}  // namespace packmesh::hemocell
