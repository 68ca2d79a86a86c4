// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The tolerances of geometry and of contacts, each with its unit and reason.
#pragma once

namespace packmesh::tolerance {

/// Relaxation aims at the requested clearance plus this margin [µm]. With 0.02 µm, 0-3 of 10^4 touching pairs
/// still fail the exact test at volume fractions up to 0.50, because sample points bound the distance of
/// facets only up to their sagitta. A smaller margin needs more repair rounds; a larger one lowers the
/// density.
inline constexpr double relaxationMargin = 0.02;

/// Relaxation considers a contact resolved if no sample point penetrates the margin by more than this [µm].
inline constexpr double relaxationTolerance = 0.01;

/// Where the margin is too large, contacts are only resolved to within this [µm]; which pairs need more of it
/// is then measured (packMesh/packing/repairs.h). 0.01 µm between surfaces is 0.8 % of a red cell's
/// volume; with 0.008, a box at 0.62 that takes 10,000 sweeps with 0.015 was not completed in 29,000.
inline constexpr double compactionSlack = 0.015;

/// Added to the clearance of a pair that failed the exact test [µm].
inline constexpr double repairClearance = 0.012;

/// Upper bound of the rounding error of floating-point culling in world coordinates [µm]: coordinates are
/// below 1e5 µm, so errors of their products and sums are below 1e-10 µm.
inline constexpr double culling = 1e-9;

/// Largest coordinate in a mesh file, in the unit of the file: ten times the largest lumen, 1e5 µm, in
/// picometres. Products of six such lengths, as in squares of volumes, are far from overflow, and the exact
/// predicates hold up to 1e90.
inline constexpr double largestCoordinate = 1e12;

/// Vertices on open edges closer than this fraction of the mesh's diagonal are the same vertex, rounded
/// differently: single-precision STL has errors of 6e-8 of the coordinates, sums of a few of them of 1e-6.
inline constexpr double crackFraction = 1e-6;

/// ... and closer than this fraction of the median edge length, because the diagonal is not meaningful if one
/// vertex is far from all others.
inline constexpr double crackEdgeFraction = 1e-2;

/// A vertex whose edges are all longer than this many median edge lengths has a wrong coordinate. Fans that
/// close the ends of finely meshed vessels reach a few hundred.
inline constexpr double outlierEdges = 1e4;

/// In tests of self-intersection, a triangle no higher than this fraction of its longest side is treated as a
/// segment whose points were rounded to single precision (6e-8 of coordinates a hundred times as large as the
/// side).
inline constexpr double sliverFlatness = 1e-5;

/// A closed surface whose volume is below this fraction of its diagonal cubed has no interior: rounding to
/// single precision alone gives a flat surface about 1e-8.
inline constexpr double zeroVolumeFraction = 1e-8;

/// A surface is flat if all of its vertices are this near a plane [of the diagonal of its bounds]: a hundred
/// times the rounding of doubles.
inline constexpr double flatSurfaceFraction = 1e-11;

/// Vertices nearer to each other than this fraction of the median edge may be one: marching cubes make such
/// slivers where the surface passes a node, rounded to single precision.
inline constexpr double nearFraction = 1e-3;

/// Vertices of a flat vessel end lie in one plane up to this fraction of the mesh's diagonal: the error of
/// rounding to single precision and to six printed digits.
inline constexpr double flatCapFraction = 1e-6;

/// A hole in the mesh of a cell is closed if its outline lies in one plane up to this fraction of the mesh's
/// diagonal: what is left of a model where a scanner did not reach, not a missing part of it.
inline constexpr double flatHoleFraction = 0.02;

/// Where parts of a surface touch, each is moved away by this fraction of the distance to its neighbouring
/// vertices: far more than the rounding of a file in single precision, and not visible.
inline constexpr double touchingFraction = 1e-3;

/// The outlines of the two ends of a periodic vessel may differ by this fraction of their diagonal: 0.03 µm
/// for a vessel of 25 µm, which is less than the facets of such meshes deviate from a round wall.
inline constexpr double sameOutlineFraction = 1e-3;

/// Accuracy to which linear programmes with variables and normalised rows of order 1 are solved: a hundred
/// times the rounding error of about thirty pivots in double precision.
inline constexpr double linearProgram = 1e-9;

/// The same for programmes whose rows are in single precision (variables and rows in µm): several times their
/// rounding error, so that a step of zero is always a solution, and far below the padding of planes.
inline constexpr double singlePrecisionProgram = 1e-6;

}  // namespace packmesh::tolerance
