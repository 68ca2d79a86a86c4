// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/problem/job_species.h"

#include <fmt/format.h>

#include <algorithm>

#include "hemocell_adapter/base/exit_codes.h"
#include "packMesh/core/input_file.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;
constexpr double packCellsPlateletRatio = 0.07;

bool isRedCell(const SpeciesRequest& request) {
  return request.redCell.value_or(request.name.find("RBC") != std::string::npos);
}

/// Does the request say that there are such cells, or is it only a detail of cells that another one asks for?
bool selects(const SpeciesRequest& request) {
  return request.count || request.ratio || request.ellipsoidAxes || request.meshFile || request.fixed ||
         request.start;
}

/// A red species whose number the hematocrit decides.
SpeciesRequest* fillerOf(std::vector<SpeciesRequest>& species) {
  for (SpeciesRequest& request : species) {
    if (isRedCell(request) && !request.count && !request.ratio) return &request;
  }
  return nullptr;
}

/// Where what is asked for stands, for messages.
std::string sourceOf(const Job& job) {
  return job.config ? job.config->file.string() : "command line";
}

std::optional<AxisCone> coneOf(const SpeciesRequest& request) {
  if (!request.axis) {
    if (request.spread)
      throw InputError(fmt::format("cell '{}' has a spread, but no axis around which", request.name));
    return {};
  }
  if (!(request.axis->norm() > 0.0))
    throw InputError(fmt::format("cell '{}': its axis 0 0 0 is no direction", request.name));
  constexpr double degree = 3.14159265358979323846 / 180.0;
  return AxisCone{request.axis->normalized(), request.spread.value_or(0.0) * degree};
}

/// Reads the cells that are there.
void readPresent(const SpeciesRequest& request, JobSpecies& species, std::vector<std::string>& warnings) {
  std::error_code ignored;
  if (request.fixed && request.start && fs::equivalent(*request.fixed, *request.start, ignored))
    throw InputError(fmt::format("cell '{}': the cells of {} cannot both stay (fixed) and move (start)",
                                 request.name, request.fixed->string()));
  const auto read = [&](const std::optional<fs::path>& file, std::vector<PosLine>& lines, std::string& from) {
    if (!file) return;
    lines = readPos(*file, &warnings);
    from = file->string();
  };
  read(request.fixed, species.fixed, species.fixedFrom);
  read(request.start, species.start, species.startFrom);
}

/// "A, B and C".
std::string enumerated(const std::vector<std::string>& names) {
  if (names.size() < 2) return fmt::format("{}", fmt::join(names, ""));
  return fmt::format("{} and {}", fmt::join(names.begin(), names.end() - 1, ", "), names.back());
}

/// The cells that a folder describes, for people who ask for one that it does not: "; the folder has PLT.xml
/// and RBC_HO.xml ...".
std::string cellsInstead(const fs::path& folder, const SpeciesRequest& request) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& file = entry->path();
    constexpr std::uintmax_t largest = 1 << 20;  // [bytes]
    std::error_code ignored;
    if (file.extension() != ".xml" || !fs::is_regular_file(file, ignored)) continue;
    if (fs::file_size(file, ignored) > largest) continue;
    try {
      if (contentOf(file, "a cell").find("<MaterialModel") != std::string::npos)
        names.push_back(file.stem().string());
    } catch (const InputError&) {
      continue;  // only a hint
    }
  }
  if (names.empty()) return "";
  std::sort(names.begin(), names.end());
  std::vector<std::string> files;
  for (const std::string& name : names) files.push_back(name + ".xml");
  const std::string text = "; the folder has " + enumerated(files);
  const bool red = isRedCell(request);
  const auto like = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    SpeciesRequest other;
    other.name = name;
    return red ? isRedCell(other) : name.compare(0, request.name.size(), request.name) == 0;
  });
  if (like == names.end()) return text;
  return text + fmt::format(". For that cell: <packing> <species name=\"{}\"{}/> </packing>", *like,
                            red ? "" : " count=\"n\"");
}

