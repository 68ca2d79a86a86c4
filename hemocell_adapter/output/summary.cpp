// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/summary.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/depth_profile.h"
#include "hemocell_adapter/problem/make_species.h"
#include "hemocell_adapter/problem/parts.h"
#include "hemocell_adapter/problem/plan.h"
#include "packMesh/core/version.h"

namespace packmesh::hemocell {

std::string requestText(const CellSpecies& species) {
  if (species.ofRegions > 0) {
    CellSpecies ofLumen = species;
    ofLumen.ofRegions = 0;
    const bool none = species.statedCount && *species.statedCount == 0;
    return none ? "in regions" : fmt::format("{}, {} in regions", requestText(ofLumen), species.ofRegions);
  }
  if (species.statedCount) return fmt::format("{} requested", *species.statedCount);
  if (species.ratio)
    return fmt::format("{:.6g} {} red cell{}", *species.ratio, species.redCell ? "of all" : "per",
                       species.redCell ? "s" : "");
  return "by hematocrit";
}

std::string distanceLine(const CellSpecies& species) {
  return fmt::format("{}: minimum distance from solid {} µm ({})", species.name,
                     species.minimumDistanceFromSolid, species.distanceFromSolidOrigin);
}

const char* keeperText(Loading loading) {
  return loading == Loading::plugIn ? "With loadParticles() HemoCell keeps" : "HemoCell keeps";
}

std::string gapText(double gap, double measuredUpTo) {
  if (std::isinf(gap)) return fmt::format("more than {:g} µm", measuredUpTo);
  return fmt::format("{:.6f} µm", gap);
}

std::string versionLine(int ranks, int threads) {
  const auto counted = [](int n, const char* what) {
    return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
  };
  return fmt::format("packMesh {} ({}), {}{}", version(), gitHash(), counted(ranks, "rank"),
                     threads == 1 ? "" : fmt::format(" with {}", counted(threads, "thread")));
}

std::vector<std::string> lumenLines(const Problem& problem) {
  const Lumen& lumen = problem.lumen;
  std::vector<std::string> lines;
  lines.push_back(
      fmt::format("Lumen: {}{}{}", lumen.container->describe(), lumen.note.empty() ? "" : "; ", lumen.note));
  if (!lumen.scale.empty()) lines.push_back("Scale: " + lumen.scale);
  std::string volumes = fmt::format("Lumen volume: {:.6g} µm³", lumen.container->volume());
  if (lumen.lattice) {
    const auto n = lumen.lattice->nodes();
    volumes += fmt::format("; fluid nodes: {:.6g} µm³ ({} of {} x {} x {} at dx {:.6g} µm)",
                           lumen.lattice->fluidVolume(), lumen.lattice->fluidNodes(), n[0], n[1], n[2],
                           lumen.lattice->dx());
  }
  lines.push_back(volumes);
  for (const OtherLattice& other : lumen.others)
    lines.push_back(
        fmt::format("Also at dx {:.6g} µm: {} fluid nodes of {}; its .pos files {}", other.dx,
                    other.lattice->fluidNodes(), fmt::join(other.lattice->nodes(), " x "),
                    other.shift.isZero() ? "are the same" : fmt::format("are in dx_{:.15g}", other.dx)));
  return lines;
}

namespace {

/// Existing cells, and constraints of cells.
std::vector<std::string> constraintLines(const CellSpecies& s, double wallClearance) {
  std::vector<std::string> lines;
  if (!s.fixedFrom.empty())
    lines.push_back(
        fmt::format("{}: {} of them fixed at their positions in {}", s.name, s.fixed.size(), s.fixedFrom));
  if (s.blood.cells > 0) {
    lines.push_back(fmt::format("{}: {} has {} cells, of which {} copies fit without overlap", s.name,
                                s.startFrom, s.blood.cells, s.start.size()));
  } else if (!s.startFrom.empty()) {
    const std::int64_t room = s.count - std::int64_t(s.fixed.size()), there = std::int64_t(s.start.size());
    lines.push_back(fmt::format("{}: starts from {} of the {} cells of {}", s.name, std::min(room, there),
                                there, s.startFrom));
  }
  std::int64_t deformed = 0;
  for (const auto* const cells : {&s.fixed, &s.start})
    for (const PresentCell& cell : *cells) deformed += cell.shape >= 0;
  if (deformed > 0)
    lines.push_back(fmt::format("{}: {} of these have meshes of their own", s.name, deformed));
  if (s.cone)
    lines.push_back(fmt::format("{}: symmetry axis within {:.15g} degrees of ({:.4g}, {:.4g}, {:.4g})",
                                s.name, s.cone->spread * 180.0 / 3.14159265358979323846, s.cone->axis.x(),
                                s.cone->axis.y(), s.cone->axis.z()));
  if (s.ownWallClearance > wallClearance)
    lines.push_back(fmt::format("{}: {:.15g} µm from the wall", s.name, s.ownWallClearance));
  return lines;
}

/// "; 3 cells keep less, as the minimum gaps show": of the clearances.
std::string closerText(const Certificate& certificate) {
  if (certificate.closer == 0) return {};
  return fmt::format("; {} cell{} less, as the minimum gaps show", certificate.closer,
                     certificate.closer == 1 ? " keeps" : "s keep");
}

/// What is asked for in a region.
std::string regionText(const LumenRegion& region, bool dividesRedCells) {
  std::string text = region.name;
  if (region.count) text = fmt::format("Red cells of {}: {}", region.name, *region.count);
  if (dividesRedCells && region.hematocrit)
    text = fmt::format("Hematocrit of {}: {:.15g}", region.name, *region.hematocrit);
  for (const RegionSpecies& one : region.species)
    text += fmt::format(", {} {} of its own", one.count, one.name);
  return text;
}

}  // namespace

std::string reachedText(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const Tally& tally = packing.tally;
  std::string counts;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    counts += fmt::format("{}{} of {} {}", s ? ", " : "", tally.counts[s], problem.species[s].count,
                          problem.species[s].name);
  }
  if (!packing.whyFewer.empty())
    return fmt::format("{} there is a packing with hematocrit {:.4f} of the {} ({})", packing.whyFewer,
                       tally.redMesh / problem.referenceVolume(),
                       problem.request.fluidVolume ? "fluid nodes" : "lumen", counts);
  const std::string time =
      problem.request.maxSeconds > 0 ? fmt::format(", {}", durationText(problem.request.maxSeconds)) : "";
  const Statistics& done = packing.statistics;
  const std::string limits = fmt::format("limits: {} {}{}; {} done, including the search for fewer cells",
                                         problem.request.maxIterations.value_or(Limits().maxSweeps),
                                         done.unit(), time, done.effort());
  if (packing.cellCount == 0)
    return fmt::format("not feasible within the limits: not even one cell could be packed ({}; {})", counts,
                       limits);
  return fmt::format(
      "not feasible within the limits: {} packed, hematocrit {:.4f} of the {} ({}; {})", counts,
      tally.redMesh / problem.referenceVolume(), problem.request.fluidVolume ? "fluid nodes" : "lumen",
      packing.searched ? "the densest certified packing found"
                       : "a certified packing; the time limit ended the search for the densest",
      limits);
}

