// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the program refuses, without starting it.
#pragma once

#include <filesystem>
#include <functional>
#include <iomanip>
#include <sstream>
#include <string>
#include <vector>

#include "hemocell_adapter/app/run.h"
#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/state_files.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/input_file.h"
#include "tests/hemocell_adapter/sample_case.h"
#include "tests/support/catch.h"

namespace packmesh::test {

struct Refusal {
  int exitCode = 0;
  std::string message;
};

/// What the program says of arguments in this folder, where it packs or checks what it does not refuse.
/// @param arguments separated by spaces; 'with quotes' as one
inline Refusal refused(const std::filesystem::path& folder, const std::string& arguments,
                       const std::string& program = "packMesh") {
  using namespace hemocell;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  log::setLevel(log::Level::silent);
  std::istringstream text(arguments);
  std::vector<std::string> words;
  for (std::string word; text >> std::quoted(word, '\'');) words.push_back(word);
  Failure failure{ExitCode::ok, {}};
  try {
    const InputRecord inputs;
    const CommandLine line = parseCommandLine(program, words);
    failure.code = line.command == Command::check ? runCheck(line.request, Communicator())
                                                  : runPacking(continued(line.request), Communicator());
  } catch (...) {
    failure = failureOfException();
  }
  log::setLevel(log::Level::normal);
  std::filesystem::current_path(before);
  return {int(failure.code), inTermsOfUser(failure.message)};
}

struct RefusedRow {
  std::string arguments;
  int exitCode;
  std::string message;  ///< part of it
  std::function<void(const std::filesystem::path& folder)> spoil = [](const std::filesystem::path&) {};
};

/// Requires that each is refused in this folder, and nothing written.
inline void requireRefused(const TemporaryFolder& folder, const std::vector<RefusedRow>& rows) {
  for (const RefusedRow& row : rows) {
    row.spoil(folder.path());
    const int before = folder.files();
    const Refusal refusal = refused(folder.path(), row.arguments);
    INFO("packMesh " << row.arguments.substr(0, 300) << "\n" << refusal.message.substr(0, 2000));
    CHECK(refusal.exitCode == row.exitCode);
    CHECK_THAT(refusal.message, Contains(row.message));
    CHECK(folder.files() == before);
  }
}

/// The same of a case for each of them.
inline void requireRefused(const std::vector<RefusedRow>& rows) {
  for (const RefusedRow& row : rows) requireRefused(SampleCase(), {row});
}

}  // namespace packmesh::test
