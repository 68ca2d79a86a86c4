// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The exact test of cells that exist: whether they overlap, are in the lumen, and are kept by
/// HemoCell.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "hemocell_adapter/output/packing.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/problem.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Tests cells against the clearances that the problem demands: each rank those in a part of the lumen. The
/// result is the same on all ranks, and on any number of them. If more pairs overlap than mostOverlaps(), the
/// certificate lists only a few of them, so time and memory grow linearly with the cells. All ranks call.
/// @param own cells of this rank, numbered in rank order
/// @param kept clearances that the packing kept, where these are wider: gaps are measured up to beyond them
/// @throws InputError; AgreedFailure if there are several ranks
Certificate examine(const Problem& problem, const std::vector<PlacedCell>& own, const Clearances& kept = {});

/// A packing with the numbers of its cells on all ranks. All ranks call.
Packing withTally(Packing packing);

/// What HemoCell keeps of cells, the same on all ranks. All ranks call.
/// @param own as above @param loading how HemoCell gets them
Kept findKept(const Problem& problem, const std::vector<PlacedCell>& own, Loading loading);

/// How cells are checked.
struct CheckHooks {
  std::function<void(const Problem&)> made = {};  ///< called before their files are read
  std::function<void()> poll = {};  ///< while the problem is made; what it throws ends that (PollScope)
  bool asRead = false;              ///< the lines of .pos files are kept, for outputs
};

/// The cells of .pos files or, if the request starts from states, of these, with everything that is found in
/// them. Program, plug-in and Python check cells by this function. All ranks call.
/// @param folder of the .pos files
/// @throws InputError; AgreedFailure if there are several ranks
Packing check(const CompletedRequest& completed, const std::filesystem::path& folder,
              const Communicator& ranks, const CheckHooks& hooks = {});

/// Whether nothing is wrong. Cells that only cross a periodic face are deleted as expected.
bool isClean(const Certificate& certificate, const Kept& kept);

/// The number of overlapping pairs at which the search among so many cells ends.
std::int64_t mostOverlaps(std::int64_t cells);

/// Pairs of a check that overlap; at least so many if not all are listed.
std::int64_t countOverlaps(const Packing& checked);

/// Species of a cell, given its number, and its number within the species.
struct NumberInSpecies {
  int species;
  std::int64_t index;
};
NumberInSpecies findInSpecies(const Packing& packing, std::int64_t cell);

}  // namespace packmesh::hemocell
