// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/pack.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "packMesh/certificate/certificate.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/core/error.h"
#include "packMesh/core/vector.h"
#include "packMesh/packing/attempt.h"
#include "packMesh/packing/densest.h"
#include "packMesh/packing/engine.h"
#include "packMesh/relaxation/schedule.h"

namespace packmesh {
namespace {

std::string number(double value) {
  return toText(value, 4);
}

void checkClearance(double clearance, const char* what) {
  if (!std::isfinite(clearance) || clearance < 0.0)
    throw InputError(std::string("the ") + what + " must be a finite length of at least 0 µm, found " +
                     number(clearance));
}

/// A cell fits nowhere if a ball inside it is wider than the lumen along an axis.
void checkFits(const Species& species, const Shape& shape, const Container& container, double wallClearance) {
  Vec3 room = container.bounds().size();
  for (int k = 0; k < 3; ++k)
    if (container.period()[k] > 0.0)
      room[k] = std::numeric_limits<double>::infinity();
    else
      room[k] -= 2.0 * wallClearance;
  constexpr double surely = 0.98;  // depths inside meshes are interpolated
  if (room.minCoeff() <= 2.0 * surely * shape.halfThickness() || shape.volume() > container.volume())
    throw InputError(
        "a cell of species '" + species.kindName() + "' (" + number(2.0 * shape.radius()) + " µm wide, " +
        number(shape.volume()) + " µm³) is larger than the lumen (" + container.describe() + ")" +
        (wallClearance > 0.0 ? " less the clearance of " + number(wallClearance) + " µm to the wall" : ""));
}

/// A cell may be wider than the period, but not so wide that the number of its images becomes excessive.
void checkPeriods(const Species& species, const Shape& shape, const PackingProblem& problem) {
  constexpr double mostPeriods = 32.0;
  const Vec3& period = problem.physics.container->period();
  const double width = 2.0 * shape.radius(), gap = measuredUpTo(problem.physics.clearance);
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0 && width + gap > mostPeriods * period[k])
      throw InputError("the period of the lumen, " + number(period[k]) + " µm along " + "xyz"[k] +
                       ", is too small for the certificate: a cell of species '" + species.kindName() +
                       "' is " + number(width) + " µm wide, and gaps up to " + number(gap) +
                       " µm are measured");
}

/// Cells with a clearance c remain disjoint when each is dilated by c/2, and are then inside the lumen
/// dilated by c/2. By the Brunn-Minkowski inequality, a body of volume V dilated by r has at least the volume
/// of the ball of volume V dilated by r.
void checkRoomForClearance(const PackingProblem& problem) {
  if (problem.physics.clearance == 0.0) return;
  const double grown = 0.5 * problem.physics.clearance, unitBall = 4.0 / 3.0 * std::acos(-1.0);
  std::int64_t count = 0;
  double needed = 0.0, room = 1.0;
  for (const Species& species : problem.physics.species) {
    count += species.count;
    species.forEachShape([&](int shape, std::int64_t cells) {
      const double volume = problem.physics.shapes[shape]->volume();
      needed += double(cells) * std::pow(std::cbrt(volume) + std::cbrt(unitBall) * grown, 3.0);
    });
  }
  const Vec3 lumen = problem.physics.container->bounds().size(), period = problem.physics.container->period();
  for (int k = 0; k < 3; ++k)
    room *= period[k] > 0.0 ? period[k] : lumen[k] - 2.0 * problem.physics.wallClearance + 2.0 * grown;
  if (count > 1 && needed > room)
    throw InputError(std::to_string(count) + " cells " + number(problem.physics.clearance) +
                     " µm apart need a lumen larger than " + problem.physics.container->describe());
}

void checkShapes(const Species& species, const Physics& physics) {
  const auto refuse = [&](const char* what) {
    throw InputError("species '" + species.kindName() + "' " + what);
  };
  const auto exists = [&](int shape) {
    return shape >= 0 && shape < static_cast<int>(physics.shapes.size()) && physics.shapes[shape];
  };
  if (!exists(species.shape)) refuse("has no shape");
  for (const DeformedCell& cell : species.deformed)
    if (!exists(cell.shape) || physics.shapes[cell.shape]->undeformed() != physics.shapes[species.shape])
      refuse("has a deformed cell whose shape is not a form of its template");
}

void checkStart(const Species& species) {
  const Freedom& freedom = species.freedom;
  const auto refuse = [&](const char* what) {
    throw InputError("species '" + species.kindName() + "' " + what);
  };
  if (freedom.fixed && species.placed() != species.count)
    refuse("is fixed, so each of its cells needs an initial pose");
  species.forEachStart([&](int, const Pose& pose) {
    if (!pose.position.allFinite() || !pose.orientation.coeffs().allFinite())
      refuse("has an initial pose that is not finite");
    if (pose.scale != 1.0) refuse("has initial poses that are not of full size");
  });
  checkClearance(freedom.extraWallClearance, "extra clearance to the wall");
  if (freedom.cone && !(freedom.cone->spread >= 0.0 && freedom.cone->spread <= 0.5 * std::acos(-1.0)))
    refuse("has an axis with a spread that is not in [0, pi/2] rad");
  if (freedom.cone && !(std::abs(freedom.cone->axis.norm() - 1.0) < 1e-9))  // up to rounding
    refuse("has an axis that is not a unit vector");
}

void checkColumns(const PackingProblem& problem) {
  int species = 0;
  for (const Species& one : problem.physics.species) {
    if (!one.inColumns) continue;
    const auto refuse = [&](const char* what) {
      throw InputError("species '" + one.kindName() + "' cannot start in columns: " + what);
    };
    if (++species > 1) refuse("another species does as well");
    if (one.placed() > 0 || !one.deformed.empty()) refuse("some of its cells exist already");
    if (one.freedom.cone) refuse("the orientation of its cells is constrained");
    if (one.freedom.region) refuse("its cells are restricted to a region");
    if (!one.freedom.isFree()) refuse("its cells are fixed or have an extra clearance to the wall");
    if (!problem.physics.rotate) refuse("rotations are disabled");
    if (!(problem.physics.container->period().minCoeff() > 0.0))
      refuse("this requires a box that is periodic along all axes");
  }
}

/// Refuses fixed cells that overlap each other, the wall or themselves, since no packing is possible then.
/// All ranks examine all of them.
void checkFixed(const Physics& physics, const Threads& threads) {
  std::vector<PlacedCell> cells;
  std::vector<std::string> names;
  for (std::size_t s = 0; s < physics.species.size(); ++s) {
    const Species& species = physics.species[s];
    if (!species.freedom.fixed) continue;
    species.forEachStart([&, first = cells.size()](int shape, const Pose& pose) {
      cells.push_back({static_cast<int>(s), shape, physics.placement(pose)});
      names.push_back("cell " + std::to_string(cells.size() - first) + " of '" + species.kindName() + "'");
    });
  }
  if (cells.empty()) return;
  const Certificate found = certify(certificateInputOf(physics, cells, threads));
  if (!found.misplaced.empty()) {
    const MisplacedCell& cell = found.misplaced.front();
    throw InputError(names[cell.cell] + ", which stays where it is, " + cell.reason);
  }
  if (!found.selfIntersecting.empty())
    throw InputError(names[found.selfIntersecting.front().cell] +
                     ", which stays where it is, intersects itself");
  if (!found.overlapping.empty()) {
    const OverlappingPair& pair = found.overlapping.front();
    throw InputError(names[pair.first] + " and " + names[pair.second] + ", which stay where they are, " +
                     (pair.gap > 0.0 ? "are closer to each other than the clearance" : "overlap each other"));
  }
}

}  // namespace

