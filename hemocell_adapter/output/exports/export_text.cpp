// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/exports/export_text.h"

#include <fmt/format.h>

#include "packMesh/core/error.h"

namespace packmesh::hemocell {

std::string numbers(const Vec3& v, const char* separator) {
  return fmt::format("{1}{0}{2}{0}{3}", separator, v.x(), v.y(), v.z());
}

std::string numbers(const Quaternion& q, const char* separator) {
  return fmt::format("{1}{0}{2}{0}{3}{0}{4}", separator, q.w(), q.x(), q.y(), q.z());
}

ExportedFile templateFile(const CellSpecies& species) {
  const TriangleMesh& mesh = species.shape->mesh();
  std::string text = fmt::format("OFF\n{} {} 0\n", mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& v : mesh.vertices) text += numbers(v) + "\n";
  for (const Triangle& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return {species.name + "_template.off", {{text}}};
}

void requireLumenFromZero(const Scene& scene, const std::string& program) {
  const Box bounds = scene.lumen.container->bounds();
  const Vec3 period = scene.lumen.container->period();
  for (int k = 0; k < 3; ++k)
    if (period[k] == 0.0 && bounds.lo[k] < 0.0)
      throw InputError(
          fmt::format("export to {}: its domain begins at 0 0 0, the lumen at {} = {:.6g} µm: move the lumen",
                      program, "xyz"[k], bounds.lo[k]));
}

}  // namespace packmesh::hemocell
