// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Time and memory of whole packings, as a Markdown table; see usage() below.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

#include "packMesh/core/version.h"
#include "tests/support/packings.h"
#if PACKMESH_CAT
#include "tests/support/cat.h"
#endif

using namespace packmesh;

namespace {

void usage() {
  std::puts(
      "packing_benchmark [pattern ...] [--list] [--seeds n] [--max-seconds s] [--json file]\n"
      "  pattern          runs the cases whose name contains a match of one of these regular expressions;\n"
      "                   without any, those marked quick\n"
      "  --list           names the cases\n"
      "  --seeds n        runs every case with seeds 1 to n; times are means, the outcome a rate of success\n"
      "  --max-seconds s  wall time after which a packing gives up [s]\n"
      "  --json file      writes the same figures for scripts");
}

/// One packing, described so that a child process can build it.
struct Case {
  std::string name;
  std::function<PackingProblem()> problem;
  bool quick = false;
  int seeds = 1;
  double maxSeconds = 0.0;
};

PackingProblem cube(double edge, double fraction) {
  return test::redCellProblem(test::periodicCube(edge), fraction);
}

PackingProblem columns(double edge, double fraction) {
  PackingProblem problem = cube(edge, fraction);
  problem.physics.species[0].inColumns = true;
  return problem;
}

PackingProblem cylinder(double fraction) {
  return test::redCellProblem(makeCylinder(Vec3(25.0, 0.0, 0.0), 0, 12.5, 50.0, true), fraction);
}

/// Whole blood: platelets 7 for 100 red cells, two white cells.
PackingProblem wholeBlood() {
  PackingProblem problem = cube(49.0, 0.40);
  const auto platelets = std::int64_t(0.07 * double(problem.physics.species[0].count));
  problem.physics.add("PLT", test::hemocellShape("PLT"), platelets);
  problem.physics.add("WBC", test::hemocellShape("WBC"), 2);
  return problem;
}

PackingProblem apart() {
  PackingProblem problem = cube(50.0, 0.40);
  problem.physics.clearance = 0.25;
  return problem;
}

/// A cell without a closed form: an oval biconcave disc with a thick end, 1502 vertices.
TriangleMesh ovalCell() {
  TriangleMesh mesh = sample::sphere(Vec3::Zero(), 1.0, 31, 50);
  for (Vec3& v : mesh.vertices) {
    const double r2 = v.head<2>().squaredNorm(), thickness = 0.12 + 1.0 * r2 - 0.55 * r2 * r2;
    v = 3.6 * Vec3(1.15 * v.x(), thickness * (1.0 + 0.15 * v.x()) * v.z(), -v.y());
  }
  return mesh;
}

PackingProblem ovalCells(double fraction) {
  PackingProblem problem = cube(50.0, fraction);
  const auto shape = std::make_shared<Shape>(ovalCell());
  problem.physics.species.clear();
  problem.physics.add("oval", shape,
                      std::int64_t(fraction * problem.physics.container->volume() / shape->volume()));
  return problem;
}

PackingProblem grown(double edge, double fraction) {
  PackingProblem problem = cube(edge, fraction);
#if PACKMESH_CAT
  test::useCat(problem);
#endif
  return problem;
}

std::vector<Case> allCases() {
  std::vector<Case> cases;
  for (const double edge : {50.0, 100.0})
    for (const double fraction : {0.35, 0.45, 0.50, 0.55, 0.58})
      cases.push_back({fmt::format("box{:.0f}-{:.2f}", edge, fraction), [=] { return cube(edge, fraction); },
                       edge < 60.0 || fraction < 0.52});
  for (const double fraction : {0.60, 0.62})
    cases.push_back(
        {fmt::format("box50-{:.2f}", fraction), [=] { return cube(50.0, fraction); }, false, 1, 300.0});
  for (const double fraction : {0.55, 0.58, 0.60, 0.62, 0.64, 0.65})
    cases.push_back(
        {fmt::format("columns50-{:.2f}", fraction), [=] { return columns(50.0, fraction); }, true});
  for (const double fraction : {0.50, 0.55})
    cases.push_back({fmt::format("cylinder-{:.2f}", fraction), [=] { return cylinder(fraction); }, true});
  for (const double fraction : {0.40, 0.50})
    cases.push_back({fmt::format("sphere-{:.2f}", fraction),
                     [=] { return test::redCellProblem(makeSphere(Vec3::Zero(), 20.0), fraction); }, true});
  cases.push_back({"oval50-0.45", [] { return ovalCells(0.45); }, true});
  cases.push_back({"cat20-0.35", [] { return grown(20.0, 0.35); }, true});
  cases.push_back({"blood49-0.40", wholeBlood, true});
  cases.push_back({"apart50-0.40", apart, true});
  cases.push_back({"memory200-0.45", [] { return cube(200.0, 0.45); }});
  for (const double edge : {25.0, 50.0})
    for (const double fraction : {0.35, 0.45, 0.55})
      cases.push_back({fmt::format("rate{:.0f}-{:.2f}", edge, fraction), [=] { return cube(edge, fraction); },
                       false, 20, 60.0});
  return cases;
}

/// What one packing took; goes through a pipe as it is.
struct Figures {
  std::int64_t wanted, cells, sweeps, repairs;                      ///< sweeps, or iterations of growth
  double fraction, gap, placement, relaxation, certificate, total;  ///< CPU time [s]
  int outcome;
  double peakBytes;  ///< filled in by the parent
};

double cpuSeconds() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

Figures measure(const Case& c, std::uint64_t seed, double maxSeconds, bool onlyOneCell) {
  PackingProblem problem = c.problem();
  problem.physics.seed = seed;
  problem.execution.limits.maxSeconds = maxSeconds;
  if (onlyOneCell)
    for (Species& species : problem.physics.species) species.count = 1;
  Figures f{};
  for (const Species& species : problem.physics.species) f.wanted += species.count;
  const double start = cpuSeconds();
  const PackingResult result = pack(problem);
  f.total = cpuSeconds() - start;
  f.cells = std::int64_t(result.cells.size());
  f.sweeps = result.statistics.sweeps;
  f.repairs = result.statistics.repairs;
  f.fraction = result.certificate.cellVolume / problem.physics.container->volume();
  f.gap = result.certificate.minimumGap;
  f.placement = result.statistics.placementSeconds;
  f.relaxation = result.statistics.relaxationSeconds + result.statistics.engineSeconds;
  if (result.statistics.engine) f.sweeps = result.statistics.engine->iterations();
  f.certificate = result.statistics.certificateSeconds;
  f.outcome = int(result.outcome);
  return f;
}

/// measure() in a process of its own, so that the peak of memory is that of this packing.
Figures measureInChild(const Case& c, std::uint64_t seed, double maxSeconds, bool onlyOneCell = false) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no child process");
  if (child == 0) {
    close(ends[0]);
    try {
      const Figures f = measure(c, seed, maxSeconds, onlyOneCell);
      _exit(write(ends[1], &f, sizeof f) == static_cast<ssize_t>(sizeof f) ? 0 : 1);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", c.name.c_str(), error.what());
    }
    _exit(1);
  }
  close(ends[1]);
  Figures f{};
  const ssize_t got = read(ends[0], &f, sizeof f);
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (got != static_cast<ssize_t>(sizeof f) || status != 0) throw std::runtime_error(c.name + " failed");
  f.peakBytes = 1024.0 * double(usage.ru_maxrss);
  return f;
}

