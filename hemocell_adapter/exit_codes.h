// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How the executable tells scripts what happened.
#pragma once

#include "packMesh/error.h"

namespace packmesh::hemocell {

/// Exit codes, as `--help` documents them.
enum class ExitCode {
  ok = 0,             ///< a certified packing was written; a check found nothing wrong
  usage = 1,          ///< the command line makes no sense
  badInput = 2,       ///< a file (config.xml, <Cell>.xml, mesh, .pos) or a value in it is at fault
  outOfReach = 3,     ///< the target was not reached within the limits; nothing was written
  faultsFound = 4,    ///< `check` found overlap, cells outside the lumen or cells HemoCell would delete
  cannotWrite = 5,    ///< the output folder is not writable or the disk is full
  internal = 70,      ///< a fault of packMesh itself
  interrupted = 130,  ///< Ctrl-C or SIGTERM; nothing was written
};

/// The command line is at fault.
class UsageError : public InputError {
 public:
  using InputError::InputError;
};

/// The results cannot be written.
class OutputError : public InputError {
 public:
  using InputError::InputError;
};

}  // namespace packmesh::hemocell
