// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A certificate that is updated while a few cells at a time move.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "packMesh/certificate/certified_cells.h"
#include "packMesh/certificate/overlap_search.h"
#include "packMesh/certificate/smallest_gap.h"
#include "packMesh/mesh/self_intersection_finder.h"

namespace packmesh {

/// A search for overlapping pairs that ends early if there are very many. Of one rank, or of several that
/// examine cells together, each its own.
struct LimitedSearch {
  OverlapSearch rounds;
  /// Of several ranks: the number of each cell among those of all ranks, ascending.
  const std::vector<std::int64_t>* numbers = nullptr;
  /// Of several ranks: sum of what each has found in a round. Called once per round; after an exception the
  /// caller goes through the rounds that are left.
  std::function<std::int64_t(std::int64_t own)> sum = {};
};

/// Certifies cells and updates the certificate when some of them have changed, by examining only the pairs
/// and walls of changed cells.
///
/// Every field of the certificate equals, to the bit, the result of certify() for the same cells. Memory:
/// about 130 bytes per cell, none per pair. The result does not depend on the number of threads.
class Certifier {
 public:
  /// Certifies all cells. The data referenced by `input` must outlive this object; the number of cells must
  /// not change.
  /// @param search without `stop` and upToFirstFault; used by the constructor only. nullptr: all pairs
  explicit Certifier(const CertificateInput& input, LimitedSearch* search = nullptr);
  Certifier(const Certifier&) = delete;
  Certifier& operator=(const Certifier&) = delete;

  const Certificate& certificate() const { return certificate_; }

  /// Updates the certificate. Pre: cells not in `changed` have not moved since the last call.
  void update(const std::vector<std::int64_t>& changed);

 private:
  /// What one thread finds.
  struct Findings {
    SmallestGap pairGap, wallGap;
    struct Near {
      std::int64_t cell;
      std::int32_t partner;
      double gap;  ///< [µm]
    };
    std::vector<Near> near = {};
    std::vector<OverlappingPair> overlapping = {};
    std::vector<MisplacedCell> misplaced = {};
    std::vector<SelfIntersectingCell> selfIntersecting = {};
    bool any() const { return !(overlapping.empty() && misplaced.empty() && selfIntersecting.empty()); }
    std::int64_t pairsTested = 0;
  };
  /// Calls examine(cell, findings) for cells, shared among the threads, until told to stop; then takes what
  /// was found, if that is kept.
  template <class Examine>
  void forEach(const std::vector<std::int32_t>& cells, const Examine& examine,
               const std::function<bool()>& isKept = {});
  void take(const Findings& findings);
  void forgetChanged();
  void examineAll(LimitedSearch* search);
  void searchInRounds(const std::vector<std::int32_t>& cells, LimitedSearch& search);
  void examineChanged();
  void finish();
  void examinePairs(std::int64_t cell, bool onlyLater, bool isNew, Findings& found,
                    std::atomic<std::int64_t>* room = nullptr);
  void findExamples(std::int64_t cell, Findings& found) const;
  /// Whether some pair overlaps that is not listed, because only a number of them is.
  bool isUnlisted() const { return certificate_.moreOverlaps && touching_; }
  void measureLater(const std::vector<std::int32_t>& cells);
  void settlePairGap();
  void examineWall(std::int64_t cell, bool isNew, Findings& found);
  void settleWallGap();
  void examineMembrane(std::int64_t cell, Findings& found) const;
  void summarise();

  const CertificateInput input_;
  const CertifiedCells cells_;
  Certificate certificate_;
  std::optional<PeriodicNeighbors> neighbors_;  ///< of the cells as last examined
  std::vector<bool> changed_;
  std::atomic<bool> touching_{false};  ///< a pair that touches was met while gaps were measured

  /// Per cell: the smallest gap [µm] among its pairs with later cells that are no violations, and the
  /// partner; exact up to the limit measured by pairGap_.
  std::vector<double> nearest_;
  std::vector<std::int32_t> partner_;
  std::vector<std::int32_t> stale_;  ///< cells whose nearest partner has moved
  SmallestGap pairGap_;

  std::vector<double> wallGaps_;  ///< per cell, likewise [µm]
  SmallestGap wallGap_;

  std::map<const Shape*, SelfIntersectionFinder> finders_;  ///< for deformed cells, by template
};

}  // namespace packmesh
