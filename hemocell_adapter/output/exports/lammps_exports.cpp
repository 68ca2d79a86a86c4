// SPDX-License-Identifier: AGPL-3.0-or-later
// Data files for LAMMPS (read_data): ellipsoids, and molecules of vertices.
#include <fmt/format.h>

#include <array>
#include <limits>

#include "hemocell_adapter/output/exports/export_text.h"
#include "hemocell_adapter/output/exports/formats.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

/// The first line, which LAMMPS skips.
std::string title(const Problem& problem) {
  const Vec3 period = problem.lumen.container->period();
  std::string types;
  for (const CellSpecies& species : problem.species) types += (types.empty() ? "" : ", ") + species.name;
  std::string text = fmt::format("packMesh: types {}; lengths in micrometres; boundary", types);
  for (int k = 0; k < 3; ++k) text += period[k] > 0.0 ? " p" : " f";
  return text + "\n\n";
}

std::string boxLines(const Problem& problem) {
  const Box bounds = problem.lumen.container->bounds();
  std::string text;
  for (int k = 0; k < 3; ++k)
    text += fmt::format("{0} {1} {2}lo {2}hi\n", bounds.lo[k], bounds.hi[k], "xyz"[k]);
  return text;
}

/// Pairs of vertices and of triangles that meet at each edge of a template.
struct Edges {
  std::vector<std::array<int, 2>> bonds;
  /// Opposite corner of the triangle that has the edge in its direction, the edge, opposite corner of the
  /// other triangle: as seen from outside, all dihedrals have the same sense.
  std::vector<std::array<int, 4>> dihedrals;
};

Edges edgesOf(const TriangleMesh& mesh) {
  const std::vector<TriangleSide> sides = sortedSides(mesh);
  const auto opposite = [&](const TriangleSide& side) {
    const Triangle& t = mesh.triangles[side.triangle];
    return t[0] + t[1] + t[2] - side.lo - side.hi;
  };
  Edges edges;
  for (std::size_t i = 0; i + 1 < sides.size();
       i += 2) {  // closed and oriented: two sides, one of each direction
    const TriangleSide& along = sides[i].forwards ? sides[i] : sides[i + 1];
    const TriangleSide& against = sides[i].forwards ? sides[i + 1] : sides[i];
    edges.bonds.push_back({along.lo, along.hi});
    edges.dihedrals.push_back({opposite(along), along.lo, along.hi, opposite(against)});
  }
  return edges;
}

/// What the cells of each species consist of.
struct Network {
  std::vector<Edges> edges;
  std::vector<std::int64_t> atomsPerCell, edgesPerCell, trianglesPerCell;
};

Network networkOf(const Problem& problem) {
  Network network;
  for (const CellSpecies& species : problem.species) {
    const TriangleMesh& mesh = species.shape->mesh();
    network.edges.push_back(edgesOf(mesh));
    network.atomsPerCell.push_back(std::int64_t(mesh.vertices.size()));
    network.edgesPerCell.push_back(std::int64_t(network.edges.back().bonds.size()));
    network.trianglesPerCell.push_back(std::int64_t(mesh.triangles.size()));
  }
  return network;
}

std::int64_t total(const CellCounts& counts, const std::vector<std::int64_t>& perCell) {
  std::int64_t sum = 0;
  for (std::size_t s = 0; s < counts.size(); ++s) sum += counts[s] * perCell[s];
  return sum;
}

/// Lines "number type atom atom ..." of bonds, angles or dihedrals of a cell.
template <class Tuples>
std::string topologyLines(const ExportedCell& cell, const Network& network, const Tuples& tuples,
                          const std::vector<std::int64_t>& perCell) {
  std::int64_t number = cell.partsBefore(perCell);
  const std::int64_t firstAtom = 1 + cell.partsBefore(network.atomsPerCell);
  std::string text;
  for (const auto& tuple : tuples) {
    text += fmt::format("{} {}", ++number, cell.species + 1);
    for (const int vertex : tuple) text += fmt::format(" {}", firstAtom + vertex);
    text += "\n";
  }
  return text;
}

}  // namespace

std::vector<ExportedFile> lammpsExport(const Problem& problem, const CellCounts& counts) {
  std::int64_t cells = 0;
  std::vector<Vec3> sizes;
  for (std::size_t s = 0; s < problem.species.size(); ++s) {
    cells += counts[s];
    sizes.push_back(boundingBox(problem.species[s].shape->mesh()).size());
  }
  const std::string head =
      fmt::format("{}{} atoms\n{} ellipsoids\n{} atom types\n\n{}\nAtoms # ellipsoid\n\n", title(problem),
                  cells, cells, problem.species.size(), boxLines(problem));
  const auto atomLine = [](const ExportedCell& cell) {  // number, type, is an ellipsoid, density, position
    return fmt::format("{} {} 1 1 {}\n", cell.number(), cell.species + 1, numbers(cell.pose.position));
  };
  const auto ellipsoidLine = [sizes](const ExportedCell& cell) {
    return fmt::format("{} {} {}\n", cell.number(), numbers(sizes[cell.species]),
                       numbers(cell.pose.orientation));
  };
  return {{"cells.lammps", {{head, atomLine}, {"\nEllipsoids\n\n", ellipsoidLine}}}};
}

std::vector<ExportedFile> lammpsMolecularExport(const Problem& problem, const CellCounts& counts) {
  Network network = networkOf(problem);
  const std::int64_t atoms = total(counts, network.atomsPerCell), edges = total(counts, network.edgesPerCell),
                     triangles = total(counts, network.trianglesPerCell);
  if (std::max(atoms, edges) > std::numeric_limits<std::int32_t>::max())
    throw InputError(
        fmt::format("export to LAMMPS: {} atoms and {} bonds are more than it numbers", atoms, edges));
  const std::size_t types = problem.species.size();
  std::string head = fmt::format(
      "{0}{1} atoms\n{2} bonds\n{3} angles\n{2} dihedrals\n{4} atom types\n{4} bond types\n{4} angle "
      "types\n{4} "
      "dihedral types\n\n{5}\nMasses\n\n",
      title(problem), atoms, edges, triangles, types, boxLines(problem));
  for (std::size_t type = 1; type <= types; ++type) head += fmt::format("{} 1\n", type);
  const auto atomLines = [&problem, perCell = network.atomsPerCell](const ExportedCell& cell) {
    std::int64_t atom = cell.partsBefore(perCell);
    std::string text;  // number, molecule, type, position
    for (const Vec3& v : placedVertices(problem.species[cell.species].shape->mesh(), cell.placement))
      text += fmt::format("{} {} {} {}\n", ++atom, cell.number(), cell.species + 1, numbers(v));
    return text;
  };
  const auto shared = std::make_shared<const Network>(std::move(network));
  const auto bonds = [shared](const ExportedCell& cell) {
    return topologyLines(cell, *shared, shared->edges[cell.species].bonds, shared->edgesPerCell);
  };
  const auto angles = [shared, &problem](const ExportedCell& cell) {
    return topologyLines(cell, *shared, problem.species[cell.species].shape->mesh().triangles,
                         shared->trianglesPerCell);
  };
  const auto dihedrals = [shared](const ExportedCell& cell) {
    return topologyLines(cell, *shared, shared->edges[cell.species].dihedrals, shared->edgesPerCell);
  };
  return {{"cells_molecular.lammps",
           {{head + "\nAtoms # molecular\n\n", atomLines},
            {"\nBonds\n\n", bonds},
            {"\nAngles\n\n", angles},
            {"\nDihedrals\n\n", dihedrals}}}};
}

}  // namespace packmesh::hemocell
