// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Placed cells in the formats of other programs.
#pragma once

#include <vector>

#include "hemocell_adapter/output/exports/exported_file.h"
#include "hemocell_adapter/problem/problem.h"

namespace packmesh::hemocell {

/// The files of these formats (exportFormats; formats.h describes them), each once.
///
/// References the problem. @param counts of its species, all ranks together
/// @throws InputError if the other program cannot have these cells, or not there
std::vector<ExportedFile> exportedFiles(const Problem& problem, const std::vector<std::string>& formats,
                                        const std::vector<std::int64_t>& counts);

}  // namespace packmesh::hemocell