std::vector<std::string> deformationLines(const Deformations& all) {
  const Deformation& most = all.most;
  std::string of, others;  // species
  for (const auto& [name, cells] : all.species) {
    const bool first = of.empty() && cells.most.force == most.force;
    if (first)
      of = name;
    else
      others += fmt::format("{}{} {:.2f}", others.empty() ? "" : ", ", name, cells.most.force);
  }
  const std::string species = others.empty() ? "" : fmt::format("{}; {}; ", of, others);
  return {fmt::format("Deformed cells: {}; largest force on a vertex {:.2f} pN ({}median of cells {:.2f} pN)",
                      all.cells, most.force, species, all.median.force),
          fmt::format("Largest changes: volume {:+.2f} %, area {:+.2f} %, triangle {:+.1f} %, edge {:+.1f} %",
                      100.0 * most.volume, 100.0 * most.area, 100.0 * most.triangle, 100.0 * most.edge)};
}

namespace {

/// Where the centres of cells are that have left the regions in which they began.
std::vector<std::string> centreLines(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const std::vector<LumenRegion>& regions = problem.layout.regions;
  std::vector<std::int64_t> counts(regions.size() * problem.species.size());
  for (const PlacedCell& cell : packing.cells)
    ++counts[regionAt(regions, cell.placement.translation) * problem.species.size() + cell.species];
  problem.ranks.sum(counts);
  std::vector<std::string> lines;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    std::string text;
    double redVolume = 0.0;
    for (std::size_t s = 0; s < problem.species.size(); ++s) {
      const std::int64_t here = counts[r * problem.species.size() + s];
      if (problem.species[s].redCell) redVolume += double(here) * problem.species[s].meanVolume;
      text += fmt::format(", {} {}", here, problem.species[s].name);
    }
    lines.push_back(fmt::format("Hematocrit of {}: {:.4f}{} with their centres in it", regions[r].name,
                                redVolume / (problem.referenceVolume() * regions[r].share), text));
  }
  return lines;
}

}  // namespace