double cellVolume(const PackingProblem& problem) {
  double volume = 0.0;
  for (const Species& species : problem.physics.species)
    volume += static_cast<double>(species.count) * meanVolume(species, problem.physics.shapes);
  return volume;
}

void validate(const PackingProblem& problem) {
  if (!problem.physics.container) throw InputError("the problem has no container");
  checkClearance(problem.physics.clearance, "clearance between cells");
  checkClearance(problem.physics.wallClearance, "clearance to the wall");
  if (problem.engine && problem.engine->deforms()) return problem.engine->validate(problem);
  for (const Species& species : problem.physics.species) {
    checkShapes(species, problem.physics);
    if (species.count < 0)
      throw InputError("species '" + species.kindName() + "' has a negative count, " +
                       std::to_string(species.count));
    if (species.undeformed() < 0)
      throw InputError("species '" + species.kindName() + "' has more deformed cells than cells");
    checkStart(species);
    if (species.count == 0) continue;
    species.forEachShape([&](int s, std::int64_t) {
      const Shape& shape = *problem.physics.shapes[s];
      checkPeriods(species, shape, problem);
      checkFits(species, shape, *problem.physics.container,
                problem.physics.wallClearance + species.freedom.extraWallClearance);
    });
  }
  checkColumns(problem);
  if (problem.engine) problem.engine->validate(problem);
  const double cells = cellVolume(problem), lumen = problem.physics.container->volume();
  if (cells >= lumen)
    throw InputError("the cells have more volume than the lumen: " + number(cells) + " of " + number(lumen) +
                     " µm³");
  checkRoomForClearance(problem);
  checkFixed(problem.physics, problem.execution.threads);
}

