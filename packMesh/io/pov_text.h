// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Elements of POV-Ray 3.7 scenes. Internal to packMesh/io.
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

/// Seven digits, independent of the locale.
std::string number(double v);
std::string vector(const Vec3& v);
std::string vector(const Color& c);

/// Cosine of 40°: edges of walls and objects with a larger angle remain sharp and are drawn.
inline constexpr double crease = 0.76;

/// Default of a name that `povray Declare=name=value` can set.
std::string defaultOf(const std::string& name, const std::string& value, const std::string& comment = "");

/// Beginning of every scene. @param what title
void writeHead(SceneFile& out, const std::string& what);

/// mesh2 with vertex normals averaged over faces whose normals differ by less than the crease angle; the
/// caller adds the texture and the closing brace.
/// @param smooth cosine of the crease angle; -1 smooths everything
void writeMesh2(SceneFile& out, const TriangleMesh& mesh, double smooth);

/// Edges at which a surface turns by more than the angle with this cosine: rims of caps, edges of boxes.
std::vector<Segment> sharpEdges(const TriangleMesh& mesh, double cosine);

/// A round bar for each edge long enough to be visible.
/// @param size diagonal of the scene [µm]
void writeBars(SceneFile& out, const std::vector<Segment>& edges, const std::string& texture, double radius,
               double size);

/// The lumen's surface: nearly transparent face-on, denser towards its outline.
/// @param more modifiers of the object
void writeGlass(SceneFile& out, const TriangleMesh& surface, const std::string& more = "");

/// The texture of edges, "Rim".
void declareRim(SceneFile& out);

}  // namespace packmesh::pov
