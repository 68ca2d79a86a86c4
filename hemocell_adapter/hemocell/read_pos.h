// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Reading of `<Cell>.pos` files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"

namespace packmesh::hemocell {

/// Reads the part of a .pos file that HemoCell reads, strictly: the announced number of lines with exactly
/// six finite numbers each. Further lines are ignored.
/// @param warnings if not null, receives a warning for ignored lines and for everything that HemoCell accepts
/// but other tools do not: tabs, repeated, leading or trailing spaces (pos_to_vtk drops such lines), Windows
/// line ends, blank lines
/// @throws InputError with file and line: missing file, invalid count, fewer lines than announced, comments,
/// extra or missing fields, numbers that are not finite or implausibly large
std::vector<PosLine> readPos(const std::filesystem::path& file, std::vector<std::string>* warnings = nullptr);

/// The cells that one rank has read.
struct PosShare {
  std::vector<PosLine> lines;
  std::int64_t first = 0;  ///< number of the first of them, from 0, among those of the file
  std::int64_t all = 0;    ///< number of cells in the file
};

/// The same for several ranks: each reads about as many bytes as the others, and parses them with its
/// threads. Errors and warnings do not depend on the number of ranks. All ranks call.
/// @throws AgreedFailure on all ranks; InputError if there is a single one
PosShare readPosShare(const std::filesystem::path& file, const Communicator& ranks, const Threads& threads,
                      std::vector<std::string>* warnings = nullptr);

}  // namespace packmesh::hemocell
