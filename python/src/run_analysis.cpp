// SPDX-License-Identifier: AGPL-3.0-or-later
#include "run_analysis.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.h"
#include "caller.h"
#include "hemocell_adapter/hemocell/cell_model.h"
#include "hemocell_adapter/problem/completed_request.h"
#include "hemocell_adapter/problem/make_lumen.h"
#include "hemocell_adapter/session/held_packing.h"
#include "packMesh/analysis/wall_depth.h"
#include "packMesh/certificate/mesh_overlaps.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"
#include "packMesh/parallel/cores.h"

namespace py = pybind11;
using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

using Points = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Corners = py::array_t<std::int32_t, py::array::c_style | py::array::forcecast>;

/// A lumen with the distances to its wall.
struct PythonLumen {
  Lumen lumen;
  std::unique_ptr<const WallDepth> depth;   ///< nullptr: no wall
  std::optional<std::array<int, 3>> nodes;  ///< of the lattice of the case, unless it is only assumed
};

py::tuple tupleOf(const Box& box) {
  return py::make_tuple(vectorOf(box.lo), vectorOf(box.hi));
}

/// The lumen in which the cells of a case flow, behind a pre-inlet if there is one. Its ends are taken to be
/// periodic, so that only its wall counts as wall, unless their outlines differ.
Lumen flowLumen(const CompletedRequest& completed) {
  Request request = completed.request;
  try {
    request.periodicEnds = true;
    return makeLumen(request, completed.simulation.get(), {});
  } catch (const InputError&) {
    request.periodicEnds = false;
    return makeLumen(request, completed.simulation.get(), {});
  }
}

std::unique_ptr<PythonLumen> lumenOf(const std::vector<std::string>& words) {
  return Caller().run([&] {
    auto made = std::make_unique<PythonLumen>();
    const CompletedRequest completed = requestToCheck(parseCommandLine("packMesh", words));
    made->lumen = flowLumen(completed);
    const std::optional<ContainerRequest>& body = completed.request.container;
    if (made->lumen.lattice && (!body || body->nodes || completed.simulation->domain.boxNodes))
      made->nodes = made->lumen.lattice->nodes();
    const Container& container = *made->lumen.container;
    if (container.wall()) made->depth = std::make_unique<WallDepth>(*container.wall(), container.bounds());
    return made;
  });
}

/// Of points, shape (n, 3): positive inside [µm], shape (n,). Without a wall they are infinite.
py::array_t<double> distancesOf(const PythonLumen& self, const Points& points) {
  if (points.ndim() != 2 || points.shape(1) != 3)
    throw InputError("distances: expected an array of shape (n, 3)");
  const auto in = points.unchecked<2>();
  py::array_t<double> distances(in.shape(0));
  double* const out = distances.mutable_data();
  const Container& container = *self.lumen.container;
  const Box bounds = container.bounds();
  Caller().run([&] {
    Threads(availableCores()).forEachPart(in.shape(0), [&](std::int64_t begin, std::int64_t end, int) {
      for (std::int64_t i = begin; i < end; ++i) {
        const Vec3 p(in(i, 0), in(i, 1), in(i, 2));
        if (!self.depth)
          out[i] = std::numeric_limits<double>::infinity();
        else
          out[i] = bounds.contains(p) ? (*self.depth)(p) : container.wall()->distance(p).distance;
      }
    });
  });
  return distances;
}

/// Meshes of a type: vertices, shape (N, V, 3), and triangles, shape (T, 3).
void addMeshes(const Points& vertices, const Corners& triangles, std::vector<TriangleMesh>& meshes) {
  if (vertices.ndim() != 3 || vertices.shape(2) != 3 || triangles.ndim() != 2 || triangles.shape(1) != 3)
    throw InputError("mesh_overlaps: expected vertices of shape (N, V, 3) and triangles of shape (T, 3)");
  const auto points = vertices.unchecked<3>();
  const auto corners = triangles.unchecked<2>();
  TriangleMesh mesh;
  for (py::ssize_t t = 0; t < corners.shape(0); ++t) {
    mesh.triangles.push_back({corners(t, 0), corners(t, 1), corners(t, 2)});
    for (const int corner : mesh.triangles.back())
      if (corner < 0 || corner >= points.shape(1))
        throw InputError("mesh_overlaps: a triangle refers to no vertex");
  }
  mesh.vertices.resize(points.shape(1));
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    for (py::ssize_t v = 0; v < points.shape(1); ++v)
      mesh.vertices[v] = Vec3(points(i, v, 0), points(i, v, 1), points(i, v, 2));
    for (const Vec3& vertex : mesh.vertices)
      if (!vertex.allFinite()) throw InputError("mesh_overlaps: expected finite vertices");
    meshes.push_back(mesh);
  }
}

/// Numbers of the cells that are not wholly inside the lumen, and why not: exact.
std::vector<std::pair<std::int64_t, std::string>> violationsOf(const PythonLumen& self,
                                                               const Points& vertices,
                                                               const Corners& triangles) {
  std::vector<TriangleMesh> meshes;
  addMeshes(vertices, triangles, meshes);
  std::vector<std::optional<std::string>> reasons(meshes.size());
  const Wall* const wall = self.lumen.container->wall();
  if (wall)
    Caller().run([&] {
      Threads(availableCores()).forEach(static_cast<std::int64_t>(meshes.size()), [&](std::int64_t i, int) {
        reasons[i] = wall->violation(meshes[i]);
      });
    });
  std::vector<std::pair<std::int64_t, std::string>> found;
  for (std::size_t i = 0; i < reasons.size(); ++i)
    if (reasons[i]) found.emplace_back(i, *reasons[i]);
  return found;
}

