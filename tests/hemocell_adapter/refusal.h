// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the program refuses.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tests/hemocell_adapter/sample_case.h"

namespace packmesh::test {

struct RefusedRow {
  std::string arguments;
  int exitCode;
  std::string message;  ///< part of it
  std::function<void(const std::filesystem::path& folder)> spoil = [](const std::filesystem::path&) {};
};

/// Requires that each is refused in this folder, and nothing written.
void requireRefused(const TemporaryFolder& folder, const std::vector<RefusedRow>& rows);

/// The same of a case for each of them.
void requireRefused(const std::vector<RefusedRow>& rows);

}  // namespace packmesh::test
