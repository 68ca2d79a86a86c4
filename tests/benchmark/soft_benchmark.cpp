// SPDX-License-Identifier: AGPL-3.0-or-later
// Packs soft cells and prints what came out, one line per packing: soft_benchmark [words]
//   box <hematocrit> <cells> <seeds>             periodic along all axes
//   tube <diameter> <hematocrit> <length> <seeds>  periodic along x; [µm]
// Without words: the cases of docs/explanation/soft.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hemocell_adapter/hemocell/cell_model.h"
#include "packMesh/certificate/certifier.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/timer.h"
#include "packMesh/soft/soft_packing.h"

namespace packmesh {
namespace {

constexpr double spacing = 0.5;  // [µm]

std::shared_ptr<const Shape> redCell() {
  static const auto shape = hemocell::makeShape(*hemocell::defaultModel("RBC"), spacing);
  return shape;
}

/// @return whether it was certified
bool run(const std::string& name, std::shared_ptr<const Container> lumen, std::int64_t cells,
         std::uint64_t seed) {
  PackingProblem problem;
  problem.physics.container = std::move(lumen);
  problem.physics.seed = seed;
  problem.physics.add("RBC", redCell(), cells);
  const double fraction = double(cells) * redCell()->volume() / problem.physics.container->volume();
  const Timer timer;
  const SoftPacking packed = packSoft(problem, {{hemocell::defaultMembrane("RBC")}}, {});
  const double cpu = timer.cpu();
  fmt::print("{} seed {}: {} cells, {:.3f}; ", name, seed, cells, fraction);
  if (packed.outcome != Outcome::certified) {
    fmt::print("not within the limits: scale {:.3f} after {} iterations, {:.3f} s of CPU per cell\n",
               packed.scale, packed.iterations, cpu / double(cells));
    return false;
  }
  if (packed.cells.empty()) {
    fmt::print("undeformed, {:.4f} s of CPU per cell\n", cpu / double(cells));
    return true;
  }
  const Membrane membrane(redCell()->mesh(), hemocell::defaultMembrane("RBC"));
  std::vector<PlacedCell> placed;
  std::vector<double> forces;
  double volume = 0.0, area = 0.0, triangle = 0.0;
  for (const Cell& cell : packed.cells) {
    placed.push_back({0, std::int32_t(problem.physics.shapes.size()), cell.pose.placement()});
    problem.physics.shapes.push_back(std::make_shared<const Shape>(cell.vertices, redCell()));
    const Deformation deformation = deformationOf(membrane, cell.vertices);
    forces.push_back(deformation.force);
    volume = std::max(volume, std::abs(deformation.volume));
    area = std::max(area, std::abs(deformation.area));
    triangle = std::max(triangle, std::abs(deformation.triangle));
  }
  std::sort(forces.begin(), forces.end());
  const Certificate certificate = certify(certificateInputOf(problem.physics, placed));
  fmt::print(
      "{}, gaps {:.3f} and {:.3f} µm, force {:.2f} (median {:.2f}) pN, volume {:.2f} %, area {:.1f} %, "
      "triangle "
      "{:.0f} %, {} iterations, {:.4f} s of CPU per cell\n",
      certificate.clean() ? "certified" : "NOT CERTIFIED", certificate.minimumGap, certificate.minimumWallGap,
      forces.back(), forces[forces.size() / 2], 100.0 * volume, 100.0 * area, 100.0 * triangle,
      packed.iterations, cpu / double(cells));
  return certificate.clean();
}

int box(double hematocrit, std::int64_t cells, int seeds) {
  const double side = std::cbrt(double(cells) * redCell()->volume() / hematocrit);
  int failures = 0;
  for (int seed = 1; seed <= seeds; ++seed)
    failures += !run(fmt::format("box {}", hematocrit),
                     makeBox(Box{Vec3::Zero(), Vec3::Constant(side)}, {true, true, true}), cells,
                     std::uint64_t(seed));
  return failures;
}

int tube(double diameter, double hematocrit, double length, int seeds) {
  const double radius = 0.5 * diameter;
  const auto cells = std::llround(hematocrit * M_PI * radius * radius * length / redCell()->volume());
  int failures = 0;
  for (int seed = 1; seed <= seeds; ++seed)
    failures +=
        !run(fmt::format("tube {} µm, {}", diameter, hematocrit),
             makeCylinder(Vec3(0.5 * length, 0, 0), 0, radius, length, true), cells, std::uint64_t(seed));
  return failures;
}

int all() {
  int failures = 0;
  for (const double hematocrit : {0.65, 0.75, 0.85, 0.90}) failures += box(hematocrit, 87, 5);
  for (const double diameter : {4.0, 5.0, 6.0, 8.0})
    for (const double hematocrit : {0.2, 0.3, 0.45}) failures += tube(diameter, hematocrit, 60.0, 5);
  return failures;
}

}  // namespace
}  // namespace packmesh

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const auto number = [&](std::size_t k) { return std::strtod(words[k].c_str(), nullptr); };
  if (words.empty()) return packmesh::all() > 0;
  if (words[0] == "box" && words.size() == 4)
    return packmesh::box(number(1), std::llround(number(2)), int(number(3))) > 0;
  if (words[0] == "tube" && words.size() == 5)
    return packmesh::tube(number(1), number(2), number(3), int(number(4))) > 0;
  fmt::print(stderr,
             "soft_benchmark [box <hematocrit> <cells> <seeds> | tube <diameter> <hematocrit> <length> "
             "<seeds>]\n");
  return 1;
}
