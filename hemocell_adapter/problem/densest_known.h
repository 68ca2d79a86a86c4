// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The densest known packings of cells.
#pragma once

#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// Refuses requests that are denser than every known packing of such cells, ordered ones included.
///
/// - Ellipsoids, platelets and white cells: 0.7707, the densest known packing of ellipsoids of any kind
///   (Donev, Stillinger, Chaikin, Torquato: Phys. Rev. Lett. 92, 255506, 2004; equal spheres reach 0.7405).
/// - Red cells of HemoCell's formula: 0.748, a crystal of these meshes (config/crystals/red_cells_2.json); a
///   bound is not known.
/// - For other meshes nothing is known, and nothing is refused.
///
/// A few cells can fill a lumen that matches their shape: lumens with walls are only judged if there are
/// many.
/// @throws InputError
void refuseBeyondKnown(const Problem& problem);

}  // namespace packmesh::hemocell
