// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Red cells in a sphere (thesis figure 4.4) and in a periodic box.
#include <fmt/format.h>

#include "tests/benchmark/growth/packings.h"

namespace packmesh::benchmark {
namespace {

struct Allowed {
  double what, seconds;  ///< number or fraction; 0: none stated
};

std::vector<GrownPacking> spheres(PlaneSource planeSource, const std::vector<Allowed>& counts) {
  std::vector<GrownPacking> out;
  for (const Allowed& of : counts)
    out.push_back({fmt::format("sphere, {} red cells", of.what),
                   [planeSource, count = static_cast<int>(of.what)] {
                     const auto shape = redCell();
                     return grown(shape, count, sphereFor(*shape, count, 0.30), planeSource);
                   },
                   of.seconds});
  return out;
}

std::vector<GrownPacking> boxes(PlaneSource planeSource, const std::vector<Allowed>& fractions) {
  std::vector<GrownPacking> out;
  for (const Allowed& of : fractions)
    out.push_back({fmt::format("periodic box, {:.2f}", of.what),
                   [planeSource, fraction = of.what] { return grownInBox(25.0, fraction, planeSource); },
                   of.seconds});
  return out;
}

const AddCases cases({
    packings("sphere-chords", "red cells in a sphere, coverage 0.30 (thesis figure 4.4), planes from chords",
             spheres(PlaneSource::chords, {{5, 1}, {30, 1}, {128, 5}})),
    packings("sphere-cat-faces", "the same, planes from CAT faces, as in the thesis",
             spheres(PlaneSource::catFaces, {{5, 0}, {30, 0}})),
    packings("box-chords", "red cells in a periodic box of 25 µm, planes from chords",
             boxes(PlaneSource::chords, {{0.30, 0}, {0.40, 0}, {0.45, 2}, {0.50, 5}, {0.55, 0}})),
    packings("box-cat-faces", "the same, planes from CAT faces, as in the thesis",
             boxes(PlaneSource::catFaces, {{0.30, 0}, {0.40, 0}})),
});

}  // namespace
}  // namespace packmesh::benchmark