/// @param job receives warnings
JobSpecies resolved(Job& job, const SpeciesRequest& request) {
  JobSpecies species;
  species.name = request.name;
  species.redCell = isRedCell(request);
  species.count = request.count;
  species.ratio = request.ratio;
  species.statedDistanceFromSolid = request.minimumDistanceFromSolid;
  species.stock = request.stock.value_or(0);
  species.ownWallClearance =
      std::max(request.wallClearance.value_or(0.0), species.redCell ? job.cellFreeLayer : 0.0);
  species.cone = coneOf(request);
  readPresent(request, species, job.warnings);
  if (!species.count && !species.ratio && !(job.hematocrit && species.redCell))
    species.count = std::int64_t(species.fixed.size() + species.start.size());
  if (request.meshFile) {
    species.kind = JobSpecies::Template::mesh;
    species.meshFile = *request.meshFile;
    species.meshScale = request.meshScale.value_or(1.0);
    species.meshFrame = request.meshFrame.value_or(MeshFrame::hemocell);
    species.origin = fmt::format(
        "{}, {}", request.meshFile->filename().string(),
        species.meshFrame == MeshFrame::hemocell ? toString(Construction::meshFromStl) : "axes of the file");
    return species;
  }
  if (request.meshScale || request.meshFrame) {
    throw UsageError(fmt::format("cell '{}' has a mesh {} but no mesh file (--cell-mesh)", request.name,
                                 request.meshScale ? "scale" : "frame"));
  }
  if (request.ellipsoidAxes) {
    species.kind = JobSpecies::Template::ellipsoid;
    species.ellipsoidAxes = *request.ellipsoidAxes;
    species.origin = "ellipsoid";
    return species;
  }
  if (job.config) {
    const fs::path xml = job.config->folder / (request.name + ".xml");
    if (!isThere(xml))
      throw InputError(fmt::format("{}: no such file; it must tell how HemoCell builds the cell '{}'{}",
                                   xml.string(), request.name, cellsInstead(job.config->folder, request)));
    species.model = readCellXml(xml, request.name, request.construction);
    species.origin = fmt::format("{}, {}", xml.filename().string(), toString(species.model.construction));
    return species;
  }
  if (const auto model = defaultModel(request.name)) {
    species.model = *model;
    species.origin = fmt::format("HemoCell's defaults, {}", toString(species.model.construction));
    return species;
  }
  if (const auto axes = defaultEllipsoid(request.name)) {
    species.kind = JobSpecies::Template::ellipsoid;
    species.ellipsoidAxes = Vec3((*axes)[0], (*axes)[1], (*axes)[2]);
    species.origin = "packCells' ellipsoid";
    return species;
  }
  throw UsageError(
      fmt::format("cell '{}' is unknown: give it axes (--cell) or a mesh (--cell-mesh)", request.name));
}

/// More than one cell per red cell is hardly meant: blood has some 0.07 platelets per red cell.
void warnOfLargeRatios(Job& job) {
  for (const JobSpecies& species : job.species)
    if (!species.redCell && species.ratio.value_or(0.0) > 1.0)
      job.warnings.push_back(fmt::format(
          "a ratio of {0:.15g} is {0:.15g} {1} for each red cell, not per cent; {2:.15g} may be meant",
          *species.ratio, species.name, *species.ratio / 100.0));
}

/// A hematocrit and red-cell counts contradict each other; the command line wins, a file alone is at fault.
void settleHematocrit(Job& job, Settings& settings, const Settings& options) {
  const auto countedOnCommandLine = [&](const SpeciesRequest& s) {
    const SpeciesRequest* option = findSpecies(options, s.name);
    return option && option->count;
  };
  if (!job.hematocrit || fillerOf(settings.species)) return;
  std::vector<SpeciesRequest>& all = settings.species;
  const bool anyRed = std::any_of(all.begin(), all.end(), isRedCell);
  if (!options.hematocrit && std::any_of(all.begin(), all.end(), [&](const SpeciesRequest& s) {
        return isRedCell(s) && countedOnCommandLine(s);
      })) {
    job.hematocrit.reset();
  } else if (options.hematocrit && anyRed) {
    for (SpeciesRequest& s : all) {
      if (!isRedCell(s) || countedOnCommandLine(s)) continue;
      s.count.reset();
      s.ratio.reset();
      return;
    }
  } else if (!options.hematocrit && anyRed) {
    throw InputError(fmt::format(
        "{}: <hematocrit> and a count or ratio for every red cell; one of them decides", sourceOf(job)));
  }
}

}  // namespace

