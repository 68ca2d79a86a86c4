// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How failed ranks find out whether all others have failed, too.
#pragma once

#include <memory>

#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// A barrier with time limit, on its own communicator, so that it does not interfere with other messages:
/// ranks outside it may be anywhere in the program.
class Arrival {
 public:
  /// Collective. Pre: an MpiSession exists unless `ranks` is alone
  explicit Arrival(const Communicator& ranks);
  ~Arrival();

  /// True if all ranks call this within `seconds` [s]: then no rank waits for another, and the program can
  /// end normally. Call once per program.
  bool ofAll(double seconds);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;  ///< nullptr if alone
};

}  // namespace packmesh
