// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file MPI itself.
#pragma once

namespace packmesh {

/// MPI from construction to destruction. One per program.
class MpiSession {
 public:
  MpiSession();
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
};

}  // namespace packmesh
