// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A certificate that is updated while a few cells at a time move.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/overlap_finder.h"
#include "packMesh/mesh/self_intersection.h"

namespace packmesh {

/// A search of limited length: if all cells overlap, the number of pairs is quadratic in the number of cells.
///
/// Cells are searched in rounds, in the order of their numbers, each round twice as long as the one before. A
/// round in which too many pairs are found is given up and its pairs are forgotten, since which of them were
/// found depends on threads and ranks. Then it is known that at least `most` pairs overlap; only examples
/// are still looked for, from the first cell of that round on, if the rounds before have too few. The rounds
/// follow from the numbers of pairs alone, so they are the same on all ranks and for any number of them.
class OverlapSearch {
 public:
  /// Pairs that are enough as examples.
  static constexpr std::int64_t examples = 20;

  /// @param cells of all ranks
  /// @param most at which number of pairs the search ends
  explicit OverlapSearch(std::int64_t cells, std::int64_t most) : cells_(cells), most_(most) {}

  bool over() const { return begin_ >= cells_; }
  /// The cells of this round: first and one behind the last.
  std::int64_t begin() const { return begin_; }
  std::int64_t end() const { return std::min(begin_ + size_, cells_); }
  /// A round that finds as many pairs can end at once.
  std::int64_t room() const { return most_ - kept_; }
  /// Whether there are more pairs than can be listed; only examples are looked for.
  bool more() const { return more_; }

  /// Ends a round. @param found pairs of all ranks, at least room() if the round was ended early
  /// @return whether they are kept
  bool finish(std::int64_t found);

 private:
  std::int64_t cells_, most_, kept_ = 0;
  std::int64_t begin_ = 0, size_ = 1;
  bool more_ = false;
};

/// Finds the smallest of many gaps while measuring only a few of them: those below a limit that decreases
/// with the smallest gap found so far.
class SmallestGap {
 public:
  /// @param level initial limit [µm]
  /// @param lowest no gap below this is expected [µm]
  SmallestGap(double largestGap, double level, double lowest = 0.0)
      : ofInterest_(largestGap), level_(std::min(level, largestGap)), alwaysMeasured_(lowest + reserve) {}

  /// Gaps below this are measured [µm].
  double limit() const { return std::min(ofInterest_, std::max(alwaysMeasured_, std::min(least_, level_))); }
  /// The smallest gap known [µm]; infinity: none below the gap of interest.
  double least() const { return least_; }
  /// True if no unmeasured gap can be smaller.
  bool settled() const { return least_ <= known_ || known_ >= ofInterest_; }

  /// Some gaps were measured up to limit(); all others are at least that large.
  void measured() { known_ = std::min(known_, limit()); }
  void add(double gap) {
    if (gap < ofInterest_) least_ = std::min(least_, gap);
  }
  /// Takes over what another search with the same limits has found.
  void join(const SmallestGap& other) {
    least_ = std::min(least_, other.least_);
    known_ = std::min(known_, other.known_);
  }
  /// Forgets the smallest gap; add() provides it again.
  void forgetLeast() { least_ = std::numeric_limits<double>::infinity(); }
  /// Forgets everything and raises the limit. Pre: not settled.
  void beginAgain() {
    constexpr double factor = 8.0;
    level_ =
        least_ < ofInterest_ ? std::nextafter(least_, ofInterest_) : std::min(factor * level_, ofInterest_);
    least_ = known_ = std::numeric_limits<double>::infinity();
  }

 private:
  /// Gaps within this distance of the lowest are always measured [µm]: this costs little, and when the
  /// smallest gap disappears, the next is known.
  static constexpr double reserve = 0.005;

  double ofInterest_, level_, alwaysMeasured_;
  double least_ = std::numeric_limits<double>::infinity();
  double known_ = std::numeric_limits<double>::infinity();  ///< all gaps below this have been measured [µm]
};

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

/// Examines every pair of cells that could meet (periodic images included) and every cell against its wall.
///
/// Overlap is decided by exact predicates on the world vertices `placement(v)` of the template meshes:
/// triangles are closed sets, so meshes that share a single point overlap; a mesh inside another one overlaps
/// it, too.
/// Results are sorted by cell. Memory: about 130 bytes per cell; meshes are placed one at a time.
Certificate certify(const CertificateInput& input);

/// The same, but no gaps larger than `largestGap` are measured [µm].
Certificate certify(CertificateInput input, double largestGap);

/// The overlapping pairs that contain at least one of `movedCells` (each once), sorted by cell; without gaps
/// and walls. For stages that move a few cells at a time: all other pairs are unchanged.
std::vector<OverlappingPair> findOverlaps(const CertificateInput& input,
                                          const std::vector<std::int64_t>& movedCells);

/// All overlapping pairs.
std::vector<OverlappingPair> findOverlaps(const CertificateInput& input);

}  // namespace packmesh
