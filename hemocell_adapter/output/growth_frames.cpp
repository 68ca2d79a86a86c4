// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/growth_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "hemocell_adapter/output/shared_files.h"
#include "packMesh/growth/cat_cells.h"
#include "packMesh/growth/tetrahedralise.h"
#include "packMesh/io/vtp.h"
#include "packMesh/packing/gathered_cells.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;
using Place = VtpArray::Place;
using Type = VtpArray::Type;

/// A surface of a frame.
struct Surface {
  std::shared_ptr<const TriangleMesh> mesh;
  Placement placement;
  std::int32_t id, species;
  float scale;
};

float scaleOf(const PlacedCell& cell) {
  return static_cast<float>(std::cbrt(cell.placement.linear.determinant()));
}

/// Numbers of points and triangles.
std::pair<std::int64_t, std::int64_t> sizesOf(const std::vector<Surface>& surfaces) {
  std::int64_t points = 0, triangles = 0;
  for (const Surface& s : surfaces) {
    points += std::int64_t(s.mesh->vertices.size());
    triangles += std::int64_t(s.mesh->triangles.size());
  }
  return {points, triangles};
}

/// All ranks call, each with its own surfaces.
void writeSurfaces(const fs::path& file, const std::vector<Surface>& own, const Communicator& ranks) {
  const auto [points, triangles] = sizesOf(own);
  std::vector<std::int64_t> all = {points, triangles};
  const std::vector<std::int64_t> before = ranks.sumBefore(all);
  ranks.sum(all);
  SharedFiles files(ranks);
  files.begin(file);
  const auto data = [&](const char* name, Type type) { return VtpArray{Place::data, name, type, 1, all[1]}; };
  const std::vector<VtpArray> arrays = {
      {Place::points, "", Type::float32, 3, all[0]},
      {Place::polygonConnectivity, "", Type::int64, 1, 3 * all[1]},
      {Place::polygonOffsets, "", Type::int64, 1, all[1]},
      data("id", Type::int32),
      data("species", Type::int32),
      data("scale", Type::float32),
  };
  files.append([&] { return vtpHead({all[0], 0, all[1]}, arrays); });
  std::size_t written = 0;
  const auto append = [&](const auto& numbers) {
    files.append([&] { return vtpBegin(arrays[written]); });
    files.appendParts(vtpNumbers(numbers));
    ++written;
  };
  std::vector<float> positions, scales;
  std::vector<std::int64_t> corners, ends(triangles);
  std::vector<std::int32_t> ids, species;
  std::int64_t first = before[0];
  for (const Surface& s : own) {
    for (const Vec3& v : s.mesh->vertices) {
      const Vec3 p = s.placement(v);
      positions.insert(positions.end(), {float(p.x()), float(p.y()), float(p.z())});
    }
    for (const Triangle& t : s.mesh->triangles)
      for (const int v : t) corners.push_back(first + v);
    first += std::int64_t(s.mesh->vertices.size());
    ids.insert(ids.end(), s.mesh->triangles.size(), s.id);
    species.insert(species.end(), s.mesh->triangles.size(), s.species);
    scales.insert(scales.end(), s.mesh->triangles.size(), s.scale);
  }
  for (std::int64_t i = 0; i < triangles; ++i) ends[i] = 3 * (before[1] + i + 1);
  append(positions);
  append(corners);
  append(ends);
  append(ids);
  append(species);
  append(scales);
  files.append(vtpEnd);
  files.end();
  files.commit();
}

}  // namespace

GrowthFrames::GrowthFrames(const PackingProblem& problem, fs::path folder, std::int64_t every)
    : problem_(problem), folder_(std::move(folder)), every_(every) {
  SharedFiles(problem_.execution.communicator).makeFolder(folder_);
}

void GrowthFrames::add(const std::vector<PlacedCell>& own) {
  const std::int64_t state = states_++;
  if (state % every_ != 0) return;
  const Communicator& ranks = problem_.execution.communicator;
  Frame frame{std::int64_t(frames_.size()), state, false};
  const auto count = std::int64_t(own.size());
  const std::int64_t all = ranks.sum(count);
  std::int64_t id = ranks.sumBefore({count}).front();
  std::vector<Surface> membranes;
  for (const PlacedCell& cell : own) {
    const auto& shape = problem_.physics.species[cell.species].shape;
    membranes.push_back({{shape, &shape->mesh()},
                         cell.placement,
                         std::int32_t(id++),
                         std::int32_t(cell.species),
                         scaleOf(cell)});
  }
  writeSurfaces(folder_ / fmt::format("membranes_{:04}.vtp", frame.number), membranes, ranks);
  if (all <= mostWithCatCells) writeCatCells(gatheredCells(own, ranks), frame);
  frames_.push_back(frame);
  writeSeries();
}

/// The first rank alone makes them; if TetGen fails, the frame has none.
void GrowthFrames::writeCatCells(const std::vector<PlacedCell>& all, Frame& frame) {
  const Communicator& ranks = problem_.execution.communicator;
  std::vector<Surface> surfaces;
  if (ranks.rank() == 0) {
    TetrahedraInput input;
    for (const PlacedCell& cell : all)
      input.objects.push_back({&problem_.physics.species[cell.species].shape->hierarchy(), cell.placement});
    std::optional<MeshHierarchy> lumen;
    if (problem_.physics.container->wall()) lumen.emplace(problem_.physics.container->surface());
    input.container = lumen ? &*lumen : nullptr;
    input.period = problem_.physics.container->period();
    input.bounds = problem_.physics.container->bounds();
    input.explain = false;
    try {
      const CatCells cells = catCells(tetrahedralise(input), WallFaces::atWall);
      for (std::size_t i = 0; i < cells.cells.size(); ++i)
        surfaces.push_back({std::make_shared<const TriangleMesh>(cells.cells[i]), Placement(),
                            std::int32_t(i), std::int32_t(all[i].species), scaleOf(all[i])});
    } catch (const std::runtime_error&) {  // TetGen failed, or the lumen's surface touches a cell
      surfaces.clear();
    }
  }
  frame.catCells = ranks.any(!surfaces.empty());
  if (frame.catCells)
    writeSurfaces(folder_ / fmt::format("cat_cells_{:04}.vtp", frame.number), surfaces, ranks);
}

void GrowthFrames::writeSeries() const {
  SharedFiles files(problem_.execution.communicator);
  const auto write = [&](const char* name, const char* file, bool catCells) {
    files.begin(folder_ / name);
    files.append([&] {
      std::string text =
          "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
          "byte_order=\"LittleEndian\">\n"
          "  <Collection>\n";
      for (const Frame& frame : frames_)
        if (!catCells || frame.catCells)
          text += fmt::format("    <DataSet timestep=\"{}\" file=\"{}_{:04}.vtp\"/>\n", frame.state, file,
                              frame.number);
      return text + "  </Collection>\n</VTKFile>\n";
    });
    files.end();
  };
  write("growth.pvd", "membranes", false);
  if (std::any_of(frames_.begin(), frames_.end(), [](const Frame& frame) { return frame.catCells; }))
    write("cat_cells.pvd", "cat_cells", true);
  files.commit();
}

}  // namespace packmesh::hemocell
