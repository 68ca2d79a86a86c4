// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Surfaces and their sample points as kernels use them.
#pragma once

namespace packmesh {

struct SamplePoints;

/// The surface of a cell as kernels use it, in its body frame.
struct FieldView {
  bool onGrid;
  // Closed form y² = P(a x² + c z²) (ProfileSurface).
  float p[6], a, c;
  float bend;       ///< beyond the rim P(s) = P'(1) (s - 1) + bend (s - 1)² [µm²]
  float curvature;  ///< ProfileSurface::curvatureInside(), at least 1
  // Sampled distance (DistanceGrid).
  const float* value;
  float origin[3], nodesPerLength;
  int nodes[3];
  // Disc + ellipsoid bound (SupportBound) and half extents: points outside of them are certainly apart.
  float ring, thickness, extent[3];
};

/// Sample points of a cell (SamplePoints).
struct SampleView {
  int clusters;
  int bitShift;  ///< cluster k is bit k >> bitShift of 64 that stand for all clusters
  const float *x, *y, *z;
  const float *centerX, *centerY, *centerZ, *radius;
};

/// Map from the sampled cell's body frame to the other's: x -> m x + t; `scale` is the factor of m.
struct RelativeFrame {
  float m[9], t[3], scale;
};

/// What finds the contacts of a cell.
struct ContactViews {
  SampleView samples, coarseSamples;
  FieldView field;
};

/// References the points, which must outlive the view.
SampleView viewOf(const SamplePoints& points);

}  // namespace packmesh
