// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Ctrl-C.
#pragma once

namespace packmesh::hemocell {

/// From now on SIGINT and SIGTERM end the program at once, with a message and exit code 130.
void catchInterruption();

/// While it lives, the first signal only sets a flag. For packing, which asks for the flag, and for writing,
/// which is not to be cut short. A second signal, two seconds later or
/// more, ends the program all the same.
class PolledInterruption {
 public:
  PolledInterruption();
  PolledInterruption(const PolledInterruption&) = delete;
  PolledInterruption& operator=(const PolledInterruption&) = delete;
  ~PolledInterruption();
};

/// Whether the flag is set.
bool interrupted();

}  // namespace packmesh::hemocell
