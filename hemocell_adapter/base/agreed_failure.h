// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Failures known to all ranks.
#pragma once

#include <stdexcept>
#include <string>

#include "hemocell_adapter/base/exit_codes.h"

namespace packmesh::hemocell {

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
