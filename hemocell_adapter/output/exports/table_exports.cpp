// SPDX-License-Identifier: AGPL-3.0-or-later
// Formats of no particular program: CSV, STL.
#include <fmt/format.h>

#include <cstring>
#include <limits>

#include "hemocell_adapter/output/exports/export_text.h"
#include "hemocell_adapter/output/exports/formats.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

template <class T>
void appendBytes(std::string& to, const T& value) {
  static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "STL files are little-endian");
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  to.append(bytes, sizeof value);
}

void appendVector(std::string& to, const Vec3& v) {
  for (int k = 0; k < 3; ++k) appendBytes(to, float(v[k]));
}

/// Normal, corners and attribute of each triangle.
std::string stlTriangles(const TriangleMesh& mesh, const Placement& placement) {
  const std::vector<Vec3> vertices = placedVertices(mesh, placement);
  std::string text;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = vertices[t[0]], &b = vertices[t[1]], &c = vertices[t[2]];
    appendVector(text, (b - a).cross(c - a).stableNormalized());
    for (const Vec3& corner : {a, b, c}) appendVector(text, corner);
    appendBytes(text, std::uint16_t{0});
  }
  return text;
}

}  // namespace

std::vector<ExportedFile> csvExport(const Problem& problem, const CellCounts& counts) {
  const Container& container = *problem.lumen.container;
  const Box bounds = container.bounds();
  const std::string head = fmt::format(
      "# lengths: µm\n# box: {} {}\n# period: {}\n# vertex: the quaternion rotates a vertex of "
      "<species>_template.off, then x, y, z is added\nid,species,x,y,z,qw,qx,qy,qz\n",
      numbers(bounds.lo), numbers(bounds.hi), numbers(container.period()));
  const auto line = [&problem](const ExportedCell& cell) {
    return fmt::format("{},{},{},{}\n", cell.number(), problem.species[cell.species].name,
                       numbers(cell.pose.position, ","), numbers(cell.pose.orientation, ","));
  };
  std::vector<ExportedFile> files = {{"cells.csv", {{head, line}}}};
  for (std::size_t s = 0; s < problem.species.size(); ++s)
    if (counts[s] > 0) files.push_back(templateFile(problem.species[s]));
  return files;
}

std::vector<ExportedFile> stlExport(const Problem& problem, const CellCounts& counts) {
  std::int64_t triangles = 0;
  for (std::size_t s = 0; s < problem.species.size(); ++s)
    triangles += counts[s] * std::int64_t(problem.species[s].shape->mesh().triangles.size());
  if (triangles > std::numeric_limits<std::uint32_t>::max())
    throw InputError(
        fmt::format("export to STL: {} triangles are more than such a file can have", triangles));
  std::string head = "packMesh: all membranes, lengths in micrometres";
  head.resize(80, ' ');  // as the format wants it
  appendBytes(head, std::uint32_t(triangles));
  const auto facets = [&problem](const ExportedCell& cell) {
    return stlTriangles(problem.species[cell.species].shape->mesh(), cell.placement);
  };
  return {{"cells.stl", {{head, facets}}}};
}

}  // namespace packmesh::hemocell
