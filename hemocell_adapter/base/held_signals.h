// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signals that wait until a step is complete.
#pragma once

#include <signal.h>

namespace packmesh::hemocell {

/// While it exists, signals wait: between the creation of a file and its registration, for example. For the
/// calling thread: the program has no others at such times.
class HeldSignals {
 public:
  HeldSignals();
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace packmesh::hemocell
