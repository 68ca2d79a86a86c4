// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a run leaves behind besides the cells' files: scenes, VTK files, reports.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/output/finished.h"

namespace packmesh::hemocell {

/// Fails before hours of packing rather than after them. One rank calls it.
/// @throws OutputError when a file or folder that the job will write cannot be written
void requireWritableOutputs(const Scene& scene);
void requireWritable(const std::filesystem::path& folder);

/// What writeViews() writes, in the order of writing.
std::vector<std::filesystem::path> viewFiles(const Scene& scene);

/// Warns of .pos files that HemoCell would load together with the new ones.
void warnOfStaleFiles(const Scene& scene);

/// Writes what the job asks for besides: scene for POV-Ray, VTK files, reports; tells which.
/// All ranks call. @throws AgreedFailure
void writeViews(const Finished& done, const RunTimes& times);

}  // namespace packmesh::hemocell
