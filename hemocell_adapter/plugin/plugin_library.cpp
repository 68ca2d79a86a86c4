// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file The library of the plug-in: what packMesh/hemocell.h, compiled with HemoCell, has it do for a
/// running system.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "hemocell_adapter/base/messages.h"
#include "hemocell_adapter/base/ranks.h"
#include "hemocell_adapter/hemocell/lattice.h"
#include "hemocell_adapter/session/running_hemocell.h"
#include "hemocell_adapter/settings/command_line.h"
#include "hemocell_adapter/settings/request_json.h"
#include "packMesh/core/pose.h"
#include "packMesh/hemocell_system.h"
#include "packMesh/parallel/communicator.h"

namespace packmesh::hemocell {

/// Whether HemoCell can lose cells at the first iteration. It shifts the particles that a rank receives from
/// another one by the period in the buffer itself, for each pair of blocks and each image of a block in turn,
/// so that all after the first are shifted repeatedly (Proposals to HemoCell, 9). This does no harm where a
/// block spans the period: the block then makes the images itself. Neither where the blocks of a rank happen
/// to pass on what is missing, in small systems. Collective.
bool losesCells(const plugin::System& system, const Communicator& ranks);

/// Warns if so, and says what helps. Collective.
void warnOfLostCells(const plugin::System& system, const Communicator& ranks);

namespace {

/// The nodes of a block, both ends included.
struct Extent {
  std::int64_t rank;
  std::array<std::int64_t, 3> first, last;
};

/// Whether `from`, moved by `images` periods, meets the envelope of `to`.
bool reaches(const Extent& from, const std::array<int, 3>& images, const Extent& to,
             const plugin::System& system) {
  for (int a = 0; a < 3; ++a) {
    const std::int64_t shift = images[a] * (system.last[a] - system.first[a] + 1);
    if (from.first[a] + shift > to.last[a] + system.particleEnvelope ||
        from.last[a] + shift < to.first[a] - system.particleEnvelope)
      return false;
  }
  return true;
}

}  // namespace

bool losesCells(const plugin::System& system, const Communicator& ranks) {
  std::vector<Extent> mine;
  for (const plugin::Block& block : system.blocks) mine.push_back({ranks.rank(), block.first, block.last});
  std::vector<int> exchanges(ranks.size(), 0);    // across periodic faces, with each rank
  std::vector<bool> needed(ranks.size(), false);  // some of them
  for (const Extent& from : ranks.gatherAll(mine)) {
    if (from.rank == ranks.rank()) continue;
    for (const Extent& to : mine)
      for (int image = 0; image < 27; ++image) {
        const std::array<int, 3> images = {image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1};
        bool across = false, possible = true, divided = false;
        for (int a = 0; a < 3; ++a) {
          if (images[a] == 0) continue;
          across = true;
          possible = possible && system.periodic[a];
          divided = divided || to.first[a] > system.first[a] || to.last[a] < system.last[a];
        }
        if (!across || !possible || !reaches(from, images, to, system)) continue;
        ++exchanges[from.rank];
        needed[from.rank] = needed[from.rank] || divided;
      }
  }
  bool loses = false;
  for (int r = 0; r < ranks.size(); ++r) loses = loses || (exchanges[r] > 1 && needed[r]);
  return ranks.any(loses);
}

void warnOfLostCells(const plugin::System& system, const Communicator& ranks) {
  if (ranks.alone() || !losesCells(system, ranks)) return;
  const int axes = int(system.periodic[0]) + int(system.periodic[1]) + int(system.periodic[2]);
  log::warning(fmt::format(
      "HemoCell 2.7 can delete cells at periodic faces in the first iteration: with {} on {} ranks, ranks "
      "exchange particles across these faces more than once, and HemoCell then shifts them repeatedly. Run "
      "on "
      "one rank, {}, or correct HemoCell (Proposals to HemoCell, 9). To verify, call "
      "packmesh::verifyParticles(hemocell, loaded) after the first iterate()",
      axes == 1 ? "several atomic blocks per rank" : fmt::format("{} periodic axes", axes), ranks.size(),
      axes == 1 ? "with one atomic block per rank"
                : "call setSystemPeriodicity(axis, false) for all axes but one"));
}

}  // namespace packmesh::hemocell

