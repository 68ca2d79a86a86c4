// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Names of the folders that realisations lie in.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace packmesh::hemocell {

/// "realisation_03", with as many digits as the number of realisations has. @param i from 1 on
std::string realisationFolder(std::int64_t i, std::int64_t realisations);

/// The folders of realisations in `folder`, ordered by their numbers, then names.
std::vector<std::filesystem::path> realisationFoldersIn(const std::filesystem::path& folder);

/// Where a state file lies, seen from the folder of all realisations.
struct PlaceInSeries {
  std::int64_t realisation = 0;
  std::filesystem::path seriesFolder;  ///< relative to the working directory, if it can be
};
/// Empty when the state does not lie in the folder of one of so many realisations (empty: of any number).
std::optional<PlaceInSeries> placeInSeries(const std::filesystem::path& state,
                                           std::optional<std::int64_t> realisations);

}  // namespace packmesh::hemocell