std::vector<std::string> regionLines(const Packing& packing) {
  const Problem& problem = *packing.problem;
  if (problem.layout.regions.empty()) return {};
  if (packing.deformed) return centreLines(packing);
  const std::vector<Part>& parts = packing.packed.parts;
  const std::vector<std::int64_t>& counts = packing.partCounts;
  std::vector<std::string> lines;
  const double reference = problem.referenceVolume();
  const bool divides = problem.layout.dividesRedCells();
  for (std::size_t p = 0; p < parts.size(); ++p)
    if (parts[p].region >= 0 && !(divides && problem.species[parts[p].species].redCell))
      lines.push_back(fmt::format("Cells of {} alone: {} {}", problem.layout.regions[parts[p].region].name,
                                  counts[p], problem.species[parts[p].species].name));
  for (std::size_t r = 0; divides && r < problem.layout.regions.size(); ++r) {
    std::int64_t cells = 0;
    double volume = 0.0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const CellSpecies& species = problem.species[parts[p].species];
      if (!species.redCell) continue;
      const std::int64_t here = parts[p].region == int(r) ? counts[p] : 0;
      cells += here;
      volume += double(here) * meanVolume(parts[p].cells, problem.shapes);
      if (!parts[p].cells.freedom.fixed) continue;
      parts[p].cells.forEachStart([&](int shape, const Pose& pose) {
        if (regionAt(problem.layout.regions, pose.position) != int(r)) return;
        ++cells;
        volume += problem.shapes[shape]->volume();
      });
    }
    lines.push_back(fmt::format("Hematocrit of {}: {:.4f}, {} red cells with their centres in it",
                                problem.layout.regions[r].name,
                                volume / (reference * problem.layout.regions[r].share), cells));
  }
  return lines;
}