void printHead() {
  std::puts(
      "| case | cells | fraction | sweeps | repairs | placement (ms/cell) | relaxation (ms/cell) | "
      "certificate (ms/cell) | total (ms/cell) | CPU (s) | peak (MB) | per cell (bytes) | "
      "smallest gap (µm) | outcome |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |");
}

/// Prints the means and gives them back for scripts.
nlohmann::ordered_json printRow(const Case& c, const std::vector<Figures>& runs, double baseBytes) {
  Figures mean{};
  double sweeps = 0.0, repairs = 0.0, gap = runs[0].gap;
  int certified = 0;
  for (const Figures& f : runs) {
    mean.cells += f.cells;
    mean.wanted += f.wanted;
    sweeps += double(f.sweeps);
    repairs += double(f.repairs);
    mean.fraction += f.fraction;
    mean.placement += f.placement;
    mean.relaxation += f.relaxation;
    mean.certificate += f.certificate;
    mean.total += f.total;
    mean.peakBytes = std::max(mean.peakBytes, f.peakBytes);
    gap = std::min(gap, f.gap);
    certified += f.outcome == int(Outcome::certified);
  }
  const double n = double(runs.size()), cells = std::max<double>(1.0, mean.cells);
  const auto perCell = [&](double seconds) { return 1e3 * seconds / cells; };
  std::string outcome = fmt::format("{}/{} certified", certified, runs.size());
  if (runs.size() == 1)
    outcome = certified ? "certified" : fmt::format("not feasible; {} cells requested", mean.wanted);
  fmt::print(
      "| {} | {:.0f} | {:.4f} | {:.0f} | {:.1f} | {:.4f} | {:.4f} | {:.4f} | "
      "{:.4f} | {:.3f} | {:.1f} | {:.0f} | {:.4f} | {} |\n",
      c.name, mean.cells / n, mean.fraction / n, sweeps / n, repairs / n, perCell(mean.placement),
      perCell(mean.relaxation), perCell(mean.certificate), perCell(mean.total), mean.total / n,
      mean.peakBytes / 1e6, (mean.peakBytes - baseBytes) * n / cells, gap, outcome);
  std::fflush(stdout);
  return {{"case", c.name},
          {"seeds", runs.size()},
          {"certified", certified},
          {"cells", mean.cells / n},
          {"fraction", mean.fraction / n},
          {"sweeps", sweeps / n},
          {"repairs", repairs / n},
          {"msPerCell",
           {{"placement", perCell(mean.placement)},
            {"relaxation", perCell(mean.relaxation)},
            {"certificate", perCell(mean.certificate)},
            {"total", perCell(mean.total)}}},
          {"cpuSeconds", mean.total / n},
          {"peakBytes", mean.peakBytes},
          {"bytesPerCell", (mean.peakBytes - baseBytes) * n / cells},
          {"smallestGap", std::isfinite(gap) ? nlohmann::ordered_json(gap) : nlohmann::ordered_json()}};
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::regex> patterns;
  bool list = false;
  int seeds = 0;
  double maxSeconds = 0.0;
  std::string jsonFile;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  try {
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument == "--list") {
        list = true;
      } else if (argument == "--help") {
        usage();
        return 0;
      } else if ((argument == "--seeds" || argument == "--max-seconds") && i + 1 < argc) {
        (argument == "--seeds" ? seeds = std::stoi(argv[i + 1]) : maxSeconds = std::stod(argv[i + 1]));
        ++i;
      } else if (argument == "--json" && i + 1 < argc) {
        jsonFile = argv[++i];
      } else if (argument.rfind("--", 0) == 0) {
        usage();
        return 2;
      } else {
        patterns.emplace_back(argument);
      }
    }
    if (!list) printHead();
    for (const Case& c : allCases()) {
      const bool matches = std::any_of(patterns.begin(), patterns.end(), [&](const std::regex& pattern) {
        return std::regex_search(c.name, pattern);
      });
      if (list) fmt::print("{}{}\n", c.name, c.quick ? " (quick)" : "");
      if (list || !(patterns.empty() ? c.quick : matches)) continue;
      const double limit = maxSeconds > 0.0 ? maxSeconds : c.maxSeconds;
      const double baseBytes = measureInChild(c, 1, limit, true).peakBytes;
      std::vector<Figures> runs;
      for (int seed = 1; seed <= (seeds > 0 ? seeds : c.seeds); ++seed)
        runs.push_back(measureInChild(c, seed, limit));
      rows.push_back(printRow(c, runs, baseBytes));
    }
    if (!list && rows.empty()) throw std::runtime_error("no case matches (--list names them)");
    if (!jsonFile.empty()) {
      std::ofstream out(jsonFile);
      out << nlohmann::ordered_json{{"packMesh", version()}, {"cases", rows}}.dump(2) << "\n";
      if (!out) throw std::runtime_error(jsonFile + " cannot be written");
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
