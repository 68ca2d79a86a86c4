// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What is to be packed: plain data, no file formats.
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
#include "packMesh/relaxation/freedom.h"
#include "packMesh/shape/shape.h"

namespace packmesh {

/// One kind of cell and how many of it.
struct Species {
  std::string name;
  std::shared_ptr<const Shape> shape;
  std::int64_t count = 0;
  /// The wall as this species meets it; nullptr: the container's own.
  std::shared_ptr<const Wall> wall;
  bool inHematocrit = true;  ///< its volume is part of the hematocrit
  /// Where the first cells start, scale 1; the others start at random.
  std::vector<Pose> start = {};
  Freedom freedom = {};  ///< Method::relaxation only; fixed cells all have a start
  /// Starts in columns (stages/placement/columns.h) instead of at random. Of one species at most, which is
  /// free and has no start, in boxes that are periodic along all axes; Method::relaxation only.
  bool inColumns = false;
  /// How many were asked for before that was rounded to `count`; 0: as many. When fewer cells are tried these
  /// are shares of it, so that requests for more or less try the same numbers of every species.
  double asked = 0.0;
};

/// When to give up.
struct Limits {
  /// Wall time to fit all cells in [s]; with the search for the densest packing of fewer cells (fewerCells)
  /// it may take twice as long. Then pack() ends within 5 s, or 2 s for every 100,000 cells if that is more.
  /// 0: no limit.
  double maxSeconds = 0.0;
  std::int64_t maxSweeps = 100000;     ///< relaxation sweeps, or iterations of growth, to fit all cells in
  std::function<double()> clock = {};  ///< the time [s]; empty: the machine's
  /// Out of reach: whether to look for the densest packing of fewer cells (Method::relaxation only), and to
  /// refuse cells that fit nowhere. Without it pack() says no more than that it did not succeed.
  bool fewerCells = true;
};

/// What pack() tells while it works.
struct Progress {
  std::string stage;
  std::int64_t sweep = 0;
  double scale = 1.0;           ///< common scale of the cells [fraction]
  double worstOverlap = 0.0;    ///< deepest penetration into a clearance [µm]
  std::int64_t unresolved = 0;  ///< pairs that still meet
};

/// Which stage does the work.
enum class Method {
  relaxation,  ///< full-size cells are placed at random and pushed apart
  cat,         ///< small ones grow in the cells of the chordal axis transform (thesis chapter 3)
};

struct PackingProblem {
  std::vector<Species> species;
  std::shared_ptr<const Container> container;
  /// Least gap between membranes [µm], guaranteed by the certificate. 0, the default, asks that no two meshes
  /// share a point, which is all that HemoCell needs and leaves most room; what was reached is reported.
  double clearance = 0.0;
  /// Least gap between membrane and wall [µm], guaranteed by the certificate.
  double wallClearance = 0.0;
  std::uint64_t seed = 1;
  bool rotate = true;  ///< false: every orientation stays the identity
  Limits limits;
  /// The ranks that pack together. The packing does not depend on how many there are.
  Communicator communicator;
  Method method = Method::relaxation;
  PlaneSource planeSource = PlaneSource::chords;  ///< of Method::cat
  GrowthSettings growth;                          ///< of Method::cat
  /// Method::cat: when growth does not get all cells to full size, and with a reserve, local maxima are
  /// escaped.
  std::optional<EscapeSettings> escape;
  /// How a pose will be written, so that the certificate is about the written numbers; empty:
  /// Pose::placement.
  std::function<Placement(const Pose&)> written;
  /// Polled between sweeps, and between the cells of a certificate; true stops the run cleanly.
  std::function<bool()> interrupted;
  std::function<void(const Progress&)> progress;
  /// Where to go on, as it was saved; empty: from the beginning. Its way to the end is that of a run that was
  /// not interrupted. Pre: of the same problem, but for limits and ranks.
  std::optional<PackingState> resume;
  std::optional<Checkpoints> checkpoints;
  /// Called with every state that growth accepts (Method::cat): all cells, as small as they are.
  std::function<void(const std::vector<PlacedCell>&)> observe;

  std::int64_t cellCount() const {
    std::int64_t cells = 0;
    for (const Species& one : species) cells += one.count;
    return cells;
  }

  /// What measures of its cells need to know.
  AnalysisInput analysisInput() const {
    AnalysisInput input;
    for (const Species& one : species) {
      input.shapes.push_back(one.shape.get());
      input.inHematocrit.push_back(one.inHematocrit);
    }
    input.container = container.get();
    input.communicator = communicator;
    return input;
  }

  /// The wall as a species meets it; nullptr: none.
  const Wall* wallOf(const Species& one) const { return one.wall ? one.wall.get() : container->wall(); }
};

}  // namespace packmesh