namespace packmesh::plugin {

const int interface_ba88018d = 0;

namespace {

namespace fs = std::filesystem;

struct PosHead {
  std::int64_t count = -1;  ///< as HemoCell reads it; negative: no number
  bool onlyCount = false;   ///< nothing follows
};

std::optional<PosHead> headOf(const fs::path& file) {
  std::ifstream in(file);
  if (!in) return {};
  PosHead head;
  std::string next;
  if (!(in >> head.count)) head.count = -1;
  head.onlyCount = head.count >= 0 && !(in >> next);
  return head;
}

bool written(const fs::path& file, std::int64_t count) {
  std::ofstream out(file);
  out << count << '\n';
  return bool(out.flush());
}

}  // namespace

void writeCounts(const std::vector<std::string>& names, const std::vector<std::int64_t>& counts,
                 const std::string& checkpointFolder, bool periodic) {
  const fs::path folder = checkpointFolder;
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  const bool earlier = fs::exists(folder / "checkpoint.xml", ignored);  // the checkpoint of another run
  std::string unwritten, other, kept;
  const auto add = [](std::string& list, const std::string& item) {
    list += (list.empty() ? "" : ", ") + item;
  };
  for (std::size_t t = 0; t < names.size(); ++t) {
    const fs::path here = names[t] + ".pos";
    for (const fs::path& file : {here, folder / here}) {
      const std::optional<PosHead> head = headOf(file);
      if (head && head->count == counts[t]) continue;
      if (head && !head->onlyCount) {
        add(other, head->count < 0 ? fmt::format("{} has no number of cells", file.string())
                                   : fmt::format("{} announces {}, {} were added", file.string(), head->count,
                                                 counts[t]));
        continue;
      }
      if (head && earlier && file != here) {
        const fs::path old = file.string() + ".old";
        fs::rename(file, old, ignored);
        add(kept, old.string());
      }
      if (!written(file, counts[t])) add(unwritten, file.string());
    }
  }
  if (!kept.empty())
    hemocell::log::warning(
        fmt::format("{} has a checkpoint of another run, whose numbers of cells are now in {}: to restart "
                    "from it, rename "
                    "them back",
                    folder.string(), kept));
  if (!unwritten.empty())
    hemocell::log::warning(fmt::format(
        "Cannot write {} with the number of cells: a restart would delete cells across periodic faces",
        unwritten));
  if (!other.empty() && periodic)
    hemocell::log::warning(
        fmt::format("HemoCell takes the number of cells from .pos files when it loads a checkpoint ({}). "
                    "hemocell.loadCheckPoint() would delete the cells across periodic faces: call "
                    "packmesh::loadCheckPoint(hemocell) "
                    "instead, or remove the files",
                    other));
}

namespace {

using hemocell::Lattice;
using hemocell::RunningSystem;

hemocell::BuiltCell builtCell(const CellType& type, double dx) {
  hemocell::BuiltCell cell;
  cell.name = type.name;
  cell.minimumDistanceFromSolid = type.minimumDistanceFromSolid;
  if (type.volume > 0.0) cell.hemocellVolume = type.volume;
  for (const auto& v : type.vertices) cell.mesh.vertices.push_back(dx * Vec3(v[0], v[1], v[2]));
  cell.mesh.triangles = type.triangles;
  const Vec3 center = boundingBox(cell.mesh).center();
  for (Vec3& v : cell.mesh.vertices) v -= center;
  return cell;
}

/// The lattice of which every rank has blocks. All ranks call.
std::shared_ptr<const Lattice> latticeOf(const System& system, const Communicator& ranks) {
  std::array<int, 3> nodes{};
  for (int a = 0; a < 3; ++a) nodes[a] = int(system.last[a] - system.first[a] + 1);
  auto lattice = std::make_shared<Lattice>(nodes, system.dx);
  for (int k = 0; k < nodes[2]; ++k)
    for (int j = 0; j < nodes[1]; ++j) lattice->setFluid(0, nodes[0] - 1, j, k, false);
  for (const Block& block : system.blocks) {
    std::array<int, 3> n{}, at{};
    for (int a = 0; a < 3; ++a) {
      n[a] = int(block.last[a] - block.first[a] + 1);
      at[a] = int(block.first[a] - system.first[a]);
    }
    for (int j = 0; j < n[1]; ++j)  // in this order, the words that change stay in the cache
      for (int i = 0; i < n[0]; ++i) {
        const unsigned char* const fluid = &block.fluid[(std::size_t(i) * n[1] + j) * n[2]];
        for (int k = 0; k < n[2]; ++k)
          if (fluid[k]) lattice->setFluid(at[0] + i, at[1] + j, at[2] + k, true);
      }
  }
  lattice->uniteFluid(ranks);
  return lattice;
}

/// Least nodes of a block along each axis. All ranks call.
std::array<int, 3> smallestBlock(const System& system, const Communicator& ranks) {
  std::array<int, 3> smallest{};
  for (int a = 0; a < 3; ++a) {
    std::int64_t nodes = system.last[a] - system.first[a] + 1;
    for (const Block& block : system.blocks) nodes = std::min(nodes, block.last[a] - block.first[a] + 1);
    smallest[a] = int(ranks.min(nodes));
  }
  return smallest;
}

std::shared_ptr<const hemocell::Case> caseOf(const System& system, const Communicator& ranks) {
  auto simulation = std::make_shared<hemocell::Case>();
  hemocell::together(ranks, [&] { *simulation = hemocell::packingSectionOf(system.config); });
  RunningSystem& running = simulation->running.emplace();
  running.lattice = latticeOf(system, ranks);
  running.periodic = system.periodic;
  running.isPreInlet = system.isPreInlet;
  for (const CellType& type : system.types) running.cells.push_back(builtCell(type, system.dx));
  hemocell::Domain& domain = simulation->domain;
  domain.dx = system.dx;
  domain.dxWhere = "<dx>";
  domain.boxNodes = running.lattice->nodes();
  domain.particleEnvelope = system.particleEnvelope;
  domain.particleEnvelopeWhere = "<particleEnvelope>";
  domain.smallestBlock = smallestBlock(system, ranks);
  return simulation;
}

/// The species that options state, in HemoCell's order, before unknown names.
hemocell::Json speciesOf(const System& system, const PackingOptions& options) {
  hemocell::Json species = hemocell::Json::array();
  std::set<std::string> known;
  const auto add = [&](const std::string& name) {
    const auto count = options.counts.find(name);
    const auto ratio = options.ratios.find(name);
    if ((count == options.counts.end() && ratio == options.ratios.end()) || !known.insert(name).second)
      return;
    hemocell::Json one = {{"name", name}};
    if (count != options.counts.end()) one["count"] = count->second;
    if (ratio != options.ratios.end()) one["ratio"] = ratio->second;
    species.push_back(one);
  };
  for (const CellType& type : system.types) add(type.name);
  for (const auto& [name, count] : options.counts) add(name);
  for (const auto& [name, ratio] : options.ratios) add(name);
  return species;
}

/// What is asked for: the members that are set, over the options in `more`.
hemocell::Request requestOf(const System& system, const PackingOptions& options,
                            const hemocell::Case& simulation) {
  hemocell::Json json = {{"config", simulation.file.string()}};
  if (options.hematocrit >= 0.0) json["hematocrit"] = options.hematocrit;
  if (options.seed >= 0) json["seed"] = options.seed;
  if (options.clearance >= 0.0) json["clearance"] = options.clearance;
  if (options.wallClearance >= 0.0) json["wallClearance"] = options.wallClearance;
  if (!options.method.empty()) json["method"] = options.method;
  if (!options.stateFile.empty()) json["stateFile"] = options.stateFile;
  if (!options.posFolder.empty()) json["outputDirectory"] = options.posFolder;
  if (!options.periodic) json["ends"] = "closed";
  if (!options.counts.empty() || !options.ratios.empty()) json["species"] = speciesOf(system, options);
  return withJson(hemocell::readOptions(options.more), json, {hemocell::Origin::Kind::member, ""});
}

/// What messages call a setting: a member of PackingOptions, or what is in `more`.
std::string termOf(const hemocell::SettingName& setting) {
  static const std::map<std::string, std::string> members = {
      {"hematocrit", "hematocrit"},        {"seed", "seed"},     {"clearance", "clearance"},
      {"wall-clearance", "wallClearance"}, {"method", "method"}, {"state", "stateFile"},
      {"output-dir", "posFolder"},         {"ends", "periodic"}, {"species.count", "counts"},
      {"species.ratio", "ratios"}};
  const auto member = members.find(setting.name);
  if (member == members.end()) return hemocell::termOfProgram(setting);
  std::string text = "PackingOptions::" + member->second;
  if (!setting.of.empty()) text += "[\"" + setting.of + "\"]";
  if (setting.name == "ends") return setting.value == "closed" ? text + " = false" : text;
  return setting.value.empty() || setting.value.size() == 1 ? text : text + " = \"" + setting.value + "\"";
}

using Vertex = std::array<double, 3>;

/// A cell without vertices. @param placement of the template [µm]
Cell inNodes(int type, std::int64_t id, const Placement& placement, const System& system) {
  Cell cell{type, id, {}, {}, {}};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) cell.linear[3 * row + column] = placement.linear(row, column);
    cell.translation[row] = placement.translation[row] / system.dx + double(system.first[row]);
  }
  return cell;
}

