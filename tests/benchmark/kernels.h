// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Time of the kernels by themselves, by google-benchmark.
#pragma once

#include <nlohmann/json.hpp>

namespace packmesh::benchmark {

/// Runs all of them, prints a table in Markdown and returns its rows.
nlohmann::ordered_json runKernels();

}  // namespace packmesh::benchmark
