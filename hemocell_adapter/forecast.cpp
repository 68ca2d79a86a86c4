// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/forecast.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "packMesh/random.h"

namespace packmesh::hemocell {
namespace {

/// Time of a red cell in a periodic box of 50 µm [ms], by volume fraction: one core at 2.5 GHz, AVX-512.
/// (From 0.60 on 2.5 times what was measured on an EPYC that is 2.5 times as fast.)
struct Measured {
  double fraction, milliseconds;
};
constexpr Measured measured[] = {{0.10, 0.02}, {0.20, 0.025}, {0.30, 0.037}, {0.35, 0.047}, {0.45, 0.085},
                                 {0.50, 0.14}, {0.55, 0.28},  {0.58, 0.75},  {0.60, 3.4},   {0.61, 26.0}};

/// Per tenfold number of cells beyond a thousand: larger packings take more sweeps.
constexpr double growthPerDecade = 0.15;

/// Cells lie along walls less densely than elsewhere, as if a layer of this thickness were empty [µm].
constexpr double emptyLayer = 0.55;

/// Memory [MB]: the program, and a cell in it.
constexpr double ofProgram = 25.0, ofThousandCells = 1.4;

/// Share of efficiency that a further rank has.
constexpr double efficiency = 0.85;

/// Points at which the layer at the wall is measured.
constexpr int points = 50000;

double millisecondsAt(double fraction) {
  const Measured* upper = std::find_if(std::begin(measured), std::end(measured) - 1,
                                       [&](const Measured& m) { return m.fraction >= fraction; });
  if (upper == std::begin(measured)) return upper->milliseconds;
  const Measured* lower = upper - 1;
  const double t = (fraction - lower->fraction) / (upper->fraction - lower->fraction);
  return lower->milliseconds * std::pow(upper->milliseconds / lower->milliseconds, t);
}

/// Share of the lumen that is nearer to its wall than this, by a random sample.
double shareNearWall(const Container& container, double layer) {
  if (!container.wall()) return 0.0;
  const Box bounds = container.bounds();
  int inside = 0, near = 0;
  for (int i = 0; i < points; ++i) {
    const auto u = uniform4(1, RandomStream::position, i, 0);
    const double d =
        container.wall()->distance(bounds.lo + bounds.size().cwiseProduct(Vec3(u[0], u[1], u[2]))).distance;
    inside += d >= 0.0;
    near += d >= 0.0 && d < layer;
  }
  return inside == 0 ? 0.0 : double(near) / inside;
}

std::string duration(double seconds) {
  if (seconds < 1.0) return "less than a second";
  if (seconds < 120.0) return fmt::format("about {:.0f} s", seconds);
  if (seconds < 7200.0) return fmt::format("about {:.0f} min", seconds / 60.0);
  if (seconds < 172800.0) return fmt::format("about {:.0f} h", seconds / 3600.0);
  return fmt::format("about {:.0f} days", seconds / 86400.0);
}

/// What makes a packing harder in a way that nothing is known about.
std::string leftOut(const Job& job, const Scene& scene) {
  std::int64_t fixed = 0;
  bool cones = !job.rotate;
  for (const SceneSpecies& species : scene.species) {
    fixed += std::int64_t(species.job.fixed.size());
    cones = cones || species.job.cone;
  }
  std::vector<std::string> reasons;
  if (fixed > 0) reasons.push_back(fmt::format("that {} cell{} must stay", fixed, fixed == 1 ? "" : "s"));
  if (cones) reasons.push_back("that orientations are bound");
  if (!job.regions.empty()) reasons.push_back("regions denser than the mean");
  return fmt::format("{}", fmt::join(reasons, ", "));
}

}  // namespace

Forecast forecastOf(const Job& job, const Scene& scene) {
  Forecast forecast;
  double volume = 0.0, grown = 0.0, milliseconds = 0.0;
  for (const SceneSpecies& species : scene.species) {
    const double n = double(species.count), own = species.shape->volume();
    forecast.cells += species.count;
    volume += n * own;
    grown += n * (own + 0.5 * job.clearance * surfaceArea(species.shape->mesh()));
  }
  const double lumen = scene.lumen.container->volume();
  forecast.fraction = volume / lumen;
  const double room = 1.0 - shareNearWall(*scene.lumen.container, emptyLayer + job.wallClearance);
  forecast.effectiveFraction = room > 0.0 ? grown / (lumen * room) : 1.0;
  for (const SceneSpecies& species : scene.species) {
    constexpr double redCellVertices = 642.0, fixedShare = 0.3;
    const double vertices = double(species.shape->mesh().vertices.size()) / redCellVertices;
    milliseconds += double(species.count) * (fixedShare + (1.0 - fixedShare) * std::min(vertices, 3.0)) *
                    millisecondsAt(forecast.effectiveFraction);
  }
  const double decades = std::max(0.0, std::log10(double(forecast.cells) / 1000.0));
  forecast.seconds = 1e-3 * milliseconds * (1.0 + growthPerDecade * decades);
  forecast.megabytes = ofProgram + 1e-3 * ofThousandCells * double(forecast.cells);
  return forecast;
}

std::vector<std::string> forecastLines(const Job& job, const Scene& scene, int ranks) {
  const Forecast f = forecastOf(job, scene);
  std::vector<std::string> lines;
  lines.push_back(
      fmt::format("{} cells with {:.4f} of the lumen's volume, as hard to pack as {:.3f} in a periodic box",
                  f.cells, f.fraction, f.effectiveFraction));
  if (job.inColumns)
    lines.push_back(
        "In columns: the box decides what there is room for, up to 0.65 at 50 µm, less in small ones. The "
        "figures below are those of random packings");
  if (f.effectiveFraction <= Forecast::easy)
    lines.push_back(fmt::format("Within reach: {:.3f} below {:.2f}, where packing begins to take long",
                                Forecast::easy - f.effectiveFraction, Forecast::easy));
  else if (f.effectiveFraction <= Forecast::possible)
    lines.push_back(
        fmt::format("At the limit: between {:.2f} and {:.2f} packing takes thousands of sweeps, or fails; "
                    "--max-time and --best-effort bound it{}",
                    Forecast::easy, Forecast::possible, columnsInstead(job, scene)));
  else
    lines.push_back(fmt::format(
        "Probably out of reach: {:.3f} above {:.2f}, the densest that was reached; "
        "--max-time and --best-effort give the densest there is{}",
        f.effectiveFraction - Forecast::possible, Forecast::possible, columnsInstead(job, scene)));
  if (job.method == Method::cat)
    lines.push_back("Time: not known for --method cat; some hundred times that of the default method");
  else if (f.effectiveFraction > Forecast::possible)
    lines.push_back("Time: cannot be told; --max-time bounds it");
  else
    lines.push_back(fmt::format(
        "Time: {} of CPU{}, on a core at 2.5 GHz; known to a factor of 3, at the limit less",
        duration(f.seconds),
        ranks > 1 ? fmt::format(" ({} on {} ranks)", duration(f.seconds / (efficiency * ranks)), ranks)
                  : ""));
  lines.push_back(
      fmt::format("Memory: about {:.0f} MB for each rank", ofProgram + (f.megabytes - ofProgram) / ranks));
  const double tiles = double(job.tiles[0]) * job.tiles[1] * job.tiles[2];
  if (tiles > 1.0)
    lines.push_back(
        fmt::format("Then repeated {} x {} x {} times: {:.0f} cells, about {:.0f} MB in all; the certificate "
                    "of the larger "
                    "box comes on top of the time",
                    job.tiles[0], job.tiles[1], job.tiles[2], tiles * double(f.cells),
                    ofProgram + 1e-3 * ofThousandCells * tiles * double(f.cells)));
  if (const std::string left = leftOut(job, scene); !left.empty())
    lines.push_back(fmt::format("Not in these figures: {}; with them it is harder and takes longer", left));
  if (job.realisations > 1)
    lines.push_back(
        fmt::format("{} realisations, one after the other: each takes this time", job.realisations));
  return lines;
}

}  // namespace packmesh::hemocell
