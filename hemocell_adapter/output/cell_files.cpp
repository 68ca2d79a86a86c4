// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/cell_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "hemocell_adapter/base/log.h"
#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/shared_files.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// Whether cells of a species have meshes of their own.
bool hasMembranes(const Problem& problem, int species) {
  return std::any_of(problem.membranes.begin(), problem.membranes.end(),
                     [&](const Membrane& one) { return one.species == species; });
}

class CellFiles {
 public:
  CellFiles(const Problem& problem, const OutputRequest& output, const PackingResult& result,
            const std::vector<std::int64_t>& counts)
      : problem_(problem), output_(output), result_(result), counts_(counts), shared_(problem.ranks) {}

  std::vector<fs::path> operator()() {
    write(output_.folder, Vec3::Zero());
    for (const OtherLattice& other : problem_.lumen.others)
      if (!other.shift.isZero()) write(output_.folder / fmt::format("dx_{:.15g}", other.dx), other.shift);
    shared_.commit();
    return paths_;
  }

 private:
  /// @param shift of the frame of the files [µm]
  void write(const fs::path& folder, const Vec3& shift) {
    shared_.makeFolder(folder);
    for (std::size_t s = 0; s < problem_.species.size(); ++s) {
      if (problem_.species[s].mostCells() == 0) continue;
      if (hasMembranes(problem_, int(s))) {
        log::info(fmt::format(
            "{0}.pos is not written: it cannot have cells with meshes of their own{1}",
            problem_.species[s].name,
            output_.stateFile
                ? fmt::format("; {0} has them (in the case: packmesh::loadParticles(hemocell, \"{0}\"))",
                              output_.stateFile->string())
                : ""));
        continue;
      }
      paths_.push_back(folder / (problem_.species[s].name + ".pos"));
      shared_.begin(paths_.back());
      shared_.append([&] { return formatPosHead(counts_[s]); });
      shared_.appendParts(posLines(int(s), shift));
      shared_.end();
    }
  }

  /// This rank's lines, in any number of pieces.
  std::vector<std::string> posLines(int species, const Vec3& shift) const {
    std::vector<std::size_t> own;
    for (std::size_t i = 0; i < result_.cells.size(); ++i)
      if (problem_.speciesOf(result_.cells[i].species) == species) own.push_back(i);
    constexpr std::int64_t linesOfPiece = 4096;
    const auto count = static_cast<std::int64_t>(own.size());
    std::vector<std::string> pieces(static_cast<std::size_t>((count + linesOfPiece - 1) / linesOfPiece));
    problem_.team.forEachPart(
        count,
        [&](std::int64_t begin, std::int64_t end, int) {
          std::vector<PosLine> lines;
          for (std::int64_t i = begin; i < end; ++i) {
            lines.push_back(problem_.read.lineOf(result_.poses[own[i]]));
            lines.back().position += shift;
          }
          pieces[begin / linesOfPiece] = formatPosLines(lines);
        },
        linesOfPiece);
    return pieces;
  }

  const Problem& problem_;
  const OutputRequest& output_;
  const PackingResult& result_;
  const std::vector<std::int64_t>& counts_;
  std::vector<fs::path> paths_;
  SharedFiles shared_;
};

}  // namespace

std::vector<fs::path> writeCellFiles(const Problem& problem, const OutputRequest& output,
                                     const PackingResult& result, const std::vector<std::int64_t>& counts) {
  return CellFiles(problem, output, result, counts)();
}

}  // namespace packmesh::hemocell
