// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Writing a file on several ranks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "packMesh/io/atomic_files.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh {

class Hdf5Writer;

/// Every rank does `work`, which may communicate. Collective.
/// @throws OutputError on all ranks if it does on one
void writeTogether(const Communicator& ranks, const std::function<void()>& work);

/// Writes an HDF5 file; every rank calls `content` with the same file. Collective.
/// @param userBlock see Hdf5Writer
/// @return on the first rank the file, complete under its temporary name: to be ended and committed, or to be
/// removed with the object
/// @throws OutputError on all ranks
std::unique_ptr<AtomicFiles> writtenHdf5(const std::filesystem::path& file, const Communicator& ranks,
                                         std::uint64_t userBlock,
                                         const std::function<void(Hdf5Writer&)>& content);

/// Gives a file that was written under a temporary name its own. All ranks call.
/// @throws OutputError on all ranks if that fails
void commitTogether(std::unique_ptr<AtomicFiles> files, const Communicator& ranks);

}  // namespace packmesh
