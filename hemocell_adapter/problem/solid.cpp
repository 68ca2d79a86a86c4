// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/solid.h"

#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/container/primitives.h"
#include "packMesh/container/vessel.h"
#include "packMesh/core/error.h"
#include "packMesh/core/tolerances.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"

namespace packmesh::hemocell {

VesselMesh readVessel(const Source& file, bool capOpenings, double flatness,
                      std::vector<std::string>& repairs) {
  VesselMesh mesh;
  mesh.asRead = mesh.closed = meshFrom(file, &repairs);
  for (std::string& repair :
       repairClosed(mesh.closed, file.string(), capOpenings ? &mesh.openings : nullptr, flatness))
    repairs.push_back(std::move(repair));
  return mesh;
}

std::string cappedText(const std::filesystem::path& file, const std::vector<CappedOpening>& openings,
                       double unit) {
  if (openings.empty()) return {};
  std::vector<std::string> areas;
  for (const CappedOpening& opening : openings) {
    areas.push_back(fmt::format("{:.6g} µm²", opening.area * unit * unit));
    if (opening.deviation > 0.0)
      areas.back() += fmt::format(", its edges within {:.2g} µm of a plane", opening.deviation * unit);
  }
  return fmt::format(
      "{}: capped {} flat opening{} ({}); " + named("flat-openings", "refuse") + " makes them errors",
      file.string(), openings.size(), openings.size() == 1 ? "" : "s", fmt::join(areas, "; "));
}

namespace {

std::shared_ptr<const Container> bodyOf(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                        std::vector<std::string>& repairs, bool capOpenings) {
  switch (solid.kind) {
    case SolidRequest::Kind::box:
      return makeBox({solid.origin, solid.origin + solid.size}, periodic);
    case SolidRequest::Kind::cylinder: {
      Vec3 corner = Vec3::Constant(solid.radius);
      corner[solid.axis] = 0.5 * solid.length;
      return makeCylinder(solid.center.value_or(corner), solid.axis, solid.radius, solid.length,
                          periodic[solid.axis]);
    }
    case SolidRequest::Kind::sphere:
      return makeSphere(solid.center.value_or(Vec3::Constant(solid.radius)), solid.radius);
    case SolidRequest::Kind::mesh:
      break;
  }
  VesselMesh vessel = readVessel(solid.file, capOpenings, tolerance::flatHoleFraction, repairs);
  if (std::string text = cappedText(solid.file.file, vessel.openings, solid.scale); !text.empty())
    repairs.push_back(std::move(text));
  TriangleMesh mesh = std::move(vessel.closed);
  for (Vec3& v : mesh.vertices) v = solid.scale * v + solid.origin;
  const Box bounds = boundingBox(mesh);
  if (const double reach = std::max(bounds.hi.maxCoeff(), -bounds.lo.minCoeff());
      reach > specs::largestLength) {
    throw InputError(
        fmt::format("{}: with the factor {:.6g} it reaches {:.3g} µm from the origin, at most {:.0f} µm "
                    "are possible; is the unit right?{}",
                    solid.file.string(), solid.scale, reach, specs::largestLength,
                    unitHint(bounds.size().maxCoeff(), solid.scale, smallestVessel, largestVessel)));
  }
  std::optional<VesselEnds> ends;
  if (solid.openAxis) {
    ends.emplace();
    ends->axis = *solid.openAxis;
    ends->lo = bounds.lo[ends->axis];
    ends->hi = bounds.hi[ends->axis];
    ends->periodic = periodic[ends->axis];
  }
  return makeVessel(std::move(mesh), ends, vesselDetail);
}

}  // namespace

std::shared_ptr<const Container> makeSolid(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                           std::vector<std::string>& repairs, bool capOpenings) {
  if (solid.file.given) return bodyOf(solid, periodic, repairs, capOpenings);  // which messages name
  return located(solid.where, [&] { return bodyOf(solid, periodic, repairs, capOpenings); });
}

}  // namespace packmesh::hemocell
