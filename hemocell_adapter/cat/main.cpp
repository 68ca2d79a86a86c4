// SPDX-License-Identifier: AGPL-3.0-or-later
// The catCells program: divides the space between objects into one CAT cell per object; see `usage`.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/python_command.h"
#include "packMesh/cat/cat_cells.h"
#include "packMesh/cat/tetrahedra.h"
#include "packMesh/core/error.h"
#include "packMesh/mesh/mesh_file.h"
#include "packMesh/mesh/mesh_repair.h"
#include "packMesh/packing/packing_file.h"

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
    "                  (python3 -m packmesh render)\n"
    "\n"
    "Files other than .h5 are written by the command packmesh of the Python package.\n";

using hemocell::UsageError;

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
  const std::string ending = std::filesystem::path(options.output).extension().string();
  if (ending != ".obj" && ending != ".ply" && ending != ".h5")
    throw InputError(options.output + ": the file extension must be .obj, .ply or .h5");
  options.container = files.front();
  options.objects.assign(files.begin() + 1, files.end());
  return options;
}

TriangleMesh closedMesh(const std::string& file) {
  TriangleMesh mesh = readMesh(file);
  for (const std::string& repair : repairClosed(mesh, file)) hemocell::log::warning(repair);
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

std::vector<NamedMesh> namedCells(const CatCells& cells, const std::vector<std::string>& names) {
  std::vector<NamedMesh> named;
  for (std::size_t i = 0; i < names.size(); ++i) named.push_back({names[i], cells.cells[i], "cell"});
  if (!cells.wallLayer.triangles.empty()) named.push_back({"wall layer", cells.wallLayer, "wall layer"});
  return named;
}

/// Writes the requested files. All but .h5 are made by packmesh from a .h5 with container, objects and cells.
void write(const Options& options, const TetrahedraInput& input, std::vector<NamedMesh> meshes) {
  const std::filesystem::path output = options.output;
  std::vector<std::string> converted;
  if (output.extension() != ".h5") converted.push_back(options.output);
  if (!options.surfaces.empty()) converted.push_back(options.surfaces);
  if (output.extension() == ".h5") {
    writeMeshes(output, meshes);
    hemocell::log::info("Wrote " + options.output);
  }
  if (converted.empty()) return;
  meshes.push_back({"container", input.container->mesh(), "container"});
  for (std::size_t i = 0; i < input.objects.size(); ++i) {
    TriangleMesh mesh = input.objects[i].mesh->mesh();
    for (Vec3& v : mesh.vertices) v = input.objects[i].placement(v);
    meshes.push_back({input.names[i], std::move(mesh), "object"});
  }
  std::filesystem::path file = converted.front();
  file.replace_filename("." + file.filename().string() + ".h5");
  writeMeshes(file, meshes);
  std::vector<std::string> words = {"cat-cells", file.string()};
  words.insert(words.end(), converted.begin(), converted.end());
  const hemocell::CommandEnd end = hemocell::runPackmesh(words);
  std::filesystem::remove(file);
  for (const std::string& line : end.lines) hemocell::log::info(line);
  if (end.kind == hemocell::CommandEnd::Kind::unusable)
    throw InputError("the Python package packmesh " + end.message +
                     ": only --output cells.h5 can be written without it");
  if (end.kind != hemocell::CommandEnd::Kind::done) throw OutputError(end.message);
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
  std::fflush(stdout);
  write(options, input, namedCells(cells, options.objects));
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
  } catch (const std::exception& error) {
    std::cerr << "(packMesh) (Error) " << error.what() << '\n';
    return dynamic_cast<const UsageError*>(&error) ? 1 : dynamic_cast<const Error*>(&error) ? 2 : 70;
  }
}
