// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The end of work at the time limit or on request.
#pragma once

#include "hemocell_adapter/base/agreed_failure.h"

namespace packmesh::hemocell {

/// Thrown by a rank whose preparation reaches the time limit or is interrupted; together() makes it an
/// AgreedFailure.
class Stopped : public Error {
 public:
  explicit Stopped(const Failure& failure) : Error(failure.message), code_(failure.code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace packmesh::hemocell
