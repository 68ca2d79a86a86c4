// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Exit codes of the program.
#pragma once

#include <stdexcept>
#include <string>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {

enum class ExitCode {
  ok = 0,
  usage = 1,
  badInput = 2,
  outOfReach = 3,
  faultsFound = 4,
  cannotWrite = 5,
  notConnected = 6,
  internal = 70,
  interrupted = 130,
};

/// Meaning of an exit code, as printed by `--help` and in the README.
struct ExitCodeMeaning {
  ExitCode code;
  const char* text;
};
inline constexpr ExitCodeMeaning exitCodeMeanings[] = {
    {ExitCode::ok, "certified and written; check: no violations"},
    {ExitCode::usage, "the command line is invalid"},
    {ExitCode::badInput, "a file or a value in it is invalid"},
    {ExitCode::outOfReach, "not feasible, or not within the limits: nothing written, unless --best-effort"},
    {ExitCode::faultsFound,
     "check found overlap, cells outside the lumen, gaps below the required clearance, or cells that "
     "HemoCell deletes (other than by crossing a periodic face)"},
    {ExitCode::cannotWrite, "the output cannot be written"},
    {ExitCode::notConnected, "several copies were started, but not as ranks of MPI: nothing written"},
    {ExitCode::internal, "internal error"},
    {ExitCode::interrupted, "interrupted: no .pos file written, or only the .pos files, not their exports"},
};

/// The command line is invalid.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// More cells are requested than any packing has.
class InfeasibleError : public InputError {
 public:
  using InputError::InputError;
};

/// An error as reported to the user.
struct Failure {
  ExitCode code = ExitCode::internal;
  std::string message;
};

/// Thrown identically on all ranks, or inside together(), which makes it that of all.
class AgreedFailure : public std::runtime_error {
 public:
  explicit AgreedFailure(const Failure& failure) : std::runtime_error(failure.message), code_(failure.code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace packmesh::hemocell
