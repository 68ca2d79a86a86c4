// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/stages/relaxation/relaxation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "packMesh/random.h"

namespace packmesh {
namespace {

/// Over-relaxation: 2.2 needs a quarter of the sweeps of 1.0 at a fraction of 0.35 and a thirteenth at 0.58;
/// 2.5 diverges there. The guard lowers it to no less than `smallestOmega`.
const double startOmega = getenv("OM")?atof(getenv("OM")):1.0, smallestOmega = getenv("OMS")?atof(getenv("OMS")):0.6;

/// Pairs are listed up to this much further than they can touch [fraction of the largest radius], so that the
/// list outlives a few sweeps.
constexpr double skinFraction = 0.15;

/// Edge of a block [multiples of the largest cell's radius]: some 100-200 cells at usual fractions.
constexpr double preferredBlockEdge = 6.5;

double medianVolume(const RelaxationInput& input, const std::vector<Body>& bodies) {
  std::vector<double> volumes;
  volumes.reserve(bodies.size());
  for (const Body& b : bodies) volumes.push_back(input.shapes[b.species]->volume());
  if (volumes.empty()) return 1.0;
  std::nth_element(volumes.begin(), volumes.begin() + volumes.size() / 2, volumes.end());
  return volumes[volumes.size() / 2];
}

ContactSolver makeSolver(const RelaxationInput& input, const std::vector<Body>& bodies) {
  std::vector<SpeciesModel> models;
  const double reference = medianVolume(input, bodies);
  for (std::size_t s = 0; s < input.shapes.size(); ++s)
    models.emplace_back(*input.shapes[s], input.walls[s], reference);
  ContactSolver solver(std::move(models), input.period, input.clearance, input.wallClearance);
  solver.setMobile(input.rotate);
  return solver;
}

double largestRadius(const RelaxationInput& input) {
  double radius = 0.0;
  for (const Shape* shape : input.shapes) radius = std::max(radius, shape->radius());
  return radius;
}

}  // namespace

Relaxation::Relaxation(const RelaxationInput& input, std::vector<Body> bodies)
    : input_(input),
      solver_(makeSolver(input, bodies)),
      blocks_(input.bounds, input.period,
              2.0 * largestRadius(input) * (1.0 + 0.5 * skinFraction) + input.clearance,
              preferredBlockEdge * largestRadius(input)),
      blocksOfColour_(BlockGrid::colours),
      bodies_(std::move(bodies)),
      omega_(startOmega) {
  for (const Shape* shape : input.shapes) radii_.push_back(shape->radius());
  for (int b = 0; b < blocks_.count(); ++b) blocksOfColour_[blocks_.colourOf(b)].push_back(b);
}

bool Relaxation::listsOutdated() const {
  if (!listed_) return true;
  const double allowed = 0.5 * skinFraction * largestRadius(input_);
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if ((bodies_[i].position - listedAt_[i]).squaredNorm() > allowed * allowed) return true;
  return false;
}

void Relaxation::refreshLists() {
  // What is known of pairs outlives the lists by the cells' ids.
  std::vector<std::pair<PairKey, double>> known;
  // A cell that is wrapped takes its pairs' shifts along.
  for (Body& body : bodies_) {
    body.position = wrapped(body.position, input_.bounds, input_.period);
    body.block = blocks_.blockOf(body.position);
  }
  std::sort(bodies_.begin(), bodies_.end(),
            [](const Body& a, const Body& b) { return std::tie(a.block, a.id) < std::tie(b.block, b.id); });
  bodyStart_.assign(blocks_.count() + 1, 0);
  for (const Body& body : bodies_) ++bodyStart_[body.block + 1];
  for (int b = 0; b < blocks_.count(); ++b) bodyStart_[b + 1] += bodyStart_[b];

  const double margin = input_.clearance + skinFraction * largestRadius(input_);
  list_ = listPairs(bodies_, radii_, margin, input_.bounds, input_.period, blocks_.count());
  if (!extraClearance_.empty())
    for (NearPair& p : list_.pairs) {
      const auto extra = extraClearance_.find({bodies_[p.first].id, bodies_[p.second].id, {0, 0, 0}});
      if (extra != extraClearance_.end()) p.extraClearance = extra->second;
    }
  listedAt_.resize(bodies_.size());
  for (std::size_t i = 0; i < bodies_.size(); ++i) listedAt_[i] = bodies_[i].position;
  listed_ = true;
}

SweepSums Relaxation::sweep() {
  if (listsOutdated()) refreshLists();
  SweepSums sums;
  solver_.setOmega(omega_);
  for (const std::vector<int>& colour : blocksOfColour_)
    for (int block : colour) {
      for (std::int64_t p = list_.start[block]; p < list_.start[block + 1]; ++p)
        solver_.resolve(list_.pairs[p], bodies_, sums);
      for (std::int64_t i = bodyStart_[block]; i < bodyStart_[block + 1]; ++i) solver_.resolveWall(bodies_[i], sums);
    }
  ++sweeps_;
  last_ = sums;
  return sums;
}

bool Relaxation::settle(double tolerance, std::int64_t maxSweeps, const std::function<bool()>& stop) {
  for (std::int64_t k = 0; k < maxSweeps && !stop(); ++k) {
    const SweepSums sums = sweep();
    if (sums.deepest <= tolerance) return true;
    growing_ = sums.total > previousTotal_ ? growing_ + 1 : 0;
    previousTotal_ = sums.total;
    if (growing_ >= 3) {
      omega_ = std::max(smallestOmega, 0.85 * omega_);
      growing_ = 0;
    } else {
      omega_ = std::min(startOmega, 1.005 * omega_);
    }
  }
  return false;
}

void Relaxation::setScale(double scale) {
  for (Body& body : bodies_) {
    // Points move outwards by the growth: known gaps shrink by no more than that.
    body.travel += std::abs(scale - body.scale) * radii_[body.species];
    body.scale = scale;
  }
}

void Relaxation::kick(double amplitude) {
  ++kicks_;
  for (Body& body : bodies_) {
    const auto u = uniform4(input_.seed, RandomStream::kick, body.id, kicks_);
    const double length = amplitude * u[2];
    body.position += length * uniformDirection(u[0], u[1]);
    body.travel += length;
  }
}

void Relaxation::demandClearance(const PairKey& pair, double extra) {
  extraClearance_[{pair.first, pair.second, {0, 0, 0}}] += static_cast<float>(extra);
  listed_ = false;
}

void Relaxation::demandWallClearance(std::int64_t id, double extra) {
  for (Body& body : bodies_)
    if (body.id == id) {
      body.extraWallClearance += extra;
      body.awayFromWallUntil = 0.0;
    }
}

std::vector<Pose> Relaxation::poses() const {
  std::vector<Pose> poses(bodies_.size());
  for (const Body& body : bodies_) {
    poses[body.id] = body.pose();
    poses[body.id].position = wrapped(body.position, input_.bounds, input_.period);
  }
  return poses;
}

}  // namespace packmesh
