// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/vtp_output.h"

#include <functional>

#include "hemocell_adapter/output/shared_files.h"
#include "packMesh/io/vtp.h"
#include "packMesh/io/vtp_surface.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;
using Place = VtpArray::Place;
using Type = VtpArray::Type;

/// An array and, when it is written, this rank's part of it.
struct Part {
  VtpArray array;
  std::function<std::string()> own;
};

fs::path lumenFile(const OutputRequest& output) {
  return output.folder / "lumen.vtp";
}

/// Cells of one species on this rank.
struct OwnCells {
  std::vector<std::size_t> at;  ///< in the result
  std::int64_t first = 0;       ///< number of the first among those of its species
  std::int64_t firstOfAll = 0;  ///< number of the species' first cell among all
};

/// The surface of the lumen; of a box without walls its edges.
VtpSurface surfaceOf(const Container& lumen) {
  if (lumen.wall()) {
    const TriangleMesh mesh = lumen.surface();
    return {mesh.vertices, mesh.triangles};
  }
  VtpSurface edges;
  const Box box = lumen.bounds();
  for (int corner = 0; corner < 8; ++corner) {
    edges.points.emplace_back(corner & 1 ? box.hi.x() : box.lo.x(), corner & 2 ? box.hi.y() : box.lo.y(),
                              corner & 4 ? box.hi.z() : box.lo.z());
    for (const int axis : {1, 2, 4})
      if (!(corner & axis)) edges.lines.emplace_back(corner, corner | axis);
  }
  return edges;
}

class Writer {
 public:
  Writer(const Finished& done, const CellMeasures& measures)
      : done_(done), measures_(measures), ranks_(done.ranks()), files_(ranks_) {}

  void operator()() {
    std::int64_t before = 0;
    for (std::size_t s = 0; s < done_.problem.species.size(); ++s) {
      const CellSpecies& species = done_.problem.species[s];
      if (species.mostCells() == 0) continue;
      OwnCells own;
      for (std::size_t i = 0; i < done_.result.cells.size(); ++i)
        if (done_.result.cells[i].species == int(s)) own.at.push_back(i);
      own.first = ranks_.sumBefore({std::int64_t(own.at.size())}).front();
      own.firstOfAll = before;
      before += done_.tally.counts[s];
      const fs::path base = done_.output.folder / species.name;
      if (done_.output.writesVtp()) {
        write(base.string() + ".vtp", centres(int(s), own),
              {done_.tally.counts[s], done_.tally.counts[s], 0});
        const TriangleMesh& mesh = species.shape->mesh();
        write(base.string() + "_mesh.vtp", {mesh.vertices, mesh.triangles});
      }
      if (done_.output.vtpMeshes) {
        const TriangleMesh& mesh = species.shape->mesh();
        write(base.string() + "_cells.vtp", membranes(int(s), own),
              {done_.tally.counts[s] * std::int64_t(mesh.vertices.size()), 0,
               done_.tally.counts[s] * std::int64_t(mesh.triangles.size())});
      }
    }
    if (done_.output.writesVtp()) write(lumenFile(done_.output), surfaceOf(*done_.problem.lumen.container));
    files_.commit();
  }

 private:
  /// Of the first rank only.
  void write(const fs::path& file, const VtpSurface& surface) {
    files_.begin(file);
    files_.append([&] { return vtpText(surface); });
    files_.end();
  }

  void write(const fs::path& file, const std::vector<Part>& parts, const VtpSizes& sizes) {
    std::vector<VtpArray> arrays;
    for (const Part& part : parts) arrays.push_back(part.array);
    files_.begin(file);
    files_.append([&] { return vtpHead(sizes, arrays); });
    for (const Part& part : parts) {
      files_.append([&] { return vtpBegin(part.array); });
      files_.appendParts(part.own());
    }
    files_.append(vtpEnd);
    files_.end();
  }

  /// `each` writes the numbers of one cell, given its index in the result and its number in the species.
  template <class T, class Each>
  static Part part(VtpArray array, const OwnCells& own, Each each) {
    return {std::move(array), [&own, each] {
              std::vector<T> numbers;
              for (std::size_t i = 0; i < own.at.size(); ++i)
                each(own.at[i], own.first + std::int64_t(i), numbers);
              return vtpNumbers(numbers);
            }};
  }

