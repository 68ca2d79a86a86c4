// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The input of a packing: plain data, no file formats.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packMesh/analysis/analysis_input.h"
#include "packMesh/certificate/certificate.h"
#include "packMesh/container/container.h"
#include "packMesh/escape/escape.h"
#include "packMesh/growth/growth_settings.h"
#include "packMesh/growth/plane_source.h"
#include "packMesh/packing/packing_state.h"
#include "packMesh/parallel/communicator.h"
#include "packMesh/parallel/threads.h"
#include "packMesh/relaxation/freedom.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// One kind of cell and its number.
struct Species {
  std::string name;
  std::shared_ptr<const Shape> shape;
  std::int64_t count = 0;
  /// The wall for this species; nullptr: the container's own.
  std::shared_ptr<const Wall> wall;
  bool inHematocrit = true;  ///< its volume is part of the hematocrit
  /// Initial poses of the first cells, scale 1; the others start at random.
  std::vector<Pose> start = {};
  Freedom freedom = {};  ///< the cells of fixed species all have initial poses
  /// Starts in columns (packMesh/placement/columns.h) instead of at random. At most one species, which is
  /// unconstrained and has no initial poses, in boxes that are periodic along all axes.
  bool inColumns = false;
  /// Requested number before rounding to `count`; 0: the same. If fewer cells are tried, their numbers are
  /// derived from this one, so that larger and smaller requests try the same numbers of every species.
  double asked = 0.0;
};

/// Limits of a run.
struct Limits {
  /// Wall time to fit all cells in [s]; with the search for the densest packing of fewer cells (fewerCells)
  /// it may take twice as long. After that, pack() ends within 5 s, or within 2 s per 100,000 cells if that
  /// is longer. 0: no limit.
  double maxSeconds = 0.0;
  std::int64_t maxSweeps = 100000;     ///< relaxation sweeps, or iterations of growth, for fitting all cells
  std::int64_t sweepsForFew = 0;       ///< further sweeps if only few contacts are left then
  std::function<double()> clock = {};  ///< current time [s]; empty: the system clock
  /// If not feasible: whether to search for the densest packing of fewer cells, and to refuse cells that fit
  /// nowhere. Otherwise pack() only reports that it did not succeed.
  bool fewerCells = true;
};

/// Progress that pack() reports.
struct Progress {
  std::string stage;
  std::int64_t sweep = 0;
  double scale = 1.0;           ///< common scale of the cells [fraction]
  double worstOverlap = 0.0;    ///< deepest penetration into a clearance [µm]
  std::int64_t unresolved = 0;  ///< pairs that still overlap
};

/// Which method packs.
enum class Method {
  relaxation,  ///< full-size cells are placed at random and pushed apart
  cat,         ///< small cells grow in the cells of the chordal axis transform (thesis chapter 3)
};

struct PackingProblem {
  std::vector<Species> species;
  std::shared_ptr<const Container> container;
  /// Least gap between membranes [µm], guaranteed by the certificate. 0, the default, requires that no two
  /// meshes share a point, which is all that HemoCell needs and admits the densest packings; the gap achieved
  /// is reported.
  double clearance = 0.0;
  /// Least gap between membrane and wall [µm], guaranteed by the certificate.
  double wallClearance = 0.0;
  std::uint64_t seed = 1;
  bool rotate = true;  ///< false: every orientation stays the identity
  Limits limits;
  /// The ranks that pack together. The packing does not depend on their number.
  Communicator communicator;
  Threads threads = {};  ///< of this rank; the packing does not depend on their number either
  Method method = Method::relaxation;
  PlaneSource planeSource = PlaneSource::chords;  ///< of Method::cat
  GrowthSettings growth;                          ///< of Method::cat
  /// Method::cat: if growth does not bring all cells to full size, and if there is a reserve, escape from
  /// local maxima.
  std::optional<EscapeSettings> escape;
  /// The pose as it will be written, so that the certificate refers to the written numbers; called by several
  /// threads at once. Empty: Pose::placement.
  std::function<Placement(const Pose&)> written;
  /// Polled between sweeps, and between the cells of a certificate; true stops the run.
  std::function<bool()> interrupted;
  std::function<void(const Progress&)> progress;
  /// Saved state to resume from; empty: start from the beginning. The rest of the run is the same as without
  /// the interruption. Pre: of the same problem, except for limits and ranks.
  std::optional<PackingState> resume;
  std::optional<Checkpoints> checkpoints;
  /// Called with every state that growth accepts (Method::cat): this rank's cells at their current
  /// scales.
  std::function<void(const std::vector<PlacedCell>&)> observe;

  std::int64_t cellCount() const {
    std::int64_t cells = 0;
    for (const Species& one : species) cells += one.count;
    return cells;
  }

  /// Input for measuring cells of this problem.
  AnalysisInput analysisInput() const {
    AnalysisInput input;
    for (const Species& one : species) {
      input.shapes.push_back(one.shape.get());
      input.inHematocrit.push_back(one.inHematocrit);
    }
    input.container = container.get();
    input.communicator = communicator;
    input.threads = threads;
    return input;
  }

  /// The wall for a species; nullptr: none.
  const Wall* wallOf(const Species& one) const { return one.wall ? one.wall.get() : container->wall(); }
};

}  // namespace packmesh
