// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The exact test of existing cells.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// The cells of all files, species by species. Each rank has an equal share, in the order of the ranks.
struct FoundCells {
  std::vector<PlacedCell> cells;
  std::vector<Pose> poses;
  std::vector<PosLine> lines;        ///< as read
  std::int64_t all = 0;              ///< of all ranks
  std::vector<std::int64_t> counts;  ///< of all ranks, per species
  std::vector<double> excess;        ///< of all ranks, see excessVolumes() [µm³]
  Loading loading = Loading::posFiles;

  /// Species of a cell, given its number, and its number within the species.
  struct Place {
    int species;
    std::int64_t index;
  };
  Place placeOf(std::int64_t cell) const;
};

/// Reads the .pos files of a problem that is to be checked, or the cells of its states. All ranks call.
/// @throws InputError; AgreedFailure if there are several ranks
FoundCells readCells(const Problem& problem);

/// The number of overlapping pairs at which the search among so many cells ends.
std::int64_t mostOverlaps(std::int64_t cells);

/// What was found in the cells of all ranks: whether they overlap, are in the lumen, and are kept by
/// HemoCell.
struct Examination {
  Certificate certificate;
  std::int64_t overlaps = 0;  ///< pairs that overlap; at least so many if not all are listed
  std::int64_t cells = 0;
  struct Dropped {
    std::int64_t cell;
    std::int64_t reason;  ///< index into `reasons`
  };
  std::vector<Dropped> dropped;      ///< cells that HemoCell does not keep, in ascending order
  std::vector<std::string> reasons;  ///< why, in the order in which they occur
  std::vector<double> excess;        ///< of the cells that it keeps, see excessVolumes() [µm³]

  bool keeps(std::int64_t cell) const;
  /// Whether nothing is wrong. Cells that only cross a periodic face are deleted as expected.
  bool clean() const {
    return certificate.clean() && std::all_of(reasons.begin(), reasons.end(), isExpected);
  }
};

/// Tests cells against the clearances that the problem demands: each rank those in a part of the lumen. The
/// result is the same on all ranks, and on any number of them. If more pairs overlap than mostOverlaps(), the
/// certificate lists only a few of them, so time and memory grow linearly with the cells. All ranks call.
/// @param own cells of this rank, numbered in rank order
/// @param loading how HemoCell gets them
/// @param kept clearances that the packing kept, where these are wider: gaps are measured up to beyond them
/// @throws InputError; AgreedFailure if there are several ranks
Examination examine(const Problem& problem, const std::vector<PlacedCell>& own, Loading loading,
                    const Clearances& kept = {});

}  // namespace packmesh::hemocell
