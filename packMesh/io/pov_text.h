// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Words that scenes for POV-Ray 3.7 are made of. Internal to packMesh/io.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "packMesh/io/scene_file.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::pov {

using Color = std::array<double, 3>;
using Segment = std::pair<Vec3, Vec3>;

/// Seven digits, in any locale.
std::string number(double v);
std::string vector(const Vec3& v);
std::string vector(const Color& c);

/// Cosine of 40°: sharper edges of walls and objects stay sharp and are drawn.
inline constexpr double crease = 0.76;

/// A name that `povray Declare=name=value` sets, and what it is otherwise.
std::string defaultOf(const std::string& name, const std::string& value, const std::string& comment = "");

/// What every scene begins with. @param what it shows
void writeHead(SceneFile& out, const std::string& what);

/// mesh2 with vertex normals smoothed over faces whose normals differ by less than the crease; its texture
/// and the closing brace are left to the caller.
/// @param smooth cosine of the crease angle; -1 smooths everything
void writeMesh2(SceneFile& out, const TriangleMesh& mesh, double smooth);

/// The edges where a surface turns by more than an angle of this cosine: rims of caps, edges of boxes.
std::vector<Segment> sharpEdges(const TriangleMesh& mesh, double cosine);

/// A round bar for each edge that is long enough to be seen.
/// @param size diagonal of all that is shown [µm]
void writeBars(SceneFile& out, const std::vector<Segment>& edges, const std::string& texture, double radius,
               double size);

/// The lumen's surface: nearly clear where it is seen face on, denser towards its outline.
/// @param more modifiers of the object
void writeGlass(SceneFile& out, const TriangleMesh& surface, const std::string& more = "");

/// The texture of edges, "Rim".
void declareRim(SceneFile& out);

}  // namespace packmesh::pov
