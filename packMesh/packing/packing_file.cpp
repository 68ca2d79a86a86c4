// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/packing_file.h"

#include <algorithm>
#include <limits>
#include <string>

#include "packMesh/core/error.h"
#include "packMesh/core/version.h"
#include "packMesh/io/atomic_files.h"
#include "packMesh/io/hdf5_file.h"

namespace packmesh {

void readTogether(const std::filesystem::path& file, const Communicator& ranks,
                  const std::function<void()>& work) {
  std::string error;
  try {
    work();
  } catch (const InputError& found) {
    error = found.what();
  }
  if (ranks.any(!error.empty()))
    throw InputError(error.empty() ? file.string() + ": another rank cannot read it" : error);
}

void writeTogether(const Communicator& ranks, const std::function<void()>& work) {
  std::string error;
  try {
    work();
  } catch (const OutputError& failure) {
    error = failure.what();
  }
  const auto failed = ranks.min(std::int64_t(error.empty() ? ranks.size() : ranks.rank()));
  if (failed < ranks.size()) throw OutputError(ranks.broadcast(error, static_cast<int>(failed)));
}

std::unique_ptr<AtomicFiles> writtenHdf5(const std::filesystem::path& file, const Communicator& ranks,
                                         std::uint64_t userBlock,
                                         const std::function<void(Hdf5Writer&)>& content) {
  auto files = std::make_unique<AtomicFiles>();
  writeTogether(ranks, [&] {
    if (ranks.rank() == 0) files->begin(file);
  });
  writeTogether(ranks, [&] {
    Hdf5Writer out(*files, ranks, userBlock);
    content(out);
    out.close();
  });
  return files;
}

void commitTogether(std::unique_ptr<AtomicFiles> files, const Communicator& ranks) {
  writeTogether(ranks, [&] {
    if (ranks.rank() != 0) return;
    files->end();
    files->commit();
  });
}

void writeMeshes(const std::filesystem::path& file, const std::vector<NamedMesh>& meshes) {
  const Communicator alone;
  AtomicFiles files;
  files.begin(file);
  Hdf5Writer out(files, alone);
  out.attribute("/", "unit", std::string("µm"));
  out.group("/meshes");
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const std::string path = "/meshes/" + std::to_string(i);
    out.group(path);
    out.attribute(path, "name", meshes[i].name);
    out.attribute(path, "kind", meshes[i].kind);
    writeMesh(out, path, meshes[i].mesh);
  }
  out.close();
  files.end();
  files.commit();
}

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t packingVersion = 1;

/// Of faults, nobody looks at more.
constexpr std::size_t mostFaults = 1000;

void append(std::vector<double>& to, const Vec3& v) {
  to.insert(to.end(), v.data(), v.data() + 3);
}

void writeSpecies(Hdf5Writer& out, const Physics& physics, const std::vector<TemplateSource>& sources) {
  out.group("/species");
  for (std::size_t s = 0; s < physics.species.size(); ++s) {
    const Species& species = physics.species[s];
    const TemplateSource source = sources.empty() ? TemplateSource() : sources[s];
    const std::string path = pathOfSpecies(s);
    out.group(path);
    out.attribute(path, "name", species.kindName());
    out.attribute(path, "count", species.count);
    out.attribute(path, "red", std::int64_t(species.inHematocrit));
    out.attribute(path, "unlike_file", source.unlikeFile);
    std::vector<double> origin;
    if (source.originInFile) append(origin, *source.originInFile);
    out.commonTable(path + "/origin_in_file", 3, origin);
    writeMesh(out, path, physics.shapeOf(species).mesh());
  }
}

void writeFaults(Hdf5Writer& out, const Certificate& certificate) {
  out.group("/faults");
  std::vector<std::int64_t> pairs, misplaced, selfIntersecting;
  for (std::size_t i = 0; i < std::min(mostFaults, certificate.overlapping.size()); ++i)
    pairs.insert(pairs.end(), {certificate.overlapping[i].first, certificate.overlapping[i].second});
  out.group("/faults/reasons");
  for (std::size_t i = 0; i < std::min(mostFaults, certificate.misplaced.size()); ++i) {
    misplaced.push_back(certificate.misplaced[i].cell);
    out.attribute("/faults/reasons", std::to_string(i).c_str(), certificate.misplaced[i].reason);
  }
  for (const SelfIntersectingCell& one : certificate.selfIntersecting)
    if (selfIntersecting.size() < mostFaults) selfIntersecting.push_back(one.cell);
  out.commonTable("/faults/overlapping", 2, pairs);
  out.commonTable("/faults/misplaced", 1, misplaced);
  out.commonTable("/faults/self_intersecting", 1, selfIntersecting);
}