/// The region of a block in which it has vertices, in nodes of the whole lattice.
struct Region {
  std::int32_t rank;
  float lo[3], hi[3];
};

/// Sends cells to the ranks that have vertices of them.
class Distribution {
 public:
  Distribution(const System& system, const RunningSystem& running, const Communicator& ranks)
      : system_(system), running_(running), ranks_(ranks) {
    std::vector<Region> mine;
    for (const Block& block : system.blocks) {
      Region region{};
      region.rank = ranks.rank();
      for (int a = 0; a < 3; ++a) {
        region.lo[a] = float(block.first[a] - system.first[a]) - 0.5f;
        region.hi[a] = float(block.last[a] - system.first[a]) + 0.5f;
      }
      mine.push_back(region);
    }
    regions_ = ranks.gatherAll(mine);
  }

  std::vector<Cell> operator()(const hemocell::CellsToAdd& packed) const {
    struct Sent {
      int type;
      std::int64_t id;
      Placement placement;
    };
    std::vector<std::vector<Sent>> to(ranks_.size());
    std::vector<std::vector<std::vector<Vertex>>> verticesTo(ranks_.size());
    for (std::size_t i = 0; i < packed.cells.size(); ++i) {
      const packmesh::Cell& cell = packed.cells[i];
      TriangleMesh mesh = running_.cells[cell.species].mesh;
      if (!cell.vertices.empty()) mesh.vertices = cell.vertices;
      mesh = placed(mesh, packed.placements[i]);
      const Box box = boundingBox(mesh);
      std::vector<bool> sent(ranks_.size(), false);
      for (const Region& region : regions_) {
        if (sent[region.rank] || !meets(box, region)) continue;
        sent[region.rank] = true;
        to[region.rank].push_back({cell.species, cell.id, packed.placements[i]});
        std::vector<Vertex>& own = verticesTo[region.rank].emplace_back();
        if (cell.vertices.empty()) continue;
        for (const Vec3& v : mesh.vertices) {
          Vertex& vertex = own.emplace_back();
          for (int a = 0; a < 3; ++a) vertex[a] = v[a] / system_.dx + double(system_.first[a]);
        }
      }
    }
    to = ranks_.exchange(std::move(to));
    verticesTo = ranks_.exchangeRows(std::move(verticesTo));
    std::vector<Cell> received;
    for (std::size_t rank = 0; rank < to.size(); ++rank)
      for (std::size_t i = 0; i < to[rank].size(); ++i) {
        const Sent& cell = to[rank][i];
        received.push_back(inNodes(cell.type, cell.id, cell.placement, system_));
        received.back().vertices = std::move(verticesTo[rank][i]);
      }
    return received;
  }

