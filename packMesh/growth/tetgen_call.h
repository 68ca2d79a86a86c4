// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How TetGen says that it gives up. Internal to packMesh/growth.
#pragma once

namespace packmesh {

/// Thrown through TetGen.
struct TetgenGaveUp {
  static constexpr int assertion = 11;  ///< one of its assertions failed
  int code;
};

/// While one lives, TetGen's way to give up is ours. (What refers to it makes linkers take our way into a
/// program.)
class TetgenCall {
 public:
  TetgenCall();
  ~TetgenCall();
  TetgenCall(const TetgenCall&) = delete;
  TetgenCall& operator=(const TetgenCall&) = delete;
};

}  // namespace packmesh