void writeCells(Hdf5Writer& out, const Physics& physics, const PackingResult& packing,
                const std::vector<CellColumn>& columns, const Communicator& ranks) {
  out.group("/cells");
  std::vector<double> positions, orientations;
  std::vector<std::int32_t> species;
  for (std::size_t i = 0; i < packing.cells.size(); ++i) {
    species.push_back(packing.cells[i].species);
    append(positions, packing.cells[i].placement.translation);
    const Quaternion& q = packing.poses[i].orientation;
    orientations.insert(orientations.end(), {q.w(), q.x(), q.y(), q.z()});
  }
  std::vector<std::int64_t> ids(packing.cells.size());
  std::int64_t next = ranks.sumBefore({std::int64_t(ids.size())}).front();
  for (std::int64_t& id : ids) id = next++;
  out.table("/cells/id", 1, ids);
  out.table("/cells/species", 1, species);
  out.table("/cells/position", 3, positions);
  out.table("/cells/orientation", 4, orientations);
  writeColumns(out, columns);
  writeMembranes(
      out, physics.species.size(), species,
      [&](std::size_t i) {
        const PlacedCell& cell = packing.cells[i];
        return physics.isDeformed(cell) ? &physics.shapeOf(cell).mesh().vertices : nullptr;
      },
      ranks);
}

void writeAll(Hdf5Writer& out, const Physics& physics, const PackingResult& packing,
              const PackingDetails& details, const Communicator& ranks) {
  out.attribute("/", "kind", std::string("packMesh packing"));
  out.attribute("/", "version", packingVersion);
  out.attribute("/", "writer", writer());
  out.attribute("/", "unit", std::string("µm"));
  writeSpecies(out, physics, details.templates);
  if (details.lumen) writeLumen(out, *physics.container);
  writeCells(out, physics, packing, details.columns, ranks);
  writeFaults(out, packing.certificate);
}

}  // namespace

std::string writer() {
  return std::string("packMesh ") + version() + " (" + gitHash() + ")";
}

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
  out.table(membraneRows, 1, rows);
  for (std::size_t s = 0; s < species; ++s) {
    const auto width = int(-ranks.min(-size[s]));
    if (own[s] > 0) out.table(pathOfSpecies(s) + "/membranes", width, tables[s], 3);
  }
}

std::vector<CellColumn> columnsOf(const CellMeasures& measures, std::size_t cells) {
  std::vector<CellColumn> columns;
  for (const CellMeasures::Column& column : CellMeasures::columns) {
    columns.push_back({column.name, 1, measures.*column.values});
    columns.back().values.resize(cells, std::numeric_limits<double>::quiet_NaN());
  }
  return columns;
}

void writeLumen(Hdf5Writer& out, const Container& lumen) {
  out.group("/lumen");
  out.attribute("/lumen", "description", lumen.describe());
  std::vector<double> box;
  for (const Vec3& row : {lumen.bounds().lo, lumen.bounds().hi, lumen.period()}) append(box, row);
  out.commonTable("/lumen/box", 3, box);
  if (lumen.wall()) writeMesh(out, "/lumen", lumen.surface());
}

void writeColumns(Hdf5Writer& out, const std::vector<CellColumn>& columns) {
  for (const CellColumn& column : columns) out.table("/cells/" + column.name, column.width, column.values);
}

std::unique_ptr<AtomicFiles> writtenPacking(const fs::path& file, const Physics& physics,
                                            const PackingResult& packing, const PackingDetails& details,
                                            const Communicator& ranks) {
  return writtenHdf5(file, ranks, 0,
                     [&](Hdf5Writer& out) { writeAll(out, physics, packing, details, ranks); });
}

}  // namespace packmesh