  std::vector<Part> centres(int s, const OwnCells& own) const {
    const std::int64_t n = done_.tally.counts[s];
    const auto& cells = done_.result.cells;
    using Whole = std::vector<std::int64_t>;
    using Real = std::vector<double>;
    const auto data = [&](const char* name, Type type, int components) {
      return VtpArray{Place::data, name, type, components, n};
    };
    const auto add = [](Real& to, const Vec3& v) { to.insert(to.end(), v.data(), v.data() + 3); };
    return {
        part<double>(
            {Place::points, "", Type::float64, 3, n}, own,
            [&, add](std::size_t i, std::int64_t, Real& to) { add(to, cells[i].placement.translation); }),
        part<std::int64_t>({Place::vertexConnectivity, "", Type::int64, 1, n}, own,
                           [](std::size_t, std::int64_t number, Whole& to) { to.push_back(number); }),
        part<std::int64_t>({Place::vertexOffsets, "", Type::int64, 1, n}, own,
                           [](std::size_t, std::int64_t number, Whole& to) { to.push_back(number + 1); }),
        part<std::int64_t>(
            data("id", Type::int64, 1), own,
            [&own](std::size_t, std::int64_t number, Whole& to) { to.push_back(own.firstOfAll + number); }),
        part<std::int64_t>(data("species", Type::int64, 1), own,
                           [s](std::size_t, std::int64_t, Whole& to) { to.push_back(s); }),
        part<double>(data("gap", Type::float64, 1), own,
                     [&](std::size_t i, std::int64_t, Real& to) { to.push_back(measures_.gap[i]); }),
        part<double>(
            data("local_hematocrit", Type::float64, 1), own,
            [&](std::size_t i, std::int64_t, Real& to) { to.push_back(measures_.localHematocrit[i]); }),
        part<double>(data("orientation", Type::float64, 4), own,
                     [&](std::size_t i, std::int64_t, Real& to) {
                       const Quaternion& q = done_.result.poses[i].orientation;
                       to.insert(to.end(), {q.w(), q.x(), q.y(), q.z()});
                     }),
        part<double>(data("thin_axis", Type::float64, 3), own,
                     [&, add](std::size_t i, std::int64_t, Real& to) {
                       add(to, Vec3(cells[i].placement.linear.col(1)));
                     }),
    };
  }

  std::vector<Part> membranes(int s, const OwnCells& own) const {
    const TriangleMesh& mesh = done_.problem.species[s].shape->mesh();
    const auto vertices = std::int64_t(mesh.vertices.size()), triangles = std::int64_t(mesh.triangles.size());
    const std::int64_t n = done_.tally.counts[s];
    const auto& cells = done_.result.cells;
    using Real = std::vector<float>;
    const auto perTriangle = [&](const char* name, auto value) {
      return part<float>({Place::data, name, Type::float32, 1, n * triangles}, own,
                         [triangles, value](std::size_t i, std::int64_t, Real& to) {
                           to.insert(to.end(), std::size_t(triangles), float(value(i)));
                         });
    };
    return {
        part<float>({Place::points, "", Type::float32, 3, n * vertices}, own,
                    [&](std::size_t i, std::int64_t, Real& to) {
                      for (const Vec3& v : mesh.vertices) {
                        const Vec3 p = cells[i].placement(v);
                        for (int k = 0; k < 3; ++k) to.push_back(float(p[k]));
                      }
                    }),
        part<std::int64_t>(
            {Place::polygonConnectivity, "", Type::int64, 1, 3 * n * triangles}, own,
            [&mesh, vertices](std::size_t, std::int64_t number, std::vector<std::int64_t>& to) {
              for (const Triangle& t : mesh.triangles)
                for (const int v : t) to.push_back(number * vertices + v);
            }),
        part<std::int64_t>({Place::polygonOffsets, "", Type::int64, 1, n * triangles}, own,
                           [triangles](std::size_t, std::int64_t number, std::vector<std::int64_t>& to) {
                             for (std::int64_t i = 1; i <= triangles; ++i)
                               to.push_back(3 * (number * triangles + i));
                           }),
        part<std::int32_t>(
            {Place::data, "id", Type::int32, 1, n * triangles}, own,
            [&own, triangles](std::size_t, std::int64_t number, std::vector<std::int32_t>& to) {
              to.insert(to.end(), std::size_t(triangles), std::int32_t(own.firstOfAll + number));
            }),
        perTriangle("gap", [&](std::size_t i) { return measures_.gap[i]; }),
        perTriangle("local_hematocrit", [&](std::size_t i) { return measures_.localHematocrit[i]; }),
    };
  }

  const Finished& done_;
  const CellMeasures& measures_;
  const Communicator& ranks_;
  SharedFiles files_;
};

}  // namespace

std::vector<fs::path> vtpFiles(const Problem& problem, const OutputRequest& output) {
  std::vector<fs::path> files;
  for (const CellSpecies& species : problem.species) {
    if (species.mostCells() == 0) continue;
    const std::string base = (output.folder / species.name).string();
    if (output.writesVtp()) files.insert(files.end(), {base + ".vtp", base + "_mesh.vtp"});
    if (output.vtpMeshes) files.emplace_back(base + "_cells.vtp");
  }
  if (output.writesVtp()) files.push_back(lumenFile(output));
  return files;
}

void writeVtp(const Finished& done, const CellMeasures& measures) {
  Writer(done, measures)();
}

}  // namespace packmesh::hemocell
