// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Failures that all ranks know of.
#pragma once

#include <stdexcept>
#include <string>

#include "hemocell_adapter/base/exit_codes.h"

namespace packmesh::hemocell {

/// An error as users get to see it.
struct Failure {
  ExitCode code = ExitCode::internal;
  std::string message;
};

/// Thrown on all ranks alike.
class AgreedFailure : public std::runtime_error {
 public:
  explicit AgreedFailure(const Failure& failure) : std::runtime_error(failure.message), code_(failure.code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace packmesh::hemocell
