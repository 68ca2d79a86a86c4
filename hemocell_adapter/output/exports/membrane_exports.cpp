// SPDX-License-Identifier: AGPL-3.0-or-later
// Initial cells of other programs for membranes in a fluid: Mirheo, ESPResSo, npFEM.
#include <fmt/format.h>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/exports/export_text.h"
#include "hemocell_adapter/output/exports/formats.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/parallel/periodic_images.h"

namespace packmesh::hemocell {
namespace {

constexpr double degree = 3.14159265358979323846 / 180.0;  // [rad]

/// Periods of the lumen; along open ends, which begin half a node below 0, its length [µm].
Vec3 continuedPeriod(const Container& container) {
  const Box bounds = container.bounds();
  Vec3 period = container.period();
  for (int k = 0; k < 3; ++k)
    if (bounds.lo[k] < 0.0) period[k] = bounds.size()[k];
  return period;
}

/// Mirheo leaves out cells whose positions, in single precision, lie outside [0, period).
Vec3 inMirheosDomain(const Vec3& position, const Vec3& period) {
  Vec3 p = wrapped(position, {Vec3::Zero(), period}, period);
  for (int k = 0; k < 3; ++k)
    if (period[k] > 0.0 && float(p[k]) >= float(period[k]))
      p[k] = 0.0;  // the same place, to single precision
  return p;
}

/// `<Cell>_nodes.dat`, `<Cell>_triangles.dat`: ESPResSo counts triangles as oriented if they are clockwise
/// seen from outside.
void addEspressoTemplate(const CellSpecies& species, std::vector<ExportedFile>& files) {
  std::string nodes, triangles;
  for (const Vec3& v : species.shape->mesh().vertices) nodes += numbers(v) + "\n";
  for (const Triangle& t : species.shape->mesh().triangles)
    triangles += fmt::format("{} {} {}\n", t[0], t[2], t[1]);
  files.push_back({species.name + "_nodes.dat", {{nodes}}});
  files.push_back({species.name + "_triangles.dat", {{triangles}}});
}

/// The point of npFEM's template that is the origin of the packed mesh.
/// @throws InputError if the packed mesh is not that template, vertex by vertex
Vec3 originInNpfemsTemplate(const CellSpecies& species) {
  const auto refuse = [&](const char* reason) {
    throw InputError(
        fmt::format("export to npFEM: {} {}; it simulates only its own templates: convert its points to a "
                    "mesh file, and pack that with "
                    "--cell-mesh {} n file --mesh-frame {} file",
                    species.name, reason, species.name, species.name));
  };
  if (species.kind != CellSpecies::Template::mesh) refuse("is not packed from a mesh file");
  if (species.meshFrame != MeshFrame::file || species.meshScale != 1.0) refuse("is turned or scaled");
  const TriangleMesh own = readMesh(species.meshFile);
  const std::vector<Vec3>& packed = species.shape->mesh().vertices;
  if (own.vertices.size() != packed.size()) refuse("has been repaired");
  const Vec3 origin = boundingBox(own).center();
  constexpr double rounding = 1e-9;  // of centring [µm]
  for (std::size_t i = 0; i < packed.size(); ++i)
    if ((own.vertices[i] - origin - packed[i]).cwiseAbs().maxCoeff() > rounding) refuse("has been repaired");
  return origin;
}

/// npFEM's numbers of its two kinds of bodies.
constexpr int npfemRedCell = 0, npfemPlatelet = 1, npfemKinds = 2;

int npfemKind(const CellSpecies& species) {
  if (species.redCell) return npfemRedCell;
  if (species.name.rfind("PLT", 0) == 0) return npfemPlatelet;
  throw InputError(
      fmt::format("export to npFEM: it has red cells and platelets (PLT...) only, not {}", species.name));
}

/// It begins at 0 0 0, and vertices wrap at one lattice spacing less than the fluid.
void requireInNpfemsDomain(const Container& container) {
  const char* hint = "pack a box that ends in walls (--walls xyz), or another lumen without --ends periodic";
  if (container.period() != Vec3::Zero())
    throw InputError(
        fmt::format("export to npFEM: cells must not cross periodic faces, because its vertices and its "
                    "fluid have different "
                    "periods; {}",
                    hint));
  if (container.bounds().lo.minCoeff() < 0.0)
    throw InputError(fmt::format("export to npFEM: its domain begins at 0 0 0, the lumen below; {}", hint));
}

ExportedSection npfemSection(const CellSpecies& species, int s, int kind) {
  const auto line = [kind, origin = originInNpfemsTemplate(species)](const ExportedCell& cell) {
    const PosLine pos = posLineOf(cell.pose);
    return fmt::format("{},{},{}\n", kind, numbers(pos.position - cell.pose.orientation * origin, ","),
                       numbers(pos.angles, ","));
  };
  return {"", line, s};
}

}  // namespace

std::vector<ExportedFile> mirheoExport(const Problem& problem, const CellCounts& counts) {
  const auto line = [period = continuedPeriod(*problem.lumen.container)](const ExportedCell& cell) {
    return numbers(inMirheosDomain(cell.pose.position, period)) + " " + numbers(cell.pose.orientation) + "\n";
  };
  std::vector<ExportedFile> files;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    if (counts[s] == 0) continue;
    files.push_back({problem.species[s].name + ".com_q.txt", {{"", line, int(s)}}});
    files.push_back(templateFile(problem.species[s]));
  }
  return files;
}

std::vector<ExportedFile> espressoExport(const Problem& problem, const CellCounts& counts) {
  const auto line = [](const ExportedCell& cell) {
    const PosLine pos = posLineOf(cell.pose);  // the same order of the same rotations, in radians
    return numbers(pos.position) + " " + numbers(Vec3(pos.angles * degree)) + "\n";
  };
  std::vector<ExportedFile> files;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    if (counts[s] == 0) continue;
    files.push_back({problem.species[s].name + "_origin_rotate.dat", {{"", line, int(s)}}});
    addEspressoTemplate(problem.species[s], files);
  }
  return files;
}

std::vector<ExportedFile> npfemExport(const Problem& problem, const CellCounts& counts) {
  std::vector<ExportedSection> kinds(npfemKinds);  // in this order
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    if (counts[s] == 0) continue;
    const int kind = npfemKind(problem.species[s]);
    if (kinds[kind].text)
      throw InputError(fmt::format(
          "export to npFEM: it has one kind of red cells and one of platelets, but {} is a second",
          problem.species[s].name));
    kinds[kind] = npfemSection(problem.species[s], int(s), kind);
  }
  requireInNpfemsDomain(*problem.lumen.container);
  return {{"npfem_placing.csv", kinds}};
}

}  // namespace packmesh::hemocell
