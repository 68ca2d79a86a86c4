// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Handling of failures within TetGen. Internal to packMesh/growth.
#pragma once

namespace packmesh {

/// Exception thrown through TetGen.
struct TetgenGaveUp {
  static constexpr int assertion = 11;  ///< one of its assertions failed
  int code;
};

/// While an instance exists, failures within TetGen are handled by packMesh. (A reference to it makes linkers
/// include the handlers.)
class TetgenCall {
 public:
  TetgenCall();
  ~TetgenCall();
  TetgenCall(const TetgenCall&) = delete;
  TetgenCall& operator=(const TetgenCall&) = delete;
};

}  // namespace packmesh