void choosePackedSpecies(Job& job, Settings settings, const Settings& options) {
  const bool listed = job.config && !job.config->packing.species.empty();
  std::vector<SpeciesRequest>& all = settings.species;
  for (SpeciesRequest& request : all) {  // a count on the command line replaces a ratio in the file
    const SpeciesRequest* option = findSpecies(options, request.name);
    if (option && option->count) request.ratio.reset();
  }
  // Details without cells: kept aside, to be applied to species that a hematocrit adds.
  std::vector<SpeciesRequest> details;
  for (auto it = all.begin(); it != all.end();) {
    if (selects(*it) || (listed && findSpecies(job.config->packing, it->name))) {
      ++it;
    } else {
      details.push_back(*it);
      it = all.erase(it);
    }
  }
  const auto add = [&](const std::string& name, std::size_t at) -> SpeciesRequest& {
    SpeciesRequest request;
    request.name = name;
    for (auto it = details.begin(); it != details.end(); ++it) {
      if (it->name != name) continue;
      request = *it;
      details.erase(it);
      break;
    }
    return *all.insert(all.begin() + std::ptrdiff_t(std::min(at, all.size())), request);
  };

  settleHematocrit(job, settings, options);
  if (job.hematocrit) {
    if (!fillerOf(all)) {
      if (std::any_of(all.begin(), all.end(), [](const SpeciesRequest& s) { return s.name == "RBC"; }))
        throw InputError("the hematocrit decides how many 'RBC' there are, so they can have no count");
      add("RBC", 0);
    }
    const auto platelet =
        std::find_if(all.begin(), all.end(), [](const SpeciesRequest& s) { return s.name == "PLT"; });
    const double ratio = settings.plateletRatio.value_or(packCellsPlateletRatio);
    if (platelet != all.end()) {
      if (settings.plateletRatio) {
        platelet->ratio = ratio;
        platelet->count.reset();
      }
    } else if (settings.plateletRatio ? ratio > 0 : !listed) {
      const bool known = !job.config || isThere(job.config->folder / "PLT.xml");
      if (known) {
        add("PLT", 1).ratio = ratio;
      } else if (settings.plateletRatio) {
        throw InputError(fmt::format("{}: no such file; --plt_ratio asks for platelets",
                                     (job.config->folder / "PLT.xml").string()));
      }
    }
  } else if (settings.plateletRatio) {
    job.warnings.push_back("--plt_ratio is ignored: it belongs to --hematocrit");
  }
  if (!details.empty()) {
    throw UsageError(
        fmt::format("settings for '{}', but there are no such cells to pack", details.front().name));
  }
  if (all.empty()) {
    throw UsageError(
        "how many cells? Give --hematocrit h or counts such as --rbc n, or the same in <packing>");
  }
  for (const SpeciesRequest& request : all) {
    if (!request.count && !request.ratio && !request.fixed && !request.start &&
        !(job.hematocrit && isRedCell(request))) {
      throw InputError(fmt::format("{}: how many '{}'? Give it a count{}", sourceOf(job), request.name,
                                   isRedCell(request) ? " or a hematocrit" : " or a ratio"));
    }
    job.species.push_back(resolved(job, request));
  }
  warnOfLargeRatios(job);
}

void chooseCheckedSpecies(Job& job, const Settings& settings) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(job.outputDirectory, error)) {
    if (entry.path().extension() == ".pos") names.push_back(entry.path().stem().string());
  }
  if (error) throw InputError(fmt::format("{}: cannot be read as a folder", job.outputDirectory.string()));
  std::sort(names.begin(), names.end());
  for (const SpeciesRequest& request : settings.species) {
    if (std::find(names.begin(), names.end(), request.name) == names.end()) {
      job.warnings.push_back(fmt::format("there is no {}.pos", request.name));
    }
  }
  for (const std::string& name : names) {
    SpeciesRequest request;
    if (const SpeciesRequest* asked = findSpecies(settings, name)) request = *asked;
    request.name = name;
    const bool own = request.meshFile || request.ellipsoidAxes;
    const bool known =
        own || (job.config ? isThere(job.config->folder / (name + ".xml"))
                           : defaultModel(name).has_value() || defaultEllipsoid(name).has_value());
    if (known) {
      job.species.push_back(resolved(job, request));
    } else {
      job.unchecked.push_back(name + ".pos");
      job.warnings.push_back(fmt::format("{}.pos is not checked: {}", name,
                                         job.config
                                             ? "there is no " + name + ".xml"
                                             : "its shape is unknown (--cell or --cell-mesh tells it)"));
    }
  }
  if (job.species.empty()) {
    throw InputError(job.unchecked.empty()
                         ? fmt::format("{}: no .pos files to check", job.outputDirectory.string())
                         : fmt::format("nothing to check: {}", job.warnings.back()));
  }
}

}  // namespace packmesh::hemocell
