// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/soft_species.h"

#include <fmt/format.h>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/setting_name.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

using Template = SpeciesPlan::Template;

/// Whether the constants are those of an XML file.
bool hasFile(const CellSpecies& species) {
  const bool reads = species.kind == Template::model || species.kind == Template::built;
  return reads && species.model.membrane.constants;
}

}  // namespace

void refuseBesideSoft(const Request& request) {
  const auto refuse = [](const std::string& other, const char* why) {
    throw UsageError(fmt::format("{} and {} exclude each other: {}", named("soft"), other, why));
  };
  if (request.largestClearance)
    refuse(named("clearance", "max"), "soft cells come to rest at the gaps that they need");
  if (request.inColumns) refuse(named("order", "columns"), "columns are denser without deformation");
  if (!request.alsoDx.empty())
    refuse(named("also-dx"), "a deformed cell has the mesh of one lattice spacing");
  if (request.restart)
    refuse(named("restart"), "there are no checkpoints of soft cells; the same command gives the same cells");
}

void requireMembranes(const Scene& scene) {
  for (const CellSpecies& species : scene.species)
    if (species.count > 0 && !species.rigid && !species.model.membrane.missing.empty())
      throw InputError(
          fmt::format("cell '{}' ({}): <{}> is missing; soft cells need kLink, kBend, kVolume and "
                      "kArea (rigid=\"true\" in <species> keeps the shape)",
                      species.name, species.origin, fmt::join(species.model.membrane.missing, ">, <")));
}

MembraneConstants membraneOf(const Scene& scene, const CellSpecies& species) {
  MembraneConstants constants =
      hasFile(species) ? *species.model.membrane.constants : defaultMembrane(species.name);
  constants.spacing = scene.request.dx;
  return constants;
}

std::vector<std::string> softnessLines(const Scene& scene) {
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
  return lines;
}

}  // namespace packmesh::hemocell
