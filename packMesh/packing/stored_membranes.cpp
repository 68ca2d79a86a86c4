// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/stored_membranes.h"

#include <algorithm>
#include <cmath>

#include "packMesh/io/hdf5_reader.h"
#include "packMesh/io/hdf5_writer.h"

namespace packmesh {
namespace {

const char* const rowsPath = "/cells/membrane";

}  // namespace

std::string pathOfSpecies(std::size_t species) {
  return "/species/" + std::to_string(species);
}

void writeMembranes(Hdf5Writer& out, std::size_t species, const std::vector<std::int32_t>& speciesOfCells,
                    const std::function<const std::vector<Vec3>*(std::size_t)>& verticesOf,
                    const Communicator& ranks) {
  std::vector<std::vector<double>> tables(species);
  std::vector<std::int64_t> own(species, 0), size(species, 0);
  std::vector<std::int32_t> rows(speciesOfCells.size(), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::vector<Vec3>* const vertices = verticesOf(i);
    if (!vertices) continue;
    const std::int32_t s = speciesOfCells[i];
    rows[i] = std::int32_t(own[s]++);
    size[s] = std::int64_t(vertices->size());
    for (const Vec3& v : *vertices) tables[s].insert(tables[s].end(), v.data(), v.data() + 3);
  }
  const std::vector<std::int64_t> before = ranks.sumBefore(own);
  ranks.sum(own);
  if (std::all_of(own.begin(), own.end(), [](std::int64_t count) { return count == 0; })) return;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i] >= 0) rows[i] += std::int32_t(before[speciesOfCells[i]]);
  out.table(rowsPath, 1, rows);
  for (std::size_t s = 0; s < species; ++s) {
    const auto width = int(-ranks.min(-size[s]));
    if (own[s] > 0) out.table(pathOfSpecies(s) + "/membranes", width, tables[s], 3);
  }
}

bool StoredMembranes::areIn(const Hdf5Reader& in) {
  return in.has(rowsPath);
}

StoredMembranes::StoredMembranes(const Hdf5Reader& in, const std::vector<std::int32_t>& species,
                                 std::int64_t first, std::int64_t count)
    : species_(species) {
  row_ = in.table<std::int32_t>(rowsPath, 1, first, count);
  struct Range {
    std::int64_t begin = 0, end = 0;
  };
  std::vector<Range> ranges;  // by species
  for (std::size_t i = 0; i < row_.size(); ++i) {
    if (row_[i] < 0) continue;
    if (species_[i] < 0) in.fail("is damaged: it contains values out of range");
    ranges.resize(std::max(ranges.size(), std::size_t(species_[i]) + 1));
    Range& range = ranges[species_[i]];
    if (range.end == 0) range.begin = row_[i];
    range.begin = std::min<std::int64_t>(range.begin, row_[i]);
    range.end = std::max<std::int64_t>(range.end, row_[i] + 1);
  }
  rows_.resize(ranges.size());
  for (std::size_t s = 0; s < ranges.size(); ++s) {
    const std::int64_t rows = ranges[s].end - ranges[s].begin;
    if (rows == 0) continue;
    rows_[s].first = ranges[s].begin;
    rows_[s].width = in.size(pathOfSpecies(s) + "/vertices")[0] * 3;
    rows_[s].values =
        in.table<double>(pathOfSpecies(s) + "/membranes", int(rows_[s].width), ranges[s].begin, rows);
    for (const double x : rows_[s].values)
      if (!std::isfinite(x)) in.fail("is damaged: it contains values out of range");
  }
}

std::vector<Vec3> StoredMembranes::of(std::int64_t cell) const {
  std::vector<Vec3> vertices;
  if (row_[cell] < 0) return vertices;
  const Rows& rows = rows_[species_[cell]];
  const double* const values = &rows.values[(row_[cell] - rows.first) * rows.width];
  for (std::int64_t k = 0; k < rows.width; k += 3)
    vertices.emplace_back(values[k], values[k + 1], values[k + 2]);
  return vertices;
}

}  // namespace packmesh
