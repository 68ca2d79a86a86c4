// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/exports.h"

#include <fmt/format.h>

#include <iterator>

#include "hemocell_adapter/settings/settings.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// "x y z", with any separator; the shortest digits that read back to the same bits.
std::string numbers(const Pose& pose, const char* separator) {
  const Vec3& p = pose.position;
  const Quaternion& q = pose.orientation;
  return fmt::format("{1}{0}{2}{0}{3}{0}{4}{0}{5}{0}{6}{0}{7}", separator, p.x(), p.y(), p.z(), q.w(), q.x(),
                     q.y(), q.z());
}

using Counts = std::vector<std::int64_t>;

std::vector<ExportedFile> csv(const Scene& scene, const Counts&) {
  const auto line = [&scene](const ExportedCell& cell) {
    return fmt::format("{},{},{}\n", cell.number, scene.species[cell.species].name, numbers(cell.pose, ","));
  };
  return {{"cells.csv", {{"id,species,x,y,z,qw,qx,qy,qz\n", line}}}};
}

std::vector<ExportedFile> mirheo(const Scene& scene, const Counts& counts) {
  const auto line = [](const ExportedCell& cell) { return numbers(cell.pose, " ") + "\n"; };
  std::vector<ExportedFile> files;
  for (std::size_t s = 0; s < scene.species.size(); ++s)
    if (counts[s] > 0) files.push_back({scene.species[s].name + ".com_q.txt", {{"", line, int(s)}}});
  return files;
}

std::string atomLine(const ExportedCell& cell) {
  const Vec3& p = cell.pose.position;
  return fmt::format("{} {} 1 1 {} {} {}\n", cell.number, cell.species + 1, p.x(), p.y(), p.z());
}

std::vector<ExportedFile> lammps(const Scene& scene, const Counts& counts) {
  std::int64_t cells = 0;
  std::string types;
  std::vector<Vec3> sizes;
  for (std::size_t s = 0; s < scene.species.size(); ++s) {
    cells += counts[s];
    types += (types.empty() ? "" : ", ") + scene.species[s].name;
    sizes.push_back(boundingBox(scene.species[s].shape->mesh()).size());
  }
  std::string head = fmt::format(
      "packMesh: {} (types in this order), lengths in µm\n\n{} atoms\n{} ellipsoids\n"
      "{} atom types\n\n",
      types, cells, cells, scene.species.size());
  const Box bounds = scene.lumen.container->bounds();
  for (int k = 0; k < 3; ++k)
    head += fmt::format("{0} {1} {2}lo {2}hi\n", bounds.lo[k], bounds.hi[k], "xyz"[k]);
  const auto ellipsoidLine = [sizes](const ExportedCell& cell) {
    const Vec3& size = sizes[cell.species];
    const Quaternion& q = cell.pose.orientation;
    return fmt::format("{} {} {} {} {} {} {} {}\n", cell.number, size.x(), size.y(), size.z(), q.w(), q.x(),
                       q.y(), q.z());
  };
  return {
      {"cells.lammps", {{head + "\nAtoms # ellipsoid\n\n", atomLine}, {"\nEllipsoids\n\n", ellipsoidLine}}}};
}

using Export = std::vector<ExportedFile> (*)(const Scene&, const Counts&);
constexpr Export exports[] = {csv, lammps, mirheo};  // in the order of exportFormats
static_assert(std::size(exports) == std::size(exportFormats));

}  // namespace

std::vector<ExportedFile> exportedFiles(const std::string& format, const Scene& scene,
                                        const std::vector<std::int64_t>& counts) {
  for (std::size_t i = 0; i < std::size(exports); ++i)
    if (format == exportFormats[i]) return exports[i](scene, counts);
  throw InputError("'" + format + "' is not an export format");
}

}  // namespace packmesh::hemocell