 private:
  /// Whether an image of a box [µm] and a region have common points, up to a margin for rounding.
  bool meets(const Box& box, const Region& region) const {
    constexpr double margin = 0.01;  // [nodes]
    const double dx = running_.lattice->dx();
    for (int a = 0; a < 3; ++a) {
      const double lo = box.lo[a] / dx - margin, hi = box.hi[a] / dx + margin;
      const int n = running_.lattice->nodes()[a];
      bool any = false;
      for (int image = running_.periodic[a] ? -1 : 0; image <= (running_.periodic[a] ? 1 : 0); ++image)
        any = any || (lo + image * n <= region.hi[a] && hi + image * n >= region.lo[a]);
      if (!any) return false;
    }
    return true;
  }

  const System& system_;
  const RunningSystem& running_;
  const Communicator& ranks_;
  std::vector<Region> regions_;
};

/// The template where it fits best.
/// @param keepsVertices with those of the cell @param largest residual so far, raised to that of this fit
/// [µm]
packmesh::Cell fitted(const Cell& cell, const System& system, const RunningSystem& running,
                      bool keepsVertices, double& largest) {
  const std::vector<Vec3>& shape = running.cells[cell.type].mesh.vertices;
  std::vector<Vec3> points;
  for (const auto& v : cell.vertices)
    points.push_back(system.dx * Vec3(v[0] - double(system.first[0]), v[1] - double(system.first[1]),
                                      v[2] - double(system.first[2])));
  packmesh::Cell moved{cell.id, cell.type, bestPose(shape, points)};
  double squares = 0.0;
  for (std::size_t i = 0; i < shape.size(); ++i)
    squares += (points[i] - moved.pose.placement()(shape[i])).squaredNorm();
  largest = std::max(largest, std::sqrt(squares / double(shape.size())));
  if (keepsVertices) moved.vertices = inFrameOf(moved.pose, std::move(points));
  for (int a = 0; a < 3; ++a) {  // into the first period
    const double period = running.lattice->nodes()[a] * system.dx, lo = -0.5 * system.dx;
    double& p = moved.pose.position[a];
    if (system.periodic[a]) p -= period * std::floor((p - lo) / period);
  }
  return moved;
}

