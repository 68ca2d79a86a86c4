// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The proof that a packing is one: exact predicates over the template meshes, independent of how the
/// packing was made.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "packMesh/container/container.h"
#include "packMesh/core/pose.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// One cell as it is written: which species, where.
struct PlacedCell {
  int species = 0;
  Placement placement;
};

/// Two cells that meet. `shift` is added to the second to meet the first (periodic images); a cell can meet
/// its own image (first == second).
struct OverlappingPair {
  std::int64_t first = 0, second = 0;
  Vec3 shift = Vec3::Zero();
  bool contained = false;  ///< one lies wholly inside the other
  double gap = 0.0;        ///< [µm]; positive for a pair that is apart, but by less than the required gap
};

/// A cell that is not (wholly) inside the lumen, or nearer to the wall than required.
struct MisplacedCell {
  std::int64_t cell = 0;
  std::string reason;  ///< "meets the wall", "is 0.05 µm from the wall, less than the 0.1 µm asked for", ...
  double gap = 0.0;    ///< [µm]; positive for a cell that is inside, but too near to the wall
};

struct Certificate {
  std::int64_t cells = 0;
  std::int64_t pairsTested = 0;  ///< pairs that need a proof: whose bounding spheres are nearer than required
  std::vector<OverlappingPair> overlapping;
  std::vector<MisplacedCell> misplaced;
  /// Smallest gap between two membranes [µm], exact below the largest to be measured; infinity when no pair
  /// is nearer, 0 when any overlap.
  double minimumGap = std::numeric_limits<double>::infinity();
  /// Smallest gap between membrane and wall [µm], likewise; 0 when any cell is not inside the lumen.
  double minimumWallGap = std::numeric_limits<double>::infinity();
  double cellVolume = 0.0;  ///< volume of all meshes [µm³]
  bool complete = true;     ///< false: it was stopped, and nothing is proven
  /// There may be more overlapping pairs than those listed: see CertificateInput::mostOverlaps.
  bool moreOverlaps = false;

  bool clean() const { return complete && overlapping.empty() && misplaced.empty(); }
};

/// What is certified. Everything is referenced, nothing is copied.
struct CertificateInput {
  std::vector<const Shape*> shapes;  ///< per species
  std::vector<const Wall*> walls;    ///< per species; nullptr: no wall
  const Container* container = nullptr;
  const std::vector<PlacedCell>* cells = nullptr;
  double requiredGap = 0.0;               ///< pairs with a smaller gap count as overlapping [µm]
  double requiredWallGap = 0.0;           ///< cells nearer to their wall count as misplaced [µm]
  std::vector<double> extraWallGap = {};  ///< per species, on top of that [µm]; empty: none

  double wallGapOf(int species) const {
    return requiredWallGap + (extraWallGap.empty() ? 0.0 : extraWallGap[species]);
  }
  /// Which cells are to be certified; the others are there for the pairs in which they come second: copies of
  /// cells that another rank answers for. nullptr: all.
  const std::vector<bool>* own = nullptr;
  /// Polled before each cell; true gives up. Empty: never.
  std::function<bool()> stop = {};
  /// With so many overlapping pairs found, those of further cells are not looked for: where all cells
  /// overlap, their number is the square of that of the cells.
  std::int64_t mostOverlaps = std::numeric_limits<std::int64_t>::max();
  bool upToFirstFault = false;  ///< gives up at the first cell at fault
};

/// Gaps above this are not measured unless asked for [µm].
constexpr double gapOfInterest = 1.0;

/// By first, second and shift.
void sortByCells(std::vector<OverlappingPair>& pairs);

/// The certificates of all ranks in one; all ranks call.
/// @param numbers what the cells are called all over: faults of the result name them so, ordered by them
Certificate ofAllRanks(const Certificate& own, const std::vector<std::int64_t>& numbers,
                       const Communicator& communicator);

}  // namespace packmesh
