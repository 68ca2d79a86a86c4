// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/exports.h"

#include <fmt/format.h>

#include <iterator>

#include "hemocell_adapter/settings/settings.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// "x y z", with any separator; shortest digits that read back to the same bits.
std::string numbers(const Pose& pose, const char* separator) {
  const Vec3& p = pose.position;
  const Quaternion& q = pose.orientation;
  return fmt::format("{1}{0}{2}{0}{3}{0}{4}{0}{5}{0}{6}{0}{7}", separator, p.x(), p.y(), p.z(), q.w(), q.x(),
                     q.y(), q.z());
}

std::string csvLine(const ExportedPacking& packing, const ExportedCell& cell) {
  return fmt::format("{},{},{}\n", cell.number, packing.species[cell.species].name, numbers(cell.pose, ","));
}

std::vector<ExportedFile> csv(const ExportedPacking&) {
  return {{"cells.csv", {{"id,species,x,y,z,qw,qx,qy,qz\n", csvLine, -1}}}};
}

std::string comLine(const ExportedPacking&, const ExportedCell& cell) {
  return numbers(cell.pose, " ") + "\n";
}

std::vector<ExportedFile> mirheo(const ExportedPacking& packing) {
  std::vector<ExportedFile> files;
  for (std::size_t s = 0; s < packing.species.size(); ++s)
    if (packing.species[s].count > 0)
      files.push_back({packing.species[s].name + ".com_q.txt", {{"", comLine, int(s)}}});
  return files;
}

std::string atomLine(const ExportedPacking&, const ExportedCell& cell) {
  const Vec3& p = cell.pose.position;
  return fmt::format("{} {} 1 1 {} {} {}\n", cell.number, cell.species + 1, p.x(), p.y(), p.z());
}

std::string ellipsoidLine(const ExportedPacking& packing, const ExportedCell& cell) {
  const Vec3& size = packing.species[cell.species].size;
  const Quaternion& q = cell.pose.orientation;
  return fmt::format("{} {} {} {} {} {} {} {}\n", cell.number, size.x(), size.y(), size.z(), q.w(), q.x(),
                     q.y(), q.z());
}

std::vector<ExportedFile> lammps(const ExportedPacking& packing) {
  std::int64_t cells = 0;
  std::string types;
  for (const ExportedSpecies& species : packing.species) {
    cells += species.count;
    types += (types.empty() ? "" : ", ") + species.name;
  }
  std::string head = fmt::format(
      "packMesh: {} (types in this order), lengths in µm\n\n{} atoms\n{} ellipsoids\n"
      "{} atom types\n\n",
      types, cells, cells, packing.species.size());
  for (int k = 0; k < 3; ++k)
    head += fmt::format("{0} {1} {2}lo {2}hi\n", packing.bounds.lo[k], packing.bounds.hi[k], "xyz"[k]);
  return {{"cells.lammps",
           {{head + "\nAtoms # ellipsoid\n\n", atomLine, -1}, {"\nEllipsoids\n\n", ellipsoidLine, -1}}}};
}

using Export = std::vector<ExportedFile> (*)(const ExportedPacking&);
constexpr Export exports[] = {csv, lammps, mirheo};  // in the order of exportFormats
static_assert(std::size(exports) == std::size(exportFormats));

}  // namespace

std::vector<ExportedFile> exportedFiles(const std::string& format, const ExportedPacking& packing) {
  for (std::size_t i = 0; i < std::size(exports); ++i)
    if (format == exportFormats[i]) return exports[i](packing);
  throw InputError("'" + format + "' is no format of an export");
}

}  // namespace packmesh::hemocell