/// Calls work(simulation, ranks), and turns exceptions into a message.
template <class Work>
Filling guarded(const System& system, const Work& work) {
  hemocell::setTerms(termOf);
  const Communicator ranks = Communicator::copyOf(system.ranks);
  hemocell::log::setLevel(ranks.rank() > 0 ? hemocell::log::Level::silent : hemocell::log::Level::normal);
  Arrival failures(ranks);
  Filling filling;
  try {
    hemocell::requireConnected();
    filling = work(caseOf(system, ranks), ranks);
  } catch (const hemocell::AgreedFailure& failure) {
    filling.exitCode = int(failure.code());
    filling.message = hemocell::inTermsOfUser(failure.what());
  } catch (...) {
    const hemocell::Failure failure = hemocell::failureOfException();
    hemocell::endUnlessOfAll(failure, failures, ranks);
    filling.exitCode = int(failure.code);
    filling.message = hemocell::inTermsOfUser(failure.message);
  }
  return filling;
}

Filling distributed(const hemocell::CellsToAdd& packed, const System& system, const RunningSystem& running,
                    const Communicator& ranks) {
  hemocell::warnOfLostCells(system, ranks);
  Filling filling;
  filling.counts = packed.counts;
  filling.cells = Distribution(system, running, ranks)(packed);
  return filling;
}

}  // namespace

Filling fill(const System& system, const PackingOptions& options) {
  return guarded(system, [&](const auto& simulation, const Communicator& ranks) {
    hemocell::Request asked;
    hemocell::together(ranks, [&] { asked = requestOf(system, options, *simulation); });
    return distributed(hemocell::fill(simulation, asked, ranks), system, *simulation->running, ranks);
  });
}

Filling load(const System& system, const std::string& stateFile, bool leavesOut) {
  return guarded(system, [&](const auto& simulation, const Communicator& ranks) {
    return distributed(hemocell::fillFromState(simulation, stateFile, leavesOut, ranks), system,
                       *simulation->running, ranks);
  });
}

Filling save(const System& system, const std::vector<Cell>& cells, std::int64_t iteration,
             const std::string& stateFile, bool rigid) {
  return guarded(system, [&](const auto& simulation, const Communicator& ranks) {
    std::vector<packmesh::Cell> moved;
    double residual = 0.0;
    for (const Cell& cell : cells)
      moved.push_back(fitted(cell, system, *simulation->running, !rigid, residual));
    hemocell::saveCells(simulation, moved, residual, iteration, stateFile, ranks);
    return Filling();
  });
}

}  // namespace packmesh::plugin
