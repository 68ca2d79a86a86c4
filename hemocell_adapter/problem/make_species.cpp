// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/make_species.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/problem/other_spacings.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/mesh/self_intersection.h"

namespace packmesh::hemocell {
namespace {

/// Least volume of a deformed cell, as a part of that of the template. HemoCell keeps volumes up to a per
/// mille; in a flat cell distances cannot be sampled.
constexpr double leastVolume = 0.01;

std::shared_ptr<const Shape> makeTemplate(const SpeciesPlan& species, double dx, const Threads& threads,
                                          std::vector<std::string>& repairs) {
  return located(fmt::format("cell '{}'", species.name), [&]() -> std::shared_ptr<const Shape> {
    switch (species.kind) {
      case SpeciesPlan::Template::model:
        return makeShape(species.model, dx, &repairs, threads);
      case SpeciesPlan::Template::mesh:
        return makeShapeFromFile(species.meshFile, species.meshScale, species.meshFrame, dx, repairs,
                                 threads);
      case SpeciesPlan::Template::built:
        return makeShapeOfBuilt(species.builtMesh, species.name, dx, threads);
      case SpeciesPlan::Template::ellipsoid:
        return makeEllipsoid(species.ellipsoidAxes.x(), species.ellipsoidAxes.y(), species.ellipsoidAxes.z());
    }
    return nullptr;
  });
}

/// Everything that determines a template, except dx.
std::string templateKey(const SpeciesPlan& s) {
  const CellModel& m = s.model;
  if (s.kind == SpeciesPlan::Template::built) return s.name;
  return fmt::format("{} {} {} {} {} {} {} '{}' {} '{}'", int(s.meshFrame), int(s.kind), int(m.construction),
                     m.radius, m.minNumTriangles, m.aspectRatio, fmt::join(s.ellipsoidAxes, " "),
                     m.stlFile.string(), s.meshScale, s.meshFile.string());
}

/// Cells that start at the same position cannot be separated, and have a quadratic number of pairs: probably
/// positions that are not in µm.
void refuseHeapedStart(const CellSpecies& species) {
  constexpr std::int64_t leastPairs = 1000, pairsPerCell = 4;
  const double edge =
      0.5 * boundingBox(species.shape->mesh()).size().minCoeff();  // of cubes with one cell or few
  std::map<std::array<double, 3>, std::int64_t> cells;
  std::int64_t pairs = 0;
  for (const PosLine& line : species.start) {
    const Vec3 cube = (line.position / edge).array().floor();
    pairs += cells[{cube.x(), cube.y(), cube.z()}]++;
  }
  const auto count = static_cast<std::int64_t>(species.start.size());
  if (pairs > std::max(leastPairs, pairsPerCell * count))
    throw InputError(
        fmt::format("{}: too many of its {} cells coincide (at least {} pairs nearer than {:.2g} µm) "
                    "to start from; are positions in µm?",
                    species.startFrom, count, pairs, std::sqrt(3.0) * edge));
}

std::string nearText(const PresentCell& cell) {
  return fmt::format("near ({:.6g}, {:.6g}, {:.6g}) µm", cell.position[0], cell.position[1],
                     cell.position[2]);
}

/// Those of some cells with shapes that intersect themselves where they are.
/// @param numbers of the cells @param first number of the first of the shapes
std::vector<std::size_t> findSelfIntersecting(const std::vector<PresentCell>& cells,
                                              const std::vector<std::size_t>& numbers, const Shapes& shapes,
                                              std::size_t first, const Shape& of, const Threads& team) {
  const SelfIntersectionFinder finder(of.mesh());
  std::vector<char> meets(numbers.size(), 0);
  team.forEach(std::int64_t(numbers.size()), [&](std::int64_t i, int) {
    const PresentCell& cell = cells[numbers[i]];
    meets[i] = bool(finder(placedVertices(shapes[cell.shape - first]->mesh(), placementOf(cell))));
  });
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (meets[i]) found.push_back(numbers[i]);
  return found;
}

/// "cells.h5: 2 of its 96 cells 'RBC' intersect themselves, the first ". @param what they are
std::string selfIntersectingText(const CellsOfFile& of, std::size_t found, std::size_t all,
                                 const std::string& species, const char* what) {
  return fmt::format("{}: {} of its {} cells '{}'{} intersect{} {}, the first ", of.file, found, all, species,
                     what, found == 1 ? "s" : "", found == 1 ? "itself" : "themselves");
}

/// A species with its template, and without shapes of its deformed cells.
CellSpecies makeOne(SpeciesPlan plan, std::shared_ptr<const Shape> shape, const Lumen& lumen,
                    std::map<int, std::shared_ptr<const Acceptance>>& acceptances, const Request& request) {
  CellSpecies species(std::move(plan));
  for (const RegionRequest& region : request.regions)
    for (const RegionSpecies& one : region.species)
      if (one.name == species.name) species.ofRegions += one.count;
  species.shape = std::move(shape);
  species.countedVolume = species.meanVolume = species.shape->volume();
  if (species.redCell && request.redCellVolume) species.countedVolume = *request.redCellVolume;
  refuseHeapedStart(species);
  if (!lumen.lattice) return species;
  const int distance = species.minimumDistanceFromSolid;
  std::shared_ptr<const Acceptance>& acceptance = acceptances[distance];
  if (!acceptance) acceptance = std::make_shared<Acceptance>(lumen.lattice, distance);
  species.acceptance = acceptance;
  species.others = otherAcceptances(species, lumen);
  return species;
}

}  // namespace

ShapedCells makeShapes(CellsOfFile of, const std::vector<CellSpecies>& species, std::size_t first,
                       SelfIntersecting selfIntersecting, const Threads& team, Notices& notices) {
  std::vector<std::size_t> own;  // numbers of the cells with vertices
  for (std::size_t i = 0; i < of.cells.size(); ++i) {
    of.cells[i].species = of.species(i);
    if (!of.cells[i].vertices.empty()) own.push_back(i);
  }
  for (const std::size_t i : own)
    if (const CellSpecies& one = species[of.cells[i].species]; one.shape->mesh().triangles != of.triangles(i))
      throw InputError(fmt::format(
          "{}: its cells '{}' have meshes of their own whose triangles are not those of the template",
          of.file, one.name));
  Shapes shapes(own.size());
  team.forEach(std::int64_t(own.size()), [&](std::int64_t k, int) {
    PresentCell& cell = of.cells[own[k]];
    cell.shape = int(first + k);
    shapes[k] = std::make_shared<const Shape>(std::exchange(cell.vertices, {}), species[cell.species].shape);
  });
  for (std::size_t k = 0; k < own.size(); ++k) {
    const CellSpecies& one = species[of.cells[own[k]].species];
    const double volume = shapes[k]->volume(), ofTemplate = one.shape->volume();
    if (volume >= leastVolume * ofTemplate) continue;
    throw InputError(fmt::format(
        "{}: the mesh of a cell '{}' {} is {}", of.file, one.name, nearText(of.cells[own[k]]),
        volume < 0.0 ? "inside out"
                     : fmt::format("flat: it has {:.4g} µm³, the template {:.4g}", volume, ofTemplate)));
  }
  std::map<int, std::vector<std::size_t>> bySpecies;
  if (selfIntersecting != SelfIntersecting::keep)
    for (const std::size_t i : own) bySpecies[of.cells[i].species].push_back(i);
  for (const auto& [s, numbers] : bySpecies) {
    const std::vector<std::size_t> found =
        findSelfIntersecting(of.cells, numbers, shapes, first, *species[s].shape, team);
    if (found.empty()) continue;
    const std::string at = nearText(of.cells[found.front()]);
    if (selfIntersecting == SelfIntersecting::refuse)
      throw InputError(selfIntersectingText(of, found.size(), of.cells.size(), species[s].name, "") +
                       fmt::format("is cell {} {}; fixed cells stay as they are ({} gives such cells the "
                                   "undeformed shape)",
                                   found.front() + 1, at, named("start")));
    notices.warnings.push_back(
        selfIntersectingText(of, found.size(), numbers.size(), species[s].name, " with meshes of their own") +
        fmt::format("{}; {} the undeformed shape", at, found.size() == 1 ? "it gets" : "they get"));
    for (const std::size_t i : found) of.cells[i].shape = -1;
  }
  return {std::move(of.cells), std::move(shapes)};
}

SpeciesAndShapes makeSpecies(std::vector<SpeciesPlan> plans, const Lumen& lumen, const Request& request,
                             const Threads& team, bool packs, Notices& notices) {
  // Species with equal templates share their data.
  std::map<std::string, std::shared_ptr<const Shape>> templates;
  std::map<int, std::shared_ptr<const Acceptance>> acceptances;  // by distance from solid
  SpeciesAndShapes made;
  for (SpeciesPlan& plan : plans) {
    std::shared_ptr<const Shape>& shape = templates[templateKey(plan)];
    if (!shape) shape = makeTemplate(plan, request.dx, team, notices.repairs);
    made.shapes.push_back(shape);
    made.species.push_back(makeOne(std::move(plan), shape, lumen, acceptances, request));
  }
  for (std::size_t s = 0; s < made.species.size(); ++s) {
    CellSpecies& one = made.species[s];
    const auto shaped = [&](std::vector<PresentCell> cells, const std::string& file, SelfIntersecting what) {
      ShapedCells with =
          makeShapes({file, std::move(cells), [s](std::size_t) { return int(s); },
                      [&](std::size_t) -> const std::vector<Triangle>& { return one.ownTriangles; }},
                     made.species, made.shapes.size(), what, team, notices);
      made.shapes.insert(made.shapes.end(), with.shapes.begin(), with.shapes.end());
      return std::move(with.cells);
    };
    one.fixed = shaped(std::move(one.fixed), one.fixedFrom,
                       packs ? SelfIntersecting::refuse : SelfIntersecting::keep);
    one.start = shaped(std::move(one.start), one.startFrom,
                       packs ? SelfIntersecting::undeform : SelfIntersecting::keep);
  }
  return made;
}

namespace {

using TemplateKind = SpeciesPlan::Template;

/// Whether the constants are those of an XML file.
bool hasFile(const CellSpecies& species) {
  const bool reads = species.kind == TemplateKind::model || species.kind == TemplateKind::built;
  return reads && species.model.membrane.constants;
}

}  // namespace

void refuseBesideDeforming(const Request& request) {
  const auto refuse = [](const std::string& other, const char* why) {
    throw UsageError(fmt::format("{} and {} exclude each other: {}", named("soft"), other, why));
  };
  if (request.largestClearance)
    refuse(named("clearance", "max"), "soft cells come to rest at the gaps that they need");
  if (request.inColumns) refuse(named("order", "columns"), "columns are denser without deformation");
  if (!request.alsoDx.empty())
    refuse(named("also-dx"), "a deformed cell has the mesh of one lattice spacing");
}

void requireMembranes(const Scene& scene) {
  for (const CellSpecies& species : scene.species) {
    if (species.count > 0 && !species.rigid && !species.model.membrane.missing.empty())
      throw InputError(
          fmt::format("cell '{}' ({}): <{}> is missing; soft cells need kLink, kBend, kVolume and "
                      "kArea (rigid=\"true\" in <species> keeps the shape)",
                      species.name, species.origin, fmt::join(species.model.membrane.missing, ">, <")));
  }
}

void requireLinkedVertices(const std::vector<CellSpecies>& all) {
  for (const CellSpecies& species : all) {
    if (!hasFile(species) || species.mostCells() == 0) continue;
    const auto vertices = int(species.shape->mesh().vertices.size());
    for (const auto& [a, b] : species.model.membrane.constants->innerLinks)
      if (std::max(a, b) >= vertices)
        throw InputError(
            fmt::format("cell '{}' ({}): <InnerEdges> links the vertices {} and {}; the last one is {}",
                        species.name, species.origin, a, b, vertices - 1));
  }
}

MembraneConstants membraneOf(const Scene& scene, const CellSpecies& species) {
  MembraneConstants constants = hasFile(species) ? *species.model.membrane.constants
                                                 : defaultMembrane(species.name, species.shape->mesh());
  constants.spacing = scene.request.dx;
  if (scene.simulation && scene.simulation->domain.thermalEnergy)
    constants.thermalEnergy = *scene.simulation->domain.thermalEnergy;
  return constants;
}

std::vector<std::string> membraneLines(const Scene& scene) {
  std::vector<std::string> lines;
  for (const CellSpecies& species : scene.species) {
    if (species.count == 0) continue;
    const MembraneConstants m = membraneOf(scene, species);
    lines.push_back(
        species.rigid ? fmt::format("{}: rigid", species.name)
                      : fmt::format("{}: soft, kLink {:.6g}, kBend {:.6g}, kVolume {:.6g}, kArea {:.6g} ({})",
                                    species.name, m.link, m.bend, m.volume, m.area,
                                    hasFile(species) ? species.name + ".xml" : "HemoCell's cell templates"));
  }
  if (scene.simulation && scene.simulation->domain.thermalEnergy)
    lines.push_back(fmt::format("kBT {:.10g} J ({})",
                                *scene.simulation->domain.thermalEnergy / pnMicrometresPerJoule,
                                scene.simulation->domain.thermalEnergyWhere));
  return lines;
}

}  // namespace packmesh::hemocell
