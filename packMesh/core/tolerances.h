// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The home of every tolerance: each with its unit and its reason. Nowhere else stands a bare 1e-x.
#pragma once

namespace packmesh::tolerance {

/// Relaxation aims at this much more than the clearance asked for [µm]: at 0.02 µm 0-3 of 10^4 touching pairs
/// still meet in the exact test up to a fraction of 0.50, because sample points bound the distance of facets
/// only up to their sagitta; a smaller margin costs rounds of repair, a larger one density.
inline constexpr double relaxationMargin = 0.02;

/// A relaxation has resolved a contact when no sample point is deeper in the margin than this [µm].
inline constexpr double relaxationTolerance = 0.01;

/// What a pair that failed the exact test is given on top of its clearance [µm].
inline constexpr double repairClearance = 0.012;

/// Floating-point culling in world coordinates errs by less than this [µm]: coordinates stay below 1e5 µm,
/// so products and sums of them carry errors below 1e-10 µm.
inline constexpr double culling = 1e-9;

/// Vertices along open edges that are nearer than this fraction of a mesh's diagonal are one vertex that was
/// rounded differently: STL in single precision errs by 6e-8 of the coordinates, sums of a few such by 1e-6.
inline constexpr double crackFraction = 1e-6;

/// ... and nearer than this fraction of the median edge: the diagonal alone says nothing where one vertex is
/// far away from all others.
inline constexpr double crackEdgeFraction = 1e-2;

/// A vertex all of whose edges are longer than so many median edges has a wrong coordinate: fans that close
/// the ends of finely meshed vessels reach a few hundred.
inline constexpr double outlierEdges = 1e4;

/// Triangles no higher than this fraction of their longest side are taken for segments whose points were
/// rounded to single precision (6e-8 of coordinates that are a hundred times such a side), where a surface
/// meets itself.
inline constexpr double sliverFlatness = 1e-5;

/// A closed surface with less volume than this fraction of the cube of its diagonal encloses nothing:
/// rounding of single-precision coordinates alone gives a flat surface about 1e-8.
inline constexpr double zeroVolumeFraction = 1e-8;

/// Vertices of a vessel's flat end lie within this fraction of the mesh's diagonal of one plane: what
/// rounding to single precision and six printed digits leave.
inline constexpr double flatCapFraction = 1e-6;

/// The outlines of the two ends of a periodic vessel may differ by this fraction of their diagonal: 0.03 µm
/// for a vessel of 25 µm, less than the facets of such meshes deviate from a round wall.
inline constexpr double sameOutlineFraction = 1e-3;

/// Linear programmes in variables and normalised rows of order 1 are solved to this: a hundred times what
/// some thirty pivots in double precision leave.
inline constexpr double linearProgram = 1e-9;

}  // namespace packmesh::tolerance
