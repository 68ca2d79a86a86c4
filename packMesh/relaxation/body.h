// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A cell while it is being moved, and the state of a relaxation.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "packMesh/core/pose.h"
#include "packMesh/relaxation/contact_kernels.h"

namespace packmesh {

/// What persists of a body between neighbour lists: what is sent between ranks and stored in states.
struct BodyState {
  Vec3 position = Vec3::Zero();  ///< [µm]
  double scale = 1.0;
  Quaternion orientation = Quaternion::Identity();
  /// Upper bound of the displacement of any of its points since the pairs were last listed [µm]. Results
  /// about its surroundings stay valid up to a certain displacement.
  double moved = 0.0;
  double overlap = 0.0;                 ///< sum of its penetrations in the last sweep [µm]
  double extraWallClearance = 0.0;      ///< added for cells that the exact test found misplaced [µm]
  double stepTaken = 1.0;               ///< engines: the fraction of the last proposed step that was taken
  std::int64_t id = 0;                  ///< global, over all species
  std::int32_t species = 0, shape = 0;  ///< indices into Physics::species and Physics::shapes
  std::int32_t block = 0;
  bool deepInWall = false;  ///< was deep in the wall at the last test, so coarse samples suffice
  bool touched = false;     ///< moved since Relaxation::forgetTouched()
  bool frozen = false;      ///< engines: does not move, and neighbours grow up to its surface

  Pose pose() const { return {scale, orientation, position}; }
};

static_assert(sizeof(BodyState) == 128, "there are many");

/// Aligned so that threads that move neighbours in memory do not write to the same lines of their caches.
struct alignas(64) Body : BodyState {
  Mat3 rotation = Mat3::Identity();  ///< of `orientation`
  double awayFromWallUntil = -1.0;   ///< the wall test is skipped until `moved` reaches this
  /// Until `moved` reaches wallMaskUntil, only these clusters of samples can touch the wall.
  ClusterMask wallMask = allClusters;
  double wallMaskUntil = -1.0;
  bool sleeping = false;  ///< until it moves, the tests against wall and region are skipped
  bool changed = false;   ///< moved since the last ghost update

  Body() { deepInWall = true; }
  explicit Body(const BodyState& state) : BodyState(state), rotation(orientation.toRotationMatrix()) {}

  /// Discards everything cached about its surroundings.
  void forgetSurroundings() {
    moved = 0.0;
    awayFromWallUntil = wallMaskUntil = -1.0;
  }

  void setPose(const Pose& pose) {
    scale = pose.scale;
    position = pose.position;
    orientation = pose.orientation;
    rotation = orientation.toRotationMatrix();
  }
};

/// The state of a body that has not been moved yet.
inline BodyState stateOf(std::int64_t id, int species, int shape, const Pose& pose) {
  BodyState state;
  state.id = id;
  state.species = species;
  state.shape = shape;
  state.scale = pose.scale;
  state.orientation = pose.orientation;
  state.position = pose.position;
  return state;
}

/// The same of a body that may be anywhere: deep in the wall, too.
inline Body makeBody(std::int64_t id, int species, int shape, const Pose& pose) {
  Body body(stateOf(id, species, shape, pose));
  body.deepInWall = true;
  return body;
}

inline std::vector<Body> bodiesOf(const std::vector<BodyState>& states) {
  return {states.begin(), states.end()};
}

/// Sums over one sweep. They are exact, so that they do not depend on the order of summation.
struct SweepSums {
  double deepest = 0.0;         ///< largest penetration into a clearance [µm]
  std::int64_t totalSteps = 0;  ///< sum of the penetrations of all contacts, each rounded to steps
  std::int64_t contacts = 0;
  bool thorough = true;  ///< every pair was examined completely

  /// Sum of the penetrations of all contacts [µm].
  double total() const { return static_cast<double>(totalSteps) / stepsPerMicrometre; }
  /// Of a contact [µm].
  double meanDepth() const { return contacts == 0 ? 0.0 : total() / static_cast<double>(contacts); }

  void add(double depth) {
    deepest = deepest > depth ? deepest : depth;
    totalSteps += static_cast<std::int64_t>(depth * stepsPerMicrometre);
    ++contacts;
  }
  void add(const SweepSums& other) {
    deepest = deepest > other.deepest ? deepest : other.deepest;
    totalSteps += other.totalSteps;
    contacts += other.contacts;
  }

 private:
  static constexpr double stepsPerMicrometre = 0x1p20;
};

/// Extra clearance of pairs (ids, the smaller one first) in addition to the problem's [µm].
using ExtraClearances = std::map<std::pair<std::int64_t, std::int64_t>, float>;

/// The state of a relaxation besides its bodies, at any time just before a rebuild of the neighbour list. The
/// same on all ranks. With the bodies this is all that the following sweeps depend on.
struct RelaxationState {
  /// Initial number of cells per shape, from which blocks and masses are derived. Empty: of the bodies
  /// given.
  std::vector<std::int64_t> counts;
  std::array<int, 3> blocks = {0, 0, 0};  ///< along each axis
  std::int64_t sweeps = 0;                ///< done
  std::int64_t listedInSweep = 0;         ///< of the last rebuild of the neighbour list
  double skin = 0.0;                      ///< Verlet skin of the neighbour list [µm]
  double slack = 0.0;                     ///< of the last sweep [µm]
  bool coarsely = true;                   ///< whether coarse samples have sufficed so far
  SweepSums last;                         ///< of the last sweep
  ExtraClearances extraClearance;
  std::set<std::int64_t> disturbed;  ///< cells of which something was demanded since the last sweep
};

/// Position in a schedule.
struct SchedulePosition {
  std::int64_t part = 0;   ///< of relax(): 0 is the constant stage, then annealings
  std::int64_t sweep = 0;  ///< of the part
};

}  // namespace packmesh
