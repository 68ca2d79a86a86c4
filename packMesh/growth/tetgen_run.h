// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Runs of TetGen, each in a process of its own: TetGen 1.5 has global state, and on some input it
/// crashes or never returns. Internal to packMesh/growth.
#pragma once

#include <functional>

#include "packMesh/core/helper_process.h"
#include "packMesh/growth/tetgen_data.h"

namespace packmesh {

/// A run of packmesh-tetgen. Several can go on at once.
class TetgenRun {
 public:
  /// Starts it. Pre: triangles intersect in common vertices and edges only; on other input TetGen may fail in
  /// any way, which is a failure of the run alone
  /// @throws InputError if there is no such program (see tetgenProgram())
  explicit TetgenRun(const TetgenInput& input);

  /// Exchanges data for at most this long [ms]. @return whether the run has ended
  bool wait(int milliseconds) { return process_.wait(milliseconds); }

  /// @param failure set if TetGen gives up; the output is then empty. Pre: the run has ended; once
  TetgenOutput take(TetgenFailure& failure) const;

 private:
  std::size_t points_;
  HelperProcess process_;
};

/// Runs TetGen and waits for it.
/// @param stop polled at least 20 times per second; true ends the run. Empty: never stop
/// @throws InputError see TetgenRun
TetgenOutput runTetgen(const TetgenInput& input, TetgenFailure& failure,
                       const std::function<bool()>& stop = {});

}  // namespace packmesh
