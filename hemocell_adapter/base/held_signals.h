// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Signals that wait until a step is complete.
#pragma once

namespace packmesh::hemocell {

/// While it exists, signals that end the program (interruption.h) wait: between the creation of a file and
/// its registration, for example. In whichever thread they arrive; MPI has threads of its own.
class HeldSignals {
 public:
  HeldSignals();
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;
};

}  // namespace packmesh::hemocell
