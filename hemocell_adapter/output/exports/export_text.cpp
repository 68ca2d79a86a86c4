// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/exports/export_text.h"

#include <fmt/format.h>

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

}  // namespace packmesh::hemocell