namespace {

/// If not all cells are packed at once, packing them and the search for fewer of them may take this multiple
/// of the time limit. The attempt at all cells ends slightly earlier: a larger request has to try these
/// first, and must have the time that smaller requests have.
constexpr double timeWithSearch = 2.0, timeForAll = 1.4;

/// Volume fraction beyond which packing all cells is not attempted first, not even in columns.
constexpr double hopelessFraction = 0.66;

/// Replaces the cells of `all` by the largest certified number found, for a problem that is difficult or
/// infeasible. All cells if they can be packed in the remaining time.
Densest packFewer(const PackingProblem& problem, RunControl& control, Attempt& all) {
  const auto stopAfter = [&](double times) {
    if (control.limited()) control.stopAfter(times * problem.execution.limits.maxSeconds);
  };
  const Communicator& ranks = problem.execution.communicator;
  if (problem.checkpoints && problem.checkpoints->due)
    control.atPolls = [&] {
      if (all.hasBegun() && ranks.any(problem.checkpoints->due()))
        problem.checkpoints->save(all.checkpointState());
    };
  stopAfter(timeWithSearch);
  Densest densest = findDensest(problem, control, [&](std::int64_t sweeps) {
    stopAfter(timeForAll);
    const bool packed = all.certifyAll(sweeps);
    if (!control.stopped()) stopAfter(timeWithSearch);
    return packed;
  });
  control.atPolls = {};
  if (control.interrupted() || densest.whole) return densest;
  // The state of the engine may be denser than what the search has found.
  const bool keepsOwn =
      ((problem.engine && problem.engine->canExceedTrials()) || !densest.packing) && all.leaveOutFailing();
  if (densest.packing &&
      !(keepsOwn && all.certifiedCells()->certificate.cellVolume >= densest.packing->certificate.cellVolume))
    all.take(*densest.packing);
  return densest;
}

/// Certifies cells with meshes of their own where they are, as those are whose initial poses are given. If a
/// few meet, they are moved apart, or left out.
/// @param end becomes the state of the packing; nullptr: none is made
PackingResult certifiedInPlace(Physics physics, const Execution& execution, const RunControl& control,
                               PackingState* end) {
  PackingProblem inPlace{std::move(physics), nullptr, execution};
  Limits& limits = inPlace.execution.limits;
  limits.fewerCells = true;
  if (control.limited())
    limits.maxSeconds = std::max(Limits::leastSeconds, limits.maxSeconds - control.elapsed());
  if (end) inPlace.checkpoints = Checkpoints{{}, [end](const PackingState& state) { *end = state; }, true};
  PackingResult result = pack(inPlace);
  result.deformed.emplace().physics = std::make_shared<const Physics>(std::move(inPlace.physics));
  return result;
}

/// With an engine that deforms cells. The run continues from states of the engine alone.
PackingResult packDeformed(const PackingProblem& problem, RunControl& control) {
  Attempt attempt(problem, control);
  attempt.certifyAll();
  PackingResult result;
  PackingState end;
  const auto& states = problem.checkpoints;
  if (std::optional<Physics> physics = attempt.deformed()) {
    result = certifiedInPlace(std::move(*physics), problem.execution, control, states ? &end : nullptr);
    control.stopped();  // asks whether it was interrupted meanwhile
  }
  const bool interrupted = control.interrupted() || result.outcome == Outcome::interrupted;
  const bool succeeds = result.cellCount > 0 && !interrupted;
  if (states && succeeds) states->save(end);
  if (states && !succeeds && attempt.hasBegun() && (interrupted || states->savesFailed))
    states->save(attempt.checkpointState());
  PackingResult before = attempt.takeResult();
  before.late = control.late();
  if (interrupted) before.outcome = Outcome::interrupted;
  if (!succeeds) return before;
  result.late = before.late;
  result.deformed->engine = before.statistics.engine;
  if (result.cellCount < problem.physics.cellCount()) result.outcome = Outcome::outOfReach;
  return result;
}

}  // namespace

PackingResult pack(const PackingProblem& problem) {
  validate(problem);
  RunControl control(problem);
  if (problem.engine && problem.engine->deforms()) return packDeformed(problem, control);
  Attempt all(problem, control);
  // With a time limit, a packing of fewer cells is secured before all of them are tried for long.
  const bool secures = control.limited() && problem.execution.limits.fewerCells;
  const bool hopeless = cellVolume(problem) > hopelessFraction * problem.physics.container->volume();
  bool packed = all.certifyAll(secures && hopeless ? 0 : sweepsOfRelax(1));
  if (!packed && !secures && !control.interrupted()) packed = all.certifyAll();
  Densest fewer;
  if (!packed && !control.interrupted() && problem.execution.limits.fewerCells) {
    fewer = packFewer(problem, control, all);
    packed = all.hasAllCertified();
  }
  if (problem.checkpoints) {
    const bool ends = packed || (problem.checkpoints->endsWithFewer && all.certifiedCells());
    if (!control.interrupted() && ends) all.keepEnd();
    if (all.hasBegun()) problem.checkpoints->save(all.checkpointState());
  }
  PackingResult result = all.takeResult();
  result.searched = fewer.ended && !packed;
  result.statistics.searching = fewer.sweeps;
  result.late = control.late();
  return result;
}

}  // namespace packmesh
