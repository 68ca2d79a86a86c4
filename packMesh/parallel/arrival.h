// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How ranks that have failed learn whether the others have, too.
#pragma once

#include <memory>

#include "packMesh/parallel/communicator.h"

namespace packmesh {

/// A place where ranks of a program meet that nothing else is said at: other ranks may be anywhere.
class Arrival {
 public:
  /// All ranks call. Pre: an MpiSession lives unless `ranks` are alone
  explicit Arrival(const Communicator& ranks);
  ~Arrival();

  /// Whether all ranks come here within so long [s]: then none of them waits for another, and the program may
  /// end without more. Once per program.
  bool ofAll(double seconds);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;  ///< nullptr: alone
};

}  // namespace packmesh
