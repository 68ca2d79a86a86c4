// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Names of the folders of realisations.
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

/// Position of a state file relative to the folder of all realisations.
struct PlaceInSeries {
  std::int64_t realisation = 0;
  std::filesystem::path seriesFolder;  ///< relative to the working directory, if it can be
};
/// Empty if the state is not in the folder of one of this many realisations (empty: of any number).
std::optional<PlaceInSeries> placeInSeries(const std::filesystem::path& state,
                                           std::optional<std::int64_t> realisations);

}  // namespace packmesh::hemocell
