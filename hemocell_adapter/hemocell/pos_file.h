// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file HemoCell's `<Cell>.pos` files.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "packMesh/core/pose.h"

namespace packmesh::hemocell {

/// One line of a .pos file: `x y z a b c`.
struct PosLine {
  Vec3 position = Vec3::Zero();  ///< [µm]
  Vec3 angles = Vec3::Zero();    ///< [degrees] world = Rz(c) Ry(b) Rx(a) v + position
};

/// The map that HemoCell applies to the vertices of the centred template for this line.
Placement placementOf(const PosLine& line);

/// The line that represents a pose of scale 1: its numbers are written as they are, to the last bit. Angles
/// lie in [-180, 180], b in [-90, 90]; at b = ±90, where only a∓c is defined, the pair chosen still maps
/// every vector correctly up to rounding. Pre: finite pose.
PosLine posLineOf(const Pose& pose);

/// The pose represented by a line.
Pose poseOf(const PosLine& line);

/// Text of a .pos file or of a part of it, one line per cell: shortest decimal numbers that read back to the
/// same bits, independent of the locale; single spaces, no trailing space, `\n`. Pre: finite numbers.
std::string formatPosLines(const std::vector<PosLine>& lines);
/// Text before the lines: the number of cells.
std::string formatPosHead(std::int64_t count);

}  // namespace packmesh::hemocell