std::vector<std::string> profileLines(const Problem& problem,
                                      const std::vector<std::vector<double>>& reached) {
  const DepthProfile& profile = *problem.layout.profile;
  std::vector<std::string> lines;
  for (int j = 0; j < profile.shells(); ++j) {
    std::string line =
        fmt::format("Profile, {:.3g} to {:.3g} µm from the wall:", profile.edges[j], profile.edges[j + 1]);
    for (std::size_t s = 0; s < reached.size(); ++s)
      if (!reached[s].empty())
        line += fmt::format("{} {} {:.4f} of {:.4f} requested", line.back() == ':' ? "" : ",",
                            problem.species[s].name, reached[s][j], profile.askedIn(profile.species[s], j));
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<std::string> bloodLines(const Packing& packing, const std::vector<std::int64_t>& deformed) {
  const Problem& problem = *packing.problem;
  const std::vector<Part>& parts = packing.packed.parts;
  const std::vector<std::int64_t>& counts = packing.tally.counts;
  std::vector<std::string> lines;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    if (problem.species[s].blood.cells == 0) continue;
    std::int64_t ofTemplate = counts[s] - deformed[s], own = deformed[s], started = 0;
    for (const Part& part : parts)
      if (part.species == int(s)) started += part.cells.placed();
    started = std::min(started, counts[s]);
    std::int64_t there = 0;
    for (const auto* const cells : {&problem.species[s].start, &problem.species[s].blood.crowded})
      for (const PresentCell& cell : *cells) {
        std::int64_t& left = cell.shape < 0 ? ofTemplate : own;
        if (left == 0 || there == started) continue;
        --left;
        ++there;
      }
    lines.push_back(fmt::format("{}: {} repeated cells of {}, {} more with its meshes, {} with the template",
                                problem.species[s].name, there, problem.request.blood->string(), own,
                                ofTemplate));
  }
  return lines;
}

std::vector<std::string> headLines(const Problem& problem) {
  std::vector<std::string> lines;
  lines.push_back(versionLine(problem.ranks.size(), problem.team.count()));
  if (problem.simulation) lines.push_back(fmt::format("Case: {}", problem.simulation->file.string()));
  for (std::string& line : lumenLines(problem)) lines.push_back(std::move(line));
  if (const auto& discharge = problem.request.dischargeHematocrit)
    lines.push_back(fmt::format(
        "Discharge hematocrit {:.15g}: hematocrit {:.4f} in the lumen, {:.4g} µm in diameter "
        "(Fåhraeus effect, Pries 1990)",
        *discharge, *problem.hematocrit, *hydraulicDiameter(*problem.lumen.container, endAxes(problem))));
  else if (problem.hematocrit) {
    std::string convention = problem.request.redCellVolume ? fmt::format("red cells counted as {:.15g} µm³",
                                                                         *problem.request.redCellVolume)
                                                           : std::string("by mesh volume");
    lines.push_back(fmt::format("Requested hematocrit: {:.15g} of the {}, {}", *problem.hematocrit,
                                problem.request.fluidVolume ? "fluid nodes" : "lumen", convention));
  }
  for (const CellSpecies& species : problem.species) {
    const Vec3 size = boundingBox(species.shape->mesh()).size();
    lines.push_back(fmt::format("{}: {} ({}), {}, {} vertices, {:.4g} x {:.4g} x {:.4g} µm, {:.6g} µm³",
                                species.name, species.count, requestText(species), species.origin,
                                species.shape->mesh().vertices.size(), size[0], size[1], size[2],
                                species.shape->volume()));
    if (species.acceptance) lines.push_back(distanceLine(species));
  }
  for (const CellSpecies& species : problem.species)
    for (const std::string& line : constraintLines(species, problem.demanded.wall)) lines.push_back(line);
  const bool divides = problem.layout.dividesRedCells();
  for (const LumenRegion& region : problem.layout.regions)
    if (divides || !region.species.empty())
      lines.push_back(
          fmt::format("{} ({:.2f} % of the lumen)", regionText(region, divides), 100.0 * region.share));
  if (problem.layout.profile) lines.push_back("Profile: " + problem.layout.profile->source);
  if (problem.request.deforms())
    for (std::string& line : membraneLines(problem)) lines.push_back(std::move(line));
  if (problem.request.inColumns) lines.push_back("Order: cells in columns, not at random");
  if (problem.request.method == Method::cat)
    lines.push_back(fmt::format("Method: growth in the cells of the chordal axis transform, {}",
                                problem.request.cat.planeSource == PlaneSource::catFaces
                                    ? "planes from CAT faces of tetrahedra"
                                    : "planes from chords"));
  const Clearances most = clearanceLevels(problem).front();
  const auto asked = [](bool automatic, double least) {
    return fmt::format("{}{:.15g} µm", automatic && least > 0.0 ? "up to " : "", least);
  };
  lines.push_back(fmt::format("Requested clearance: {} between membranes, {} to the wall; seed {}{}",
                              problem.request.largestClearance
                                  ? "the largest"
                                  : asked(problem.request.choosesClearance(), most.membranes),
                              asked(problem.request.choosesWallClearance(), most.wall), problem.request.seed,
                              problem.request.rotate ? "" : "; no rotation"));
  return lines;
}

std::vector<HematocritConvention> hematocritConventions(const Request& request, const Tally& tally) {
  std::vector<HematocritConvention> all = {{"mesh", "mesh volume (what is simulated)", tally.redMesh}};
  if (tally.redCells > 0 && tally.hemocellKnown)
    all.push_back({"hemocell", "<Volume> of the XML", tally.redHemocell});
  all.push_back(
      {"packCells", "97 µm³ per cell (packCells)", packCellsRedCellVolume * double(tally.redCells)});
  if (request.redCellVolume && *request.redCellVolume != packCellsRedCellVolume)
    all.push_back({"asked", fmt::format("{:.15g} µm³ per cell (as requested)", *request.redCellVolume),
                   *request.redCellVolume * double(tally.redCells)});
  return all;
}

namespace {

/// Whether red cells are counted as packCells counts them.
bool countsAsPackCells(const Request& request) {
  return request.packCellsConventions || request.redCellVolume == packCellsRedCellVolume;
}

}  // namespace

std::vector<std::string> hematocritLines(const Problem& problem, const Tally& tally) {
  const double lumen = problem.lumen.container->volume(), fluid = problem.lumen.fluidVolume();
  std::vector<std::string> lines;
  for (const HematocritConvention& one : hematocritConventions(problem.request, tally)) {
    if (std::string_view(one.key) == "packCells" && !countsAsPackCells(problem.request))
      continue;  // of no use to others
    lines.push_back(fmt::format(
        "Hematocrit {:.4f} of the lumen{} by {}", one.volume / lumen,
        problem.lumen.lattice ? fmt::format(", {:.4f} of the fluid nodes,", one.volume / fluid) : "",
        one.text));
  }
  return lines;
}

namespace {

/// "121 of 121 placed", or "10 placed (6 requested + 4 from the reserve)".
std::string placedText(const CellSpecies& species, std::int64_t placed) {
  if (placed <= species.count) return fmt::format("{} of {} placed", placed, species.count);
  return fmt::format("{} placed ({} requested + {} from the reserve)", placed, species.count,
                     placed - species.count);
}

}  // namespace

std::vector<std::string> footLines(const Packing& packing) {
  const Problem& problem = *packing.problem;
  const Clearances& clearances = packing.packed.clearances;
  const Tally& tally = packing.tally;
  const Certificate& certificate = packing.certificate;
  const Kept& kept = packing.kept;
  const RunTimes& times = packing.times;
  const double lumen = problem.lumen.container->volume();
  std::vector<std::string> lines;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    const CellSpecies& species = problem.species[s];
    lines.push_back(fmt::format("{}: {}, volume fraction {:.5f}", species.name,
                                placedText(species, tally.counts[s]), tally.meshVolume[s] / lumen));
  }
  for (std::string& line : hematocritLines(problem, tally)) lines.push_back(std::move(line));
  if (knowsAcceptance(problem)) {
    std::int64_t all = 0, keeps = 0;
    for (std::size_t s = 0; s < problem.species.size(); ++s) {
      all += tally.counts[s];
      keeps += kept.kept[s];
    }
    std::string text = fmt::format("{} {} of {} cells", keeperText(kept.loading), keeps, all);
    if (keeps < all) {
      for (const auto& [reason, count] : kept.reasons) text += fmt::format("; deletes {}: {}", count, reason);
      if (problem.lumen.keptBox) text += fmt::format(" (nodes at dx {:.6g} µm)", problem.request.dx);
    }
    lines.push_back(text);
  }
  lines.push_back(fmt::format("Certificate: {} ({} cell{}, {} pair{} tested); minimum gap {}",
                              certificate.clean() ? "clean, no overlap" : "not clean", certificate.cells,
                              certificate.cells == 1 ? "" : "s", certificate.pairsTested,
                              certificate.pairsTested == 1 ? "" : "s",
                              gapText(certificate.minimumGap, certificate.gapsMeasuredUpTo)));
  const bool wall = problem.lumen.container->wall() != nullptr;
  if (wall)
    lines.back() += ", to the wall " + gapText(certificate.minimumWallGap, certificate.wallGapsMeasuredUpTo);
  if (clearances.membranes > 0.0 || clearances.wall > 0.0)
    lines.push_back(fmt::format("Clearance kept: {:.6g} µm between membranes{}", clearances.membranes,
                                wall ? fmt::format(", {:.6g} µm to the wall", clearances.wall) : "") +
                    closerText(certificate));
  else if (triesMoreClearance(problem.request))
    lines.push_back("Clearance kept: none beyond the minimum gaps above");
  constexpr double worthSaying = 120.0;  // in minutes and hours as well [s]
  lines.push_back(fmt::format("Time: {:.3f} s CPU, {:.3f} s wall{}; seed {}; packMesh {} ({})", times.cpu,
                              times.wall,
                              times.wall > worthSaying ? fmt::format(" ({})", durationText(times.wall)) : "",
                              problem.request.seed, version(), gitHash()));
  return lines;
}

std::vector<std::string> effortLines(const Statistics& s) {
  std::vector<std::string> lines;
  if (s.engine) {
    lines = s.engine->lines(s);
  } else {
    lines.push_back(
        fmt::format("Packing: {} sweeps, {} rounds of repair; CPU: placement {:.3f} s, relaxation {:.3f} s, "
                    "certificate {:.3f} s",
                    s.sweeps, s.repairs, s.placementSeconds, s.relaxationSeconds, s.certificateSeconds));
  }
  if (s.searching > 0)
    lines.push_back(fmt::format("Search for the densest packing: {} {} more", s.searching, s.unit()));
  return lines;
}

}  // namespace packmesh::hemocell