/// The template that HemoCell builds of a cell: its vertices [µm] and triangles, in HemoCell's order; None if
/// the cell is unknown. @param folder with `<Cell>.xml`, or without it: then HemoCell's defaults @param dx
/// [µm]
py::object cellTemplate(const std::string& name, const std::optional<std::filesystem::path>& folder,
                        double dx) {
  std::optional<CellModel> model;
  if (folder && std::filesystem::exists(*folder / (name + ".xml")))
    model = readCellXml(*folder / (name + ".xml"), name);
  else
    model = defaultModel(name);
  if (!model) return py::none();
  return arraysOf(buildTemplate(*model, dx));
}

/// Pairs of numbers of meshes that overlap, counted through all types, and whether one contains the other.
std::vector<std::tuple<std::int64_t, std::int64_t, bool>> meshOverlaps(
    const std::vector<std::pair<Points, Corners>>& types) {
  std::vector<TriangleMesh> meshes;
  for (const auto& [vertices, triangles] : types) addMeshes(vertices, triangles, meshes);
  std::vector<std::tuple<std::int64_t, std::int64_t, bool>> pairs;
  Caller().run([&] {
    for (const OverlappingPair& pair : findMeshOverlaps(meshes, Threads(availableCores())))
      pairs.emplace_back(pair.first, pair.second, pair.contained);
  });
  return pairs;
}

/// Writes the cells of a step as a state. @param kinds name, vertices (V, 3) and triangles (T, 3) of the
/// template, positions (N, 3), rotations (N, 4: x, y, z, w), vertices in the frame of the template (N, V, 3)
/// @param lumen nullptr: the box with these corners, which is periodic, or else one around the cells
void saveDeformed(const std::filesystem::path& file, const std::vector<std::string>& words,
                  const std::vector<std::tuple<std::string, Points, Corners, Points, Points, Points>>& kinds,
                  const PythonLumen* lumen,
                  const std::optional<std::array<std::array<double, 3>, 2>>& corners) {
  StateCells all;
  all.command = words;
  Box around;
  for (const auto& [name, vertices, triangles, positions, rotations, bodies] : kinds) {
    std::vector<TriangleMesh> meshes;
    Points one = vertices;
    addMeshes(one.reshape({py::ssize_t(1), one.shape(0), py::ssize_t(3)}), triangles, meshes);
    const auto p = positions.unchecked<2>(), q = rotations.unchecked<2>();
    const auto v = bodies.unchecked<3>();
    all.species.push_back({name, std::move(meshes.front()), std::int64_t(p.shape(0))});
    for (py::ssize_t i = 0; i < p.shape(0); ++i) {
      const Vec3 position(p(i, 0), p(i, 1), p(i, 2));
      const Quaternion turned = Quaternion(q(i, 3), q(i, 0), q(i, 1), q(i, 2)).normalized();
      const int kind = int(all.species.size()) - 1;
      Cell& cell =
          all.cells.emplace_back(Cell{std::int64_t(all.cells.size()), kind, {1.0, turned, position}});
      for (py::ssize_t k = 0; k < v.shape(1); ++k) {
        cell.vertices.emplace_back(v(i, k, 0), v(i, k, 1), v(i, k, 2));
        around.add(cell.pose.placement()(cell.vertices.back()));
      }
    }
  }
  std::shared_ptr<const Container> container;
  if (lumen)
    container = lumen->lumen.container;
  else if (corners)
    container = makeBox({Vec3((*corners)[0].data()), Vec3((*corners)[1].data())}, {true, true, true});
  else
    container = makeBox(around.grownBy(1.0), {false, false, false});
  Caller().run([&] { saveCells(std::move(all), container, file); });
}

}  // namespace

void addRunAnalysis(py::module_& module) {
  py::class_<PythonLumen>(module, "Lumen")
      .def_property_readonly("bounds",
                             [](const PythonLumen& self) { return tupleOf(self.lumen.container->bounds()); })
      .def_property_readonly("period",
                             [](const PythonLumen& self) { return vectorOf(self.lumen.container->period()); })
      .def_property_readonly("nodes", [](const PythonLumen& self) { return self.nodes; })
      .def_property_readonly("volume", [](const PythonLumen& self) { return self.lumen.container->volume(); })
      .def_property_readonly("description",
                             [](const PythonLumen& self) { return self.lumen.container->describe(); })
      .def_property_readonly(
          "surface", [](const PythonLumen& self) { return arraysOf(self.lumen.container->surface()); })
      .def_property_readonly("has_wall", [](const PythonLumen& self) { return self.depth != nullptr; })
      .def("distances", &distancesOf)
      .def("violations", &violationsOf);
  module.def("lumen", &lumenOf);
  module.def("mesh_overlaps", &meshOverlaps);
  module.def("cell_template", &cellTemplate);
  module.def("save_cells", &saveDeformed);
}
