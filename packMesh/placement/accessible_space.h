// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Where in a lumen a cell can be.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "packMesh/core/pose.h"
#include "packMesh/problem/execution.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

class CellFit;

/// Where the centre of a cell of full size can be with some orientation, alone in the lumen: a sparse set of
/// boxes, large in the middle of wide parts, where a cell fits in any orientation, and small elsewhere, where
/// some dozen orientations are tried with points of its surface and interpolated distances. It depends on the
/// physics alone. Immutable; threads can share it.
class AccessibleSpace {
 public:
  static constexpr std::size_t mostPartsOfSpace = 3000000;

  /// A box of the space [µm].
  struct Part {
    Vec3 centre;
    Vec3f half;                ///< of its edges
    std::int16_t orientation;  ///< one in which the cell fits at the centre; negative: any, or not complete()

    double volume() const { return 8.0 * half.cast<double>().prod(); }  ///< [µm³]
  };

  /// Within the freedom of the species, that is, its region, cone, cell-free layer and clearance of its own.
  /// References the walls and the region of `physics`, which must outlive it. Pre: the species has a wall
  /// @param mostParts above which they are divided no further
  AccessibleSpace(const Physics& physics, int species, const Threads& threads,
                  std::size_t mostParts = mostPartsOfSpace);
  enum class Points {
    exact,    ///< by distances that are not interpolated, so that walls as thin as the smallest parts count
    covered,  ///< in larger boxes, which contain all of them and reach beyond the wall: not complete()
  };
  /// Where points of a lumen are. Pre: it has a wall, and outlives this
  AccessibleSpace(const Container& container, const Threads& threads, Points points);
  ~AccessibleSpace();

  /// Successive parts are near each other.
  const std::vector<Part>& parts() const { return parts_; }
  /// The sizes that parts can have, as Part::half, descending: those of each level of a grid, which begins at
  /// the low corner of the bounds of the lumen, or of the region [µm].
  const std::vector<Vec3f>& levels() const { return levels_; }
  /// Whether cells fit in all parts; false: parts are too coarse to tell, as in very large lumens, and cells
  /// may fit in some of them.
  bool complete() const { return complete_; }
  double volume() const { return ends_.empty() ? 0.0 : ends_.back(); }  ///< [µm³]

  /// The volumes of its connected components over its own, descending. Boxes with a common face are
  /// connected.
  std::vector<double> apart() const;

  /// A cell that fits with this centre, in this orientation or one of those tried; empty: none.
  std::optional<Pose> fitting(const Vec3& centre, const Quaternion& wanted) const;

  /// A pose of a cell that fits (or, if not complete(), may fit): its centre uniform over the space for a
  /// uniform number `at`, and near others for similar ones; its orientation as given where that fits.
  /// Pre: volume() > 0
  /// @param within three uniform numbers, for the place within a part
  Pose pose(double at, const std::array<double, 4>& within, const Quaternion& wanted) const;

 private:
  /// @param covers parts that are neither outside nor inside are kept as they are
  void find(const Box& room, const Threads& threads, std::size_t mostParts, bool covers = false);

  std::unique_ptr<const CellFit> fit_;
  std::vector<Part> parts_;
  std::vector<Vec3f> levels_;
  bool complete_ = true;
  std::vector<double> ends_;  ///< sums of their volumes [µm³]
};

/// The spaces of the species of a problem, each made when it is first needed.
class AccessibleSpaces {
 public:
  /// References `physics`, which must outlive it.
  AccessibleSpaces(const Physics& physics, const Threads& threads);

  /// nullptr: the species has no wall, or one in closed form, or has no space at all. Not from within a loop
  /// of threads.
  const AccessibleSpace* of(int species);

 private:
  const Physics& physics_;
  Threads threads_;
  std::vector<std::unique_ptr<const AccessibleSpace>> made_;
};

}  // namespace packmesh
