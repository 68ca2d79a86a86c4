// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The problem of a command line.
#pragma once

#include <string>
#include <vector>

#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/settings/command_line.h"

namespace packmesh::test {

inline hemocell::Problem planned(const std::vector<std::string>& words,
                                 const std::string& program = "packMesh") {
  return hemocell::problemToPack(hemocell::requestToPack(hemocell::parseCommandLine(program, words).request));
}

}  // namespace packmesh::test
