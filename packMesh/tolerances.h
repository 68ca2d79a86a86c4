// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The home of every tolerance: each with its unit and its reason. Nowhere else stands a bare 1e-x.
#pragma once

namespace packmesh::tolerance {

/// Gap that is kept between membranes when nothing else is asked for [µm]. At 0.02 µm 0-3 of 10^4 touching
/// pairs still meet in the exact test up to a fraction of 0.50, because sample points bound the distance of
/// facets only up to their sagitta; a smaller value costs many rounds of repair, a larger one density.
inline constexpr double defaultClearance = 0.02;

/// Floating-point culling in world coordinates errs by less than this [µm]: coordinates stay below 1e5 µm,
/// so products and sums of them carry errors below 1e-10 µm.
inline constexpr double culling = 1e-9;

}  // namespace packmesh::tolerance
