// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/vessel_lumen.h"

#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "hemocell_adapter/problem/solid.h"
#include "packMesh/container/vessel.h"
#include "packMesh/container/vessel_ends.h"
#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"
#include "packMesh/core/tolerances.h"

namespace packmesh::hemocell {
namespace {

/// A vessel whose surface has no recognisable open ends, or intersects itself: the nodes that HemoCell makes
/// fluid.
/// @param crossing where it intersects itself
/// @param lumen with its notices
Lumen voxelLumen(VesselOnLattice vessel, const std::string& crossing, bool periodic, Lumen lumen) {
  lumen.lattice = std::make_shared<Lattice>(std::move(vessel.lattice));
  lumen.container = makeVoxelLumen(lumen.lattice, {periodic, false, false});
  if (crossing.empty()) {
    lumen.note = fmt::format(
        "the STL has no flat ends perpendicular to x: the lumen consists of HemoCell's fluid nodes, and "
        "the hematocrit refers to their volume; the STL encloses {:.6g} µm³",
        signedVolume(vessel.surface));
  } else {
    lumen.note = "the lumen consists of HemoCell's fluid nodes, and the hematocrit refers to their volume";
    lumen.notices.push_back(crossingText(crossing, vessel.surface, *lumen.container, lumen.lattice->dx()));
  }
  lumen.periodic = periodic;
  lumen.acceptedOnly = true;
  return lumen;
}

/// @throws InputError if the STL does not exist
void requireGeometry(const Domain& domain) {
  if (!isThere(*domain.geometry)) {
    throw InputError(fmt::format(
        "{}: '{}' does not exist. Some HemoCell cases build their lumen in C++ and refer to a missing STL; "
        "describe such a lumen in config.xml, in µm of the .pos files, for example\n"
        "  <packing><container> <cylinder axis=\"x\" radius=\"12.5\" length=\"51.5\" center=\"25.5 13 13\"/> "
        "</container></packing>\n"
        "or <mesh file=\"lumen.stl\" scale=\"1\" openAxis=\"x\"/>, or <box/> with <obstacles>; --reference "
        "lists all elements",
        domain.geometryWhere, domain.geometry->string()));
  }
}

void requireSimple(const VesselMesh& stl, const std::string& where) {
  if (!stl.crossing.empty())
    throw InputError(fmt::format("{}: {}; a pre-inlet needs one that does not", where, stl.crossing));
}

}  // namespace

Lumen vesselLumen(const Request& request, const Case& simulation,
                  const std::optional<PreInletPlace>& preInlet) {
  const Domain& domain = simulation.domain;
  requireGeometry(domain);
  Lumen lumen;
  const std::string where = fmt::format("{}: {}", domain.geometryWhere, domain.geometry->string());
  VesselMesh stl = located(domain.geometryWhere, [&] {
    return readVessel(*domain.geometry, request.capOpenings, tolerance::flatCapFraction, lumen.repairs);
  });
  const bool repaired = !lumen.repairs.empty() && isFilledByParity(stl.asRead);
  const double extent = boundingBox(stl.closed).size()[std::clamp(domain.refDir, 0, 2)];
  VesselOnLattice vessel = located(where, [&] {
    return placeVessel(std::move(stl.closed), domain.dx, domain.refDir, domain.refDirN,
                       repaired ? &stl.asRead : nullptr);
  });
  const double unit = domain.dx * domain.refDirN / extent;
  if (std::string text = cappedText(*domain.geometry, stl.openings, unit); !text.empty())
    lumen.repairs.push_back(std::move(text));
  if (!lumen.repairs.empty()) {
    lumen.repairs.push_back(
        fmt::format("{}: HemoCell reads the file as it is; repair it there too", domain.geometry->string()));
  }
  VesselEnds ends;
  std::string note =
      fmt::format("the volume is that of the STL, {:.6g} µm long, without the continuation of its ends",
                  boundingBox(vessel.surface).size().x());
  if (preInlet) {
    requireSimple(stl, where);
    ends.axis = preInlet->axis;
    PreInlet inlet =
        located(where, [&] { return makePreInlet(vessel, *preInlet, *simulation.preInletLength); });
    note = fmt::format(
        "the pre-inlet: plane {} of nodes along {} ({}), repeated with the fluid nodes of plane "
        "{}; frame of its own",
        inlet.slice, "xyz"[ends.axis], preInlet -> origin, inlet.flags);
    if (inlet.reachesBorder)
      lumen.notices.push_back(fmt::format(
          "the pre-inlet, plane {} of nodes along {}, reaches the border of the lattice: it is "
          "probably not a cross-section of the vessel; are direction and slice those of the case?",
          inlet.slice, "xyz"[ends.axis]));
    vessel.surface = std::move(inlet.surface);
    vessel.lattice = std::move(inlet.lattice);
  }
  if (!preInlet && (!stl.crossing.empty() || !hasFlatEnds(vessel.surface, ends.axis)))
    return voxelLumen(std::move(vessel), stl.crossing.empty() ? "" : where + ": " + stl.crossing,
                      request.periodicEnds.value_or(false), std::move(lumen));
  ends.lo = vessel.lattice.keptRegion().lo[ends.axis];
  ends.hi = vessel.lattice.keptRegion().hi[ends.axis];
  ends.periodic = request.periodicEnds.value_or(false);
  if (ends.periodic && !preInlet)
    note = fmt::format("the volume is that of a period, {:.6g} µm; the STL is {:.6g} µm long",
                       ends.hi - ends.lo, boundingBox(vessel.surface).size().x());
  lumen.lattice = std::make_shared<Lattice>(std::move(vessel.lattice));
  lumen.note = note;
  lumen.container = located(where, [&] { return makeVessel(std::move(vessel.surface), ends, vesselDetail); });
  lumen.periodic = ends.periodic;
  lumen.acceptedOnly = true;
  return lumen;
}

}  // namespace packmesh::hemocell
