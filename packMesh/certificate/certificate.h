// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Certificate of a packing: exact predicates on the template meshes, independent of how the packing
/// was made.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "packMesh/core/vector.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/problem/physics.h"

namespace packmesh {

/// Two cells that overlap. `shift` [µm] is added to the second to give the periodic image that meets the
/// first; a cell can meet its own image (first == second).
struct OverlappingPair {
  std::int64_t first = 0, second = 0;
  Vec3 shift = Vec3::Zero();
  bool contained = false;  ///< one is entirely inside the other
  double gap = 0.0;        ///< [µm]; positive for a pair closer than the required gap that does not touch
};

/// A cell that is not entirely inside the lumen, or closer to the wall than required.
struct MisplacedCell {
  std::int64_t cell = 0;
  std::string reason;  ///< "meets the wall", "is 0.05 µm from the wall, less than the required 0.1 µm", ...
  double gap = 0.0;    ///< [µm]; positive for a cell that is inside but too close to the wall
  double required = 0.0;  ///< the gap that it needs, where its own is positive [µm]
};

/// Larger gaps are not measured, unless larger ones are required [µm].
constexpr double usualGapOfInterest = 1.0;

/// Up to where gaps are measured if `required` is the least that is allowed [µm]: beyond it, so that the
/// smallest one is known.
constexpr double measuredUpTo(double required) {
  return std::max(usualGapOfInterest, 1.5 * required);
}

/// A cell with a mesh of its own that intersects itself; no packing can cure it.
struct SelfIntersectingCell {
  std::int64_t cell = 0;
  int first = 0, second = 0;  ///< triangles that meet; the same one if it has no area
};

struct Certificate {
  std::int64_t cells = 0;
  std::int64_t pairsTested = 0;  ///< pairs whose bounding spheres are closer than the required gap
  std::vector<OverlappingPair> overlapping;
  std::vector<MisplacedCell> misplaced;
  std::vector<SelfIntersectingCell> selfIntersecting;
  /// Smallest gap between two membranes [µm]: exact up to the largest gap measured, infinity if no pair is
  /// closer, 0 if any pair overlaps.
  double minimumGap = std::numeric_limits<double>::infinity();
  /// Smallest gap between membrane and wall [µm], likewise; 0 if any cell is not inside the lumen.
  double minimumWallGap = std::numeric_limits<double>::infinity();
  double gapsMeasuredUpTo = usualGapOfInterest, wallGapsMeasuredUpTo = usualGapOfInterest;  ///< [µm]
  /// Cells that were permitted to be closer to others or to the wall than required, and are; they meet
  /// nothing.
  std::int64_t closer = 0;
  double cellVolume = 0.0;  ///< total volume of all meshes [µm³]
  bool complete = true;     ///< false: stopped early, nothing is proven
  /// True if so many pairs overlap that only some of them are listed: see LimitedSearch.
  bool moreOverlaps = false;

  bool clean() const {
    return complete && overlapping.empty() && misplaced.empty() && selfIntersecting.empty();
  }
};

/// Sorts by first, second and shift.
void sortByCells(std::vector<OverlappingPair>& pairs);

/// Combines the certificates of all ranks. Collective.
/// @param numbers global number of each local cell; the result refers to cells by them and is sorted by them
Certificate ofAllRanks(const Certificate& own, const std::vector<std::int64_t>& numbers,
                       const Communicator& communicator);

/// Input of the certificate. Holds references only.
struct CertificateInput {
  std::vector<const Shape*> shapes;  ///< Physics::shapes
  std::vector<const Wall*> walls;    ///< per species; nullptr: no wall
  const Container* container = nullptr;
  const std::vector<PlacedCell>* cells = nullptr;
  double requiredGap = 0.0;               ///< pairs with a smaller gap count as overlapping [µm]
  double requiredWallGap = 0.0;           ///< cells closer to their wall count as misplaced [µm]
  std::vector<double> extraWallGap = {};  ///< per species, added to requiredWallGap [µm]; empty: 0
  double largestGap = usualGapOfInterest,
         largestWallGap = usualGapOfInterest;  ///< larger ones are not measured [µm]

  double wallGapOf(int species) const {
    return requiredWallGap + (extraWallGap.empty() ? 0.0 : extraWallGap[species]);
  }
  /// True for the cells to certify; the others, copies of cells certified by other ranks, only occur as
  /// second cell of pairs. nullptr: all.
  const std::vector<bool>* own = nullptr;
  /// Polled by the calling thread between cells; true stops. Empty: never.
  std::function<bool()> stop = {};
  bool upToFirstFault = false;  ///< stop at the first cell with a violation
  Threads threads = {};         ///< that share the work of this rank
};

/// The cells of a packing and what is required of them. References both arguments.
CertificateInput certificateInputOf(const Physics& physics, const std::vector<PlacedCell>& cells,
                                    const Threads& threads = {});

}  // namespace packmesh
