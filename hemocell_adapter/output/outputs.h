// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What a run leaves behind besides the cells' files: scenes, VTK files, reports.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hemocell_adapter/output/summary.h"
#include "hemocell_adapter/problem/scene.h"
#include "packMesh/packing/packing_result.h"

namespace packmesh::hemocell {

/// A packing that was made and then repeated in a larger box.
struct Repeated {
  const Job& job;
  const PackingResult& result;
};

/// A packing that is done, certified and counted. References what it is made of.
struct Finished {
  const Job& job;
  const Scene& scene;
  const PackingResult& result;
  const Tally& tally;
  const Kept& kept;
  const Communicator& ranks;
  const Repeated* repeated = nullptr;  ///< what it consists of
};

/// Fails before hours of packing rather than after them. One rank calls it.
/// @throws OutputError when a file or folder that the job will write cannot be written
void requireWritableOutputs(const Job& job, const Scene& scene);
void requireWritable(const std::filesystem::path& folder);

/// What writeViews() writes, in the order of writing.
std::vector<std::filesystem::path> viewFiles(const Job& job, const Scene& scene);

/// Warns of .pos files that HemoCell would load together with the new ones.
void warnOfStaleFiles(const Job& job, const Scene& scene);

/// Writes what the job asks for besides: scene for POV-Ray, VTK files, reports; tells which.
/// All ranks call. @throws AgreedFailure
void writeViews(const Finished& done, const RunTimes& times);

}  // namespace packmesh::hemocell
