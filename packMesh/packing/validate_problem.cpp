// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/validate_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "packMesh/error.h"

namespace packmesh {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

void checkClearance(double clearance, const char* what) {
  if (!std::isfinite(clearance) || clearance < 0.0)
    throw InputError(std::string("the ") + what + " must be a finite length of at least 0 µm, found " +
                     number(clearance));
}

std::array<double, 3> sortedSizes(const Vec3& size) {
  std::array<double, 3> sizes{size.x(), size.y(), size.z()};
  std::sort(sizes.begin(), sizes.end());
  return sizes;
}

/// A convex body that holds the cell has, turned any way, at least the cell's thinnest extent along every
/// axis and the smallest extents of its bounding box in order: a cell that fails this fits nowhere.
void checkFits(const Species& species, const Container& container, double wallClearance) {
  Vec3 room = container.bounds().size();
  for (int k = 0; k < 3; ++k)
    if (container.period()[k] > 0.0)
      room[k] = std::numeric_limits<double>::infinity();
    else
      room[k] -= 2.0 * wallClearance;
  const double thinnest = sortedSizes(boundingBox(species.shape->mesh()).size())[0];
  if (room.minCoeff() <= 0.5 * thinnest || species.shape->volume() > container.volume())
    throw InputError(
        "a cell of species '" + species.name + "' (" + number(2.0 * species.shape->radius()) + " µm wide, " +
        number(species.shape->volume()) + " µm³) is larger than the lumen (" + container.describe() + ")" +
        (wallClearance > 0.0 ? " less the clearance of " + number(wallClearance) + " µm to the wall" : ""));
}

}  // namespace

double cellVolume(const PackingProblem& problem) {
  double volume = 0.0;
  for (const Species& species : problem.species)
    volume += static_cast<double>(species.count) * species.shape->volume();
  return volume;
}

void validate(const PackingProblem& problem) {
  if (!problem.container) throw InputError("there is no container to pack into");
  checkClearance(problem.clearance, "clearance between cells");
  checkClearance(problem.wallClearance, "clearance to the wall");
  for (const Species& species : problem.species) {
    if (!species.shape) throw InputError("species '" + species.name + "' has no shape");
    if (species.count < 0)
      throw InputError("species '" + species.name + "' has a negative count, " +
                       std::to_string(species.count));
    if (species.count > 0) checkFits(species, *problem.container, problem.wallClearance);
  }
  const double cells = cellVolume(problem), lumen = problem.container->volume();
  if (cells >= lumen)
    throw InputError("the cells have more volume than the lumen: " + number(cells) + " of " + number(lumen) +
                     " µm³");
}

}  // namespace packmesh
