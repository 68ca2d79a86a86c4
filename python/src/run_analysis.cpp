// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the analysis of runs needs of the library: lumens, and the exact test of deformed membranes.
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
#include "hemocell_adapter/problem/make_species.h"
#include "hemocell_adapter/problem/species_plans.h"
#include "hemocell_adapter/session/in_memory.h"
#include "packMesh/analysis/profiles.h"
#include "packMesh/certificate/overlap_finder.h"
#include "packMesh/container/primitives.h"
#include "packMesh/core/error.h"
#include "packMesh/parallel/threads.h"

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
  double volume = 0.0;                      ///< to which the hematocrit of the case refers [µm³]
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

std::unique_ptr<PythonLumen> lumenOf(const std::filesystem::path& config) {
  return Caller().run([&] {
    auto made = std::make_unique<PythonLumen>();
    const CompletedRequest completed = requestToCheck([&] {
      Request request;
      request.config = config;
      return request;
    }());
    made->lumen = flowLumen(completed);
    made->volume =
        completed.request.fluidVolume ? made->lumen.fluidVolume() : made->lumen.container->volume();
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

/// @param triangles shape (T, 3) @param vertices that there are
std::vector<Triangle> trianglesOf(const Corners& triangles, py::ssize_t vertices) {
  if (triangles.ndim() != 2 || triangles.shape(1) != 3)
    throw InputError("meshes: expected triangles of shape (T, 3)");
  const auto corners = triangles.unchecked<2>();
  std::vector<Triangle> all;
  for (py::ssize_t t = 0; t < corners.shape(0); ++t) {
    all.push_back({corners(t, 0), corners(t, 1), corners(t, 2)});
    for (const int corner : all.back())
      if (corner < 0 || corner >= vertices) throw InputError("meshes: a triangle refers to no vertex");
  }
  return all;
}

/// Meshes of a type: vertices, shape (N, V, 3), and triangles, shape (T, 3).
void addMeshes(const Points& vertices, const Corners& triangles, std::vector<TriangleMesh>& meshes) {
  if (vertices.ndim() != 3 || vertices.shape(2) != 3)
    throw InputError("meshes: expected vertices of shape (N, V, 3)");
  const auto points = vertices.unchecked<3>();
  TriangleMesh mesh{{}, trianglesOf(triangles, points.shape(1))};
  mesh.vertices.resize(points.shape(1));
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    for (py::ssize_t v = 0; v < points.shape(1); ++v)
      mesh.vertices[v] = Vec3(points(i, v, 0), points(i, v, 1), points(i, v, 2));
    for (const Vec3& vertex : mesh.vertices)
      if (!vertex.allFinite()) throw InputError("meshes: expected finite vertices");
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

/// The templates of the cells that a request names.
py::dict templatesOf(const py::dict& stated) {
  const Request asked = requestOf(stated);
  const SpeciesAndShapes made = Caller().run([&] {
    const CompletedRequest completed = requestToPack(asked);
    std::vector<std::string> warnings;
    Notices notices;  // told when the cells are packed
    return makeSpecies(plansToPack(completed.request, completed.simulation.get(), warnings), {},
                       completed.request, Threads(1), false, notices);
  });
  py::dict all;
  for (const CellSpecies& species : made.species)
    all[py::str(species.name)] = arraysOf(species.shape->mesh());
  return all;
}

using FloatPoints = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Vertices of a type, shape (N, V, 3), in units of `scale` [µm], as they are: in single or double precision.
struct MeshTable {
  py::array owner;
  const float* single = nullptr;
  const double* precise = nullptr;
  py::ssize_t count = 0, vertices = 0;
  double scale = 1.0;

  MeshTable(const py::array& given, double unit) : scale(unit) {
    if (py::isinstance<py::array_t<float>>(given)) {
      const FloatPoints points(given);
      single = points.data();
      owner = points;
    } else {
      const Points points(given);
      precise = points.data();
      owner = points;
    }
    if (owner.ndim() != 3 || owner.shape(2) != 3)
      throw InputError("meshes: expected vertices of shape (N, V, 3)");
    count = owner.shape(0);
    vertices = owner.shape(1);
  }
  double at(py::ssize_t i) const { return scale * (single ? double(single[i]) : precise[i]); }
};

/// The cells of a step with their periodic images, whose vertices stay in the tables given.
struct PythonMeshes {
  std::vector<MeshTable> tables;  ///< of each type
  std::unique_ptr<const MeshOverlaps> overlaps;

  /// Faults of some of the meshes, see MeshOverlaps::examine(): pairs of numbers of meshes that overlap,
  /// counted through all types, and meshes that intersect themselves.
  py::tuple examine(std::int64_t begin, std::int64_t end) const {
    std::vector<std::pair<std::int64_t, std::int64_t>> pairs;
    std::vector<std::int64_t> themselves;
    Caller().run([&] {
      const MeshFaults found = overlaps->examine(begin, end);
      for (const OverlappingPair& pair : found.overlapping) pairs.emplace_back(pair.first, pair.second);
      for (const SelfIntersectingCell& one : found.selfIntersecting) themselves.push_back(one.cell);
    });
    return py::make_tuple(pairs, themselves);
  }
};

/// @param types vertices, their unit [µm], and triangles (T, 3) @param period [µm], 0: not periodic
std::unique_ptr<PythonMeshes> meshesOf(const std::vector<std::tuple<py::array, double, Corners>>& types,
                                       const std::array<double, 3>& period) {
  auto made = std::make_unique<PythonMeshes>();
  MeshesOfKinds meshes;
  for (const auto& [vertices, scale, triangles] : types) {
    const MeshTable& table = made->tables.emplace_back(vertices, scale);
    meshes.kinds.push_back({trianglesOf(triangles, table.vertices), table.count});
  }
  meshes.make = [&tables = made->tables](std::size_t kind, std::int64_t index, std::vector<Vec3>& vertices) {
    const MeshTable& table = tables[kind];
    vertices.resize(std::size_t(table.vertices));
    py::ssize_t i = 3 * index * table.vertices;
    for (Vec3& v : vertices) {
      for (int k = 0; k < 3; ++k) v[k] = table.at(i++);
      if (!v.allFinite()) throw InputError("meshes: expected finite vertices");
    }
  };
  Caller().run([&] {
    made->overlaps = std::make_unique<const MeshOverlaps>(std::move(meshes), Vec3(period.data()),
                                                          Threads(availableCores()));
  });
  return made;
}

using DeformedKinds = std::vector<std::tuple<std::string, Points, Corners, Points, Points, Points>>;

/// The cells of a step. @param kinds name, vertices (V, 3) and triangles (T, 3) of the template, positions
/// (N, 3), rotations (N, 4: x, y, z, w), vertices in the frame of the template (N, V, 3)
/// @param around box of their vertices
StateCells cellsOf(const DeformedKinds& kinds, Box& around) {
  StateCells all;
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
  return all;
}

/// @param lumen nullptr: the box with these corners, which is periodic, or else one around the cells
std::shared_ptr<const Container> containerOf(
    const PythonLumen* lumen, const std::optional<std::array<std::array<double, 3>, 2>>& corners,
    const Box& around) {
  if (lumen) return lumen->lumen.container;
  if (corners) return makeBox({Vec3((*corners)[0].data()), Vec3((*corners)[1].data())}, {true, true, true});
  return makeBox(around.grownBy(1.0), {false, false, false});
}

/// Writes the cells of a step as a state. @param origin says where they are from
void saveDeformed(const std::filesystem::path& file, const std::string& origin, const DeformedKinds& kinds,
                  const PythonLumen* lumen,
                  const std::optional<std::array<std::array<double, 3>, 2>>& corners) {
  Box around;
  StateCells all = cellsOf(kinds, around);
  all.record.origin = origin;
  const auto container = containerOf(lumen, corners, around);
  Caller().run([&] { saveCells(std::move(all), container, file); });
}

/// The same in place of a state, for a setting.
/// @param box corners of the lumen and its period; without it that of `lumen`, or a box around the cells
PythonNumbers numbersOfDeformed(const std::string& setting, const DeformedKinds& kinds,
                                const PythonLumen* lumen,
                                const std::optional<std::array<std::array<double, 3>, 3>>& box) {
  Box around;
  StateCells all = cellsOf(kinds, around);
  all.box = box ? Box{Vec3((*box)[0].data()), Vec3((*box)[1].data())} : around.grownBy(1.0);
  if (box) all.period = Vec3((*box)[2].data());
  if (!box && lumen) {
    all.box = lumen->lumen.container->bounds();
    all.period = lumen->lumen.container->period();
  }
  return numbersOf(setting, "", storedCells(all));
}

}  // namespace

void addRunAnalysis(py::module_& module) {
  py::class_<PythonLumen>(module, "Lumen")
      .def_property_readonly("bounds",
                             [](const PythonLumen& self) { return tupleOf(self.lumen.container->bounds()); })
      .def_property_readonly("period",
                             [](const PythonLumen& self) { return vectorOf(self.lumen.container->period()); })
      .def_property_readonly("nodes", [](const PythonLumen& self) { return self.nodes; })
      .def_readonly("volume", &PythonLumen::volume)
      .def_property_readonly("description",
                             [](const PythonLumen& self) { return self.lumen.container->describe(); })
      .def_property_readonly(
          "surface", [](const PythonLumen& self) { return arraysOf(self.lumen.container->surface()); })
      .def_property_readonly("has_wall", [](const PythonLumen& self) { return self.depth != nullptr; })
      .def("distances", &distancesOf)
      .def("violations", &violationsOf);
  module.def("lumen", &lumenOf);
  py::class_<PythonMeshes>(module, "Meshes").def(py::init(&meshesOf)).def("examine", &PythonMeshes::examine);
  module.def("cell_template", &cellTemplate);
  module.def("templates", &templatesOf);
  module.def("save_cells", &saveDeformed);
  module.def("numbers_of_cells", &numbersOfDeformed);
}
