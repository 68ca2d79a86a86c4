// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Bodies described by a user: lumens, obstacles and regions.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "hemocell_adapter/problem/lumen.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/container/container.h"
#include "packMesh/mesh/openings.h"

namespace packmesh::hemocell {

/// Whether the faces across an axis are walls. @param walls axes, "yz"
bool hasWall(const std::string& walls, int axis);

/// @throws InputError that begins with `where` if no lattice can have that many nodes
std::array<int, 3> checkedNodes(const Vec3& nodes, const std::string& where);

/// A box of the command line: along periodic axes [0, s], along others the part that HemoCell keeps.
Lumen boxLumen(const Request& request);

/// A case whose lattice is a box of nodes; walls are whole node planes, so the true wall is half a node
/// inside.
Lumen domainBox(const Request& request, const Case& simulation);

/// The fluid nodes of a running HemoCell. Boxes of them are the boxes that domainBox() makes.
Lumen runningLumen(const Request& request, const RunningSystem& running);

/// Spacing at which the distances of vessels are sampled [µm]: fine enough for a wall clearance of some
/// hundredths of a micrometre on smooth walls.
inline constexpr double vesselDetail = 0.5;

/// The closed surface of a vessel.
struct VesselMesh {
  TriangleMesh closed, asRead;          ///< in the unit of the file; asRead: without repairs
  std::vector<CappedOpening> openings;  ///< that are closed
  std::string crossing;                 ///< where the surface intersects itself; empty: nowhere
};

/// What was repaired is added to `repairs`.
/// @param capOpenings close openings that are flat up to `flatness` (see repairClosed)
/// @throws InputError
VesselMesh readVessel(const Source& file, bool capOpenings, double flatness,
                      std::vector<std::string>& repairs);

/// What is said of openings that were closed: their number and areas; empty if there are none.
/// @param unit [µm per unit of their mesh]
std::string cappedText(const std::filesystem::path& file, const std::vector<CappedOpening>& openings,
                       double unit);

/// What is said of a surface that intersects itself, whose lumen is that of the fluid nodes.
/// @param surface [µm]
std::string crossingText(const std::string& crossing, const TriangleMesh& surface, const Container& nodes,
                         double dx);

/// A body as a separate container. Pre: it has a closed surface
/// @param periodic axes along which it is periodic
/// @param capOpenings close flat openings of a mesh
/// @param nodes spacing of the nodes that are the body if its surface intersects itself [µm]; 0: such bodies
/// are errors
std::shared_ptr<const Container> makeSolid(const SolidRequest& solid, const std::array<bool, 3>& periodic,
                                           std::vector<std::string>& repairs, bool capOpenings = false,
                                           double nodes = 0.0);

}  // namespace packmesh::hemocell
