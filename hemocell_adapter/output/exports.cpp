// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/exports.h"

#include <fmt/format.h>

#include <iterator>
#include <set>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/output/exports/formats.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/core/error.h"

namespace packmesh::hemocell {
namespace {

using Export = std::vector<ExportedFile> (*)(const Problem&, const CellCounts&);
constexpr Export exports[] = {  // in the order of exportFormats
    csvExport, espressoExport, lammpsExport, lammpsMolecularExport, mirheoExport, npfemExport, stlExport};
static_assert(std::size(exports) == std::size(exportFormats));

Export exportNamed(const std::string& format) {
  for (std::size_t i = 0; i < std::size(exports); ++i)
    if (format == exportFormats[i]) return exports[i];
  throw InputError("'" + format + "' is not an export format");
}

}  // namespace

std::vector<ExportedFile> exportedFiles(const Problem& problem, const std::vector<std::string>& formats,
                                        const std::vector<std::int64_t>& counts) {
  std::vector<ExportedFile> files;
  std::set<std::string> names;
  for (const CellSpecies& species : problem.species)
    if (!formats.empty() && !isCellName(species.name))
      throw InputError(fmt::format("export: other programs may misread the name '{}'; expected {}",
                                   species.name, expectedCellName()));
  for (const std::string& format : formats)
    for (ExportedFile& file : exportNamed(format)(problem, counts))
      if (names.insert(file.name).second) files.push_back(std::move(file));  // formats share templates
  return files;
}

}  // namespace packmesh::hemocell
