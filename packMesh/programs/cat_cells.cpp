// SPDX-License-Identifier: AGPL-3.0-or-later
// The catCells program: divides the space between objects into one CAT cell per object; see `usage`.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "packMesh/core/error.h"
#include "packMesh/growth/cat_export.h"
#include "packMesh/growth/tetrahedralise.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/io/mesh_collection.h"
#include "packMesh/io/vtp_surface.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"

namespace {

using namespace packmesh;

constexpr const char* usage =
    "catCells container object ... [options]\n"
    "\n"
    "Tetrahedralises the space between the objects and the container and cuts it along the chordal axis.\n"
    "The CAT cell of an object is the part of the space nearest to it, a closed surface.\n"
    "\n"
    "  container       file with a closed mesh (.stl, .off, .ply, .obj; lengths in µm)\n"
    "  object          likewise; FILE@x,y,z moves the mesh by (x, y, z)\n"
    "  --output f      output file for the cells: .obj, .ply or .h5 (default: cells.obj)\n"
    "  --mid-gap       end cells halfway between object and container, not at the container\n"
    "  --vtp f         write container, objects and cells to one file (.vtp) for ParaView and for pictures\n"
    "                  (python3 -m packmesh render)\n";

struct UsageError : InputError {
  using InputError::InputError;
};

struct Options {
  std::string container;
  std::vector<std::string> objects;
  std::string output = "cells.obj", surfaces;
  WallFaces wall = WallFaces::atWall;
};

std::vector<double> numbers(const std::string& text, const std::string& argument) {
  std::vector<double> out;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    std::size_t used = 0;
    try {
      out.push_back(std::stod(text.substr(at, end - at), &used));
    } catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || used != end - at)
      throw UsageError("'" + argument + "' must end with comma-separated numbers, e.g. 1,2.5,3");
    at = end + 1;
  }
  return out;
}

Options parse(int argc, char** argv) {
  Options options;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == argc) throw UsageError(argument + " needs a value");
      return argv[++i];
    };
    if (argument == "--output")
      options.output = value();
    else if (argument == "--vtp")
      options.surfaces = value();
    else if (argument == "--mid-gap")
      options.wall = WallFaces::midGap;
    else if (argument.rfind("--", 0) == 0)
      throw UsageError("unknown option '" + argument + "'; see catCells --help");
    else
      files.push_back(argument);
  }
  if (files.size() < 2) throw UsageError("give a container and at least one object; see catCells --help");
  requireMeshCollectionEnding(options.output);
  options.container = files.front();
  options.objects.assign(files.begin() + 1, files.end());
  return options;
}

TriangleMesh closedMesh(const std::string& file) {
  TriangleMesh mesh = readMesh(file);
  for (const std::string& mended : repairClosed(mesh, file))
    fmt::print(stderr, "(packMesh) (Warning) {}: {}\n", file, mended);
  return mesh;
}

/// Parses "ball.off@1,2,3": file and translation [µm].
PlacedMesh objectOf(const std::string& argument, std::vector<std::unique_ptr<MeshHierarchy>>& meshes) {
  const std::size_t at = argument.rfind('@');
  Placement placement;
  if (at != std::string::npos) {
    const std::vector<double> p = numbers(argument.substr(at + 1), argument);
    if (p.size() != 3) throw UsageError("'" + argument + "' must end with @x,y,z");
    placement.translation = {p[0], p[1], p[2]};
  }
  meshes.push_back(std::make_unique<MeshHierarchy>(closedMesh(argument.substr(0, at))));
  return {meshes.back().get(), placement};
}

/// Prints the number of tetrahedra of each case of the cut (Table 3.1 of the thesis).
void printCases(const Tetrahedra& tetrahedra, WallFaces wall) {
  ChordalFaces split;
  splitChordally(tetrahedra, wall, split);
  const auto& n = split.tetrahedra;
  fmt::print(
      "(packMesh) {} tetrahedra: {} join two surfaces (3+1 vertices), {} (2+2), {} three, {} four; {} CAT "
      "faces\n",
      tetrahedra.tetrahedra.size(), n[1], n[2], n[3], n[4], split.faces.size());
}

/// Container, objects and cells. Triangles have the number of their object, the first is 1, and of the
/// container 0; and `cell`: 1 for those of CAT cells.
void writeSurfaces(const std::string& file, const TetrahedraInput& input, const CatCells& cells) {
  VtpSurface all;
  std::vector<std::int64_t> object, cell;
  const auto add = [&](const TriangleMesh& mesh, const Placement& placement, std::size_t number,
                       bool isCell) {
    const int first = int(all.points.size());
    for (const Vec3& v : mesh.vertices) all.points.push_back(placement(v));
    for (const Triangle& t : mesh.triangles)
      all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    object.resize(all.triangles.size(), std::int64_t(number));
    cell.resize(all.triangles.size(), isCell);
  };
  add(input.container->mesh(), {}, 0, false);
  for (std::size_t i = 0; i < input.objects.size(); ++i) {
    add(input.objects[i].mesh->mesh(), input.objects[i].placement, i + 1, false);
    add(cells.cells[i], {}, i + 1, true);
  }
  all.data = {{"object", std::move(object)}, {"cell", std::move(cell)}};
  AtomicFiles files;
  files.add(file, vtpText(all));
  files.commit();
  fmt::print("(packMesh) Wrote {}\n", file);
}

void run(const Options& options) {
  const MeshHierarchy container(closedMesh(options.container));
  std::vector<std::unique_ptr<MeshHierarchy>> meshes;
  TetrahedraInput input;
  for (const std::string& object : options.objects) input.objects.push_back(objectOf(object, meshes));
  input.names = options.objects;
  input.container = &container;
  const Tetrahedra tetrahedra = tetrahedralise(input);
  const CatCells cells = catCells(tetrahedra, options.wall);
  printCases(tetrahedra, options.wall);
  double sum = cells.wallLayer.triangles.empty() ? 0.0 : signedVolume(cells.wallLayer);
  for (std::size_t i = 0; i < cells.cells.size(); ++i) {
    const double volume = signedVolume(cells.cells[i]);
    fmt::print("(packMesh) {}: cell of {:.4f} µm³, {} triangles\n", options.objects[i], volume,
               cells.cells[i].triangles.size());
    sum += volume;
  }
  fmt::print("(packMesh) The cells fill {:.6f} % of the container\n",
             100.0 * sum / signedVolume(container.mesh()));
  writeCatCells(options.output, cells, options.objects);
  fmt::print("(packMesh) Wrote {}\n", options.output);
  if (!options.surfaces.empty()) writeSurfaces(options.surfaces, input, cells);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || std::string(argv[1]) == "--help") {
    std::fputs(usage, argc < 2 ? stderr : stdout);
    return argc < 2 ? 1 : 0;
  }
  try {
    run(parse(argc, argv));
    return 0;
  } catch (const UsageError& error) {
    std::cerr << "(packMesh) (Error) " << error.what() << '\n';
    return 1;
  } catch (const Error& error) {
    std::cerr << "(packMesh) (Error) " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "(packMesh) (Error) " << error.what() << '\n';
    return 70;
  }
}
