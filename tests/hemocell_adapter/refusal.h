// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the program refuses before it packs, without starting it.
#pragma once

#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/output/output_plan.h"
#include "hemocell_adapter/output/outputs.h"
#include "hemocell_adapter/problem/make_problem.h"
#include "hemocell_adapter/session/session.h"
#include "hemocell_adapter/settings/command_line.h"
#include "packMesh/core/input_file.h"
#include "packMesh/packing/pack.h"

namespace packmesh::test {

struct Refusal {
  int exitCode = 0;
  std::string message;
};

/// What the program says of arguments, separated by spaces, in this folder, where it prepares a packing; exit
/// code 0 if it would pack.
inline Refusal refused(const std::filesystem::path& folder, const std::string& arguments) {
  using namespace hemocell;
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder);
  log::setLevel(log::Level::silent);
  std::istringstream text(arguments);
  std::vector<std::string> words;
  for (std::string word; text >> word;) words.push_back(word);
  Failure failure{ExitCode::ok, {}};
  try {
    const InputRecord inputs;
    const CompletedRequest completed = requestToPack(parseCommandLine("packMesh", words).request);
    const OutputRequest output = outputsToPack(completed);
    const Communicator ranks;
    Session session(writtenToFiles, {}, ranks);
    const std::shared_ptr<const Problem> problem = session.prepare(completed);
    requireWritableOutputs(*problem, output, true);
    validate(packingProblemOf(*problem, problem->atDemanded));
  } catch (const AgreedFailure& agreed) {
    failure = {agreed.code(), agreed.what()};
  } catch (const std::exception&) {
    failure = failureOfException();
  }
  log::setLevel(log::Level::normal);
  std::filesystem::current_path(before);
  return {int(failure.code), inTermsOfUser(failure.message)};
}

}  // namespace packmesh::test
