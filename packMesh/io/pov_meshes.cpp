// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/pov_meshes.h"

#include "packMesh/io/pov_camera.h"
#include "packMesh/io/pov_text.h"

namespace packmesh {
namespace {

using namespace pov;

constexpr double samePlane = 0.99999;  ///< cosine of the largest angle between faces that count as one plane
constexpr double darker = 0.35;        ///< brightness of edges relative to their mesh

}  // namespace

void writePovMeshes(const std::filesystem::path& file, const std::vector<PictureMesh>& meshes,
                    const TriangleMesh& container) {
  SceneFile out(file);
  writeHead(out, "Meshes in a container");
  const Vec3 size = boundingBox(container).size();
  std::vector<Extent> extents;
  for (const Vec3& v : container.vertices) extents.push_back({v, 0.0});
  writeCamera(out, extents, size, nullptr);
  for (const PictureMesh& one : meshes) {
    out << "\n";
    writeMesh2(out, *one.mesh, one.edges ? samePlane : crease);
    out << "  texture { pigment { rgb " + vector(one.color) + " transmit " + number(one.transparency) +
               " } finish { specular 0.2 roughness 0.03 } }" +
               (one.transparency > 0.0 ? "\n  no_shadow" : "") + "\n}\n";
    if (!one.edges) continue;
    const Color dark = {darker * one.color[0], darker * one.color[1], darker * one.color[2]};
    writeBars(out, sharpEdges(*one.mesh, samePlane), "pigment { rgb " + vector(dark) + " }",
              0.0009 * size.norm(), size.norm());
  }
  writeGlass(out, container);
  declareRim(out);
  writeBars(out, sharpEdges(container, crease), "Rim", 0.0014 * size.norm(), size.norm());
  out.commit();
}

}  // namespace packmesh
