// SPDX-License-Identifier: AGPL-3.0-or-later
#include "arrays.h"

#include "hemocell_adapter/settings/value_specs.h"
#include "packMesh/core/error.h"

namespace py = pybind11;
using namespace packmesh;
using namespace packmesh::hemocell;

namespace {

/// Views of what the packing holds, which it keeps alive, are not written to.
py::array readOnly(py::array array) {
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// Keeps a packing for as long as an array that is part of it exists.
py::capsule keeperOf(const Held& held) {
  return {new Held(held), [](void* kept) { delete static_cast<Held*>(kept); }};
}

}  // namespace

py::tuple vectorOf(const Vec3& v) {
  return py::make_tuple(v[0], v[1], v[2]);
}

py::tuple arraysOf(const TriangleMesh& mesh) {
  py::array_t<double> vertices({py::ssize_t(mesh.vertices.size()), py::ssize_t(3)});
  double* place = vertices.mutable_data();
  for (const Vec3& vertex : mesh.vertices)
    for (const double x : vertex) *place++ = x;
  py::array_t<std::int32_t> triangles({py::ssize_t(mesh.triangles.size()), py::ssize_t(3)});
  std::int32_t* out = triangles.mutable_data();
  for (const Triangle& triangle : mesh.triangles)
    for (const int corner : triangle) *out++ = corner;
  return py::make_tuple(vertices, triangles);
}

py::array_t<double> arrayOf(const std::vector<PosLine>& lines) {
  py::array_t<double> array({py::ssize_t(lines.size()), py::ssize_t(6)});
  auto out = array.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < out.shape(0); ++i)
    for (int k = 0; k < 3; ++k) {
      out(i, k) = lines[i].position[k];
      out(i, k + 3) = lines[i].angles[k];
    }
  return array;
}

std::string cellName(const std::string& text) {
  return std::get<std::string>(parseValue(specs::name(), text));
}

std::vector<PosLine> linesOf(const std::string& name, const Rows& rows) {
  if (rows.ndim() != 2 || rows.shape(1) != 6)
    throw InputError("the cells '" + name + "': expected an array of shape (n, 6)");
  std::vector<PosLine> lines(rows.shape(0));
  const auto in = rows.unchecked<2>();
  for (py::ssize_t i = 0; i < in.shape(0); ++i)
    for (int k = 0; k < 3; ++k) {
      lines[i].position[k] = in(i, k);
      lines[i].angles[k] = in(i, k + 3);
    }
  for (const PosLine& line : lines)
    if (!line.position.allFinite() || !line.angles.allFinite())
      throw InputError("the cells '" + name + "': expected finite numbers");
  return lines;
}

const std::vector<Vec3>* HeldCells::ownVertices(std::size_t cell) const {
  if (packing) {
    const PlacedCell& placed = packing->cells[cell];
    const Problem& problem = *packing->problem;
    return problem.isDeformed(placed) ? &problem.shapes[placed.shape]->mesh().vertices : nullptr;
  }
  const std::vector<Vec3>& own = loaded->cells[cell].vertices;
  return own.empty() ? nullptr : &own;
}

Placement HeldCells::placement(std::size_t cell) const {
  return packing ? packing->cells[cell].placement : placementOf(posLineOf(loaded->cells[cell].pose));
}

std::shared_ptr<const Request> HeldCells::asked() const {
  return packing ? packing->problem->request.asked : requestOfCells(*loaded, file);
}

py::array positionsOf(const PythonPacking& packing) {
  const Held& held = packing.held;
  const auto stride = held->packing ? sizeof(Pose) : sizeof(Cell);
  return readOnly(py::array_t<double>({py::ssize_t(held->size()), py::ssize_t(3)}, {stride, sizeof(double)},
                                      held->size() == 0 ? nullptr : held->pose(0).position.data(),
                                      keeperOf(held)));
}

py::array rotationsOf(const PythonPacking& packing) {
  const Held& held = packing.held;
  const auto stride = held->packing ? sizeof(Pose) : sizeof(Cell);
  return readOnly(py::array_t<double>({py::ssize_t(held->size()), py::ssize_t(4)}, {stride, sizeof(double)},
                                      held->size() == 0 ? nullptr : held->pose(0).orientation.coeffs().data(),
                                      keeperOf(held)));
}

py::array_t<std::int32_t> speciesOf(const PythonPacking& packing) {
  const Held held = packing.held;
  py::array_t<std::int32_t> array(py::ssize_t(held->size()));
  std::int32_t* out = array.mutable_data();
  for (std::size_t i = 0; i < held->size(); ++i) *out++ = held->kind(i);
  return array;
}

py::array_t<double> verticesOf(const PythonPacking& packing, int species) {
  const Held held = packing.held;
  const std::vector<Vec3>& body = held->kinds.at(species).mesh.vertices;
  py::ssize_t count = 0;
  for (std::size_t i = 0; i < held->size(); ++i) count += held->kind(i) == species;
  py::array_t<double> array({count, py::ssize_t(body.size()), py::ssize_t(3)});
  double* out = array.mutable_data();
  for (std::size_t i = 0; i < held->size(); ++i) {
    if (held->kind(i) != species) continue;
    const std::vector<Vec3>* const own = held->ownVertices(i);
    const Placement placement = held->placement(i);
    for (const Vec3& vertex : own ? *own : body)
      for (const double x : Vec3(placement(vertex))) *out++ = x;
  }
  return array;
}

py::tuple templateOf(const PythonPacking& packing, int species) {
  const Held held = packing.held;
  return arraysOf(held->kinds.at(species).mesh);
}
