// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/solid.h"

#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/base/setting_name.h"
#include "hemocell_adapter/hemocell/units.h"
#include "hemocell_adapter/hemocell/voxel_lumen.h"
#include "hemocell_adapter/problem/box_lumen.h"
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
  for (std::string& repair : repairClosed(mesh.closed, file.string(), capOpenings ? &mesh.openings : nullptr,
                                          flatness, &mesh.crossing))
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

/// The nodes in a surface that intersects itself, in the coordinate system of .pos files, as HemoCell fills
/// it: a node is in it if a ray from there crosses it an odd number of times.
std::shared_ptr<const Container> nodesIn(const TriangleMesh& surface, double dx) {
  const Box bounds = boundingBox(surface);
  if (!(bounds.lo.minCoeff() >= 0.0))
    throw InputError(fmt::format(
        "its lumen is that of HemoCell's nodes, which begin at 0, and the surface begins at ({:.6g}, {:.6g}, "
        "{:.6g}) µm; move it by the attribute offset of <mesh>, or join its parts (Boolean union) in a mesh "
        "editor",
        bounds.lo.x(), bounds.lo.y(), bounds.lo.z()));
  TriangleMesh inNodes = surface;
  for (Vec3& v : inNodes.vertices) v /= dx;
  const Vec3 count = (bounds.hi / dx).array().ceil() + 1.0;
  auto lattice = std::make_shared<Lattice>(checkedNodes(count, "a surface that intersects itself"), dx);
  const auto [nx, ny, nz] = lattice->nodes();
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j) lattice->setFluid(0, nx - 1, j, k, false);
  fillInside(*lattice, inNodes);
  return makeVoxelLumen(lattice, {false, false, false});
}

std::shared_ptr<const Container> bodyOf(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                        std::vector<std::string>& repairs, bool capOpenings, double nodes) {
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
    case SolidRequest::Kind::halfSpace:
    case SolidRequest::Kind::beyond:
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
  if (!vessel.crossing.empty()) {
    const std::string what = solid.file.string() + ": " + vessel.crossing;
    if (nodes == 0.0 || solid.openAxis)
      throw MeshError(what + "; join the parts (Boolean union) or remesh them in a mesh editor" +
                      (nodes > 0.0 ? "; without open ends, HemoCell's nodes in it can be packed" : ""));
    std::shared_ptr<const Container> body = located(what, [&] { return nodesIn(mesh, nodes); });
    repairs.push_back(solid.file.string() + ": " + crossingText(vessel.crossing, mesh, *body, nodes));
    return body;
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

std::string crossingText(const std::string& crossing, const TriangleMesh& surface, const Container& nodes,
                         double dx) {
  return fmt::format(
      "{}; the lumen consists of HemoCell's fluid nodes at dx {:.6g} µm, {:.6g} µm³, without what an even "
      "number of parts have in common; the surfaces enclose {:.6g} µm³, what they have in common counted for "
      "each. Join the parts (Boolean union) in a mesh editor to fill all of them",
      crossing, dx, nodes.volume(), signedVolume(surface));
}

std::shared_ptr<const Container> makeSolid(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                           std::vector<std::string>& repairs, bool capOpenings,
                                           double nodes) {
  if (solid.file.given) return bodyOf(solid, periodic, repairs, capOpenings, nodes);  // which messages name
  return located(solid.where, [&] { return bodyOf(solid, periodic, repairs, capOpenings, nodes); });
}

}  // namespace packmesh::hemocell
