// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file How a relaxed packing becomes a certified one: more clearance for what failed the exact test.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/packing/packing_problem.h"
#include "packMesh/problem/physics.h"
#include "packMesh/relaxation/relaxation.h"

namespace packmesh {

/// The cells of this rank at the time they were taken, and its ghosts; sorted by id. All ranks call its
/// functions together.
class WrittenCells {
 public:
  /// References `problem`, which must outlive it.
  explicit WrittenCells(const PackingProblem& problem) : problem_(&problem) {}

  /// Copies the cells from the relaxation.
  void take(Relaxation& relaxation);

  /// Updates cells that have moved since, wherever they are now.
  /// @return those (by index) that differ now; nothing if so many have moved that all have to be taken again
  std::optional<std::vector<std::int64_t>> update(Relaxation& relaxation);

  /// References this object.
  CertificateInput certificateInput() const;
  const std::vector<std::int64_t>& ids() const { return ids_; }

 private:
  const PackingProblem* problem_;
  std::vector<std::int64_t> ids_;
  std::vector<bool> own_;
  std::vector<PlacedCell> cells_;
  std::map<std::int64_t, Vec3> takenAt_;  ///< by index, of those that have moved since [µm]
};

/// Rounds of certificate, larger clearances, and sweeps.
struct RepairPolicy {
  std::int64_t rounds;  ///< after which a packing counts as unresolved
  std::int64_t sweeps;  ///< in each round
  double range;         ///< pairs whose gap exceeds the required one by at most this are listed, too [µm]
  /// Clearances follow the gaps of pairs (see clearanceCorrection), otherwise how often they failed.
  bool calibrates;

  /// That of a part of relax(): after a compaction, clearances are calibrated.
  static const RepairPolicy& after(std::int64_t part);
};

/// The clearances that the certificates of a run have demanded beyond those of the problem.
class Repairs {
 public:
  /// References `physics`, which must outlive it.
  explicit Repairs(const Physics& physics) : physics_(physics) {}

  /// Whether the packing is certified, apart from gaps that only calibration asks for.
  bool isMet(const RepairPolicy& policy, const Certificate& found) const;

  /// Demands clearance of the pairs and cells that were found. Pre: !isMet()
  void demand(const RepairPolicy& policy, const Certificate& found, Relaxation& relaxation);

  void restore(const PackingState& state);
  void store(PackingState& state) const;
  void clear();
  /// What was demanded of these cells.
  void forget(const std::set<std::int64_t>& ids);

 private:
  void demandOfPairs(const Certificate& found, Relaxation& relaxation);
  void calibratePairs(const Certificate& found, Relaxation& relaxation) const;
  void demandOfWall(const MisplacedCell& cell, Relaxation& relaxation);

  const Physics& physics_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> failures_;  ///< of pairs in the exact test
  std::map<std::int64_t, double> demandedOfWall_;  ///< of misplaced cells (ids) [µm]
};

/// Relaxation keeps all pairs a margin apart that few of them need: how much two meshes can be nearer to each
/// other than their sample points depends on where they touch. In a packing that is almost too dense, each
/// pair gets the margin that it needs (calibration). Its exact gap is measured, its clearance is corrected by
/// what the gap differs from the smallest one that is safe, and all cells are relaxed again, a few times.
/// @param gap between the meshes of a pair [µm]; 0: they overlap
/// @param required smallest gap allowed [µm]
/// @param extra present extra clearance of the pair [µm]
/// @return correction of the clearance of the pair [µm], a multiple of 2^-14: ranks that measure the gap of a
/// pair in different order find the same one
double clearanceCorrection(double gap, double required, double extra);

/// Cells (ids) without which none of the others fails: all misplaced and self-intersecting ones, and of each
/// pair the cell that fails in more pairs, but no fixed one.
/// @param known cells that fail, of which nothing more is to be found
std::set<std::int64_t> failingCells(const Certificate& found, const Physics& physics,
                                    std::set<std::int64_t> known = {});

}  // namespace packmesh
