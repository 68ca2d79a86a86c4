// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/cell_files.h"

#include <functional>
#include <string>

#include "hemocell_adapter/hemocell/pos_file.h"
#include "hemocell_adapter/output/exports.h"
#include "hemocell_adapter/output/shared_files.h"

namespace packmesh::hemocell {
namespace {

namespace fs = std::filesystem;

/// Part of a file: a header, then this rank's lines, in any number of pieces.
struct Section {
  std::string head;
  std::function<std::vector<std::string>()> lines;
};

struct File {
  fs::path path;
  std::vector<Section> sections;
};

class CellFiles {
 public:
  CellFiles(const Problem& problem, const OutputRequest& output, const PackingResult& result,
            const std::vector<std::int64_t>& counts)
      : problem_(problem), output_(output), result_(result), counts_(counts), shared_(problem.ranks) {}

  std::vector<fs::path> operator()(bool withPos) {
    shared_.makeFolder(output_.folder);
    if (withPos) addPosFiles();
    for (const ExportedFile& exported : exportedFiles(problem_, output_.exports, counts_))
      addExport(exported);
    for (const File& file : files_) write(file);
    shared_.commit();
    std::vector<fs::path> paths;
    for (const File& file : files_) paths.push_back(file.path);
    return paths;
  }

 private:
  void addPosFiles() {
    for (std::size_t s = 0; s < problem_.species.size(); ++s) {
      if (problem_.species[s].mostCells() == 0) continue;
      files_.push_back({output_.folder / (problem_.species[s].name + ".pos"),
                        {{formatPosHead(counts_[s]), [this, s] { return posLines(static_cast<int>(s)); }}}});
    }
  }

  std::vector<std::string> posLines(int species) const {
    std::vector<std::size_t> own;
    for (std::size_t i = 0; i < result_.cells.size(); ++i)
      if (result_.cells[i].species == species) own.push_back(i);
    constexpr std::int64_t linesOfPiece = 4096;
    const auto count = static_cast<std::int64_t>(own.size());
    std::vector<std::string> pieces(static_cast<std::size_t>((count + linesOfPiece - 1) / linesOfPiece));
    problem_.team.forEachPart(
        count,
        [&](std::int64_t begin, std::int64_t end, int) {
          std::vector<PosLine> lines;
          for (std::int64_t i = begin; i < end; ++i)
            lines.push_back(problem_.read.lineOf(result_.poses[own[i]]));
          pieces[begin / linesOfPiece] = formatPosLines(lines);
        },
        linesOfPiece);
    return pieces;
  }

  void addExport(const ExportedFile& exported) {
    File file{output_.folder / exported.name, {}};
    for (const ExportedSection& section : exported.sections)
      file.sections.push_back(
          {section.head, [this, section] { return std::vector<std::string>{textOf(section)}; }});
    files_.push_back(std::move(file));
  }

  std::string textOf(const ExportedSection& section) const {
    std::string text;
    if (!section.text) return text;
    ExportedCell cell;
    cell.before = problem_.ranks.sumBefore(countsOf(problem_, result_.cells));
    for (std::size_t i = 0; i < result_.cells.size(); ++i) {
      cell.species = result_.cells[i].species;
      cell.pose = result_.poses[i];
      cell.placement = result_.cells[i].placement;
      if (section.species < 0 || section.species == cell.species) text += section.text(cell);
      ++cell.before[cell.species];
    }
    return text;
  }

  void write(const File& file) {
    shared_.begin(file.path);
    for (const Section& section : file.sections) {
      shared_.append([&] { return section.head; });
      shared_.appendParts(section.lines());
    }
    shared_.end();
  }

  const Problem& problem_;
  const OutputRequest& output_;
  const PackingResult& result_;
  const std::vector<std::int64_t>& counts_;
  std::vector<File> files_;
  SharedFiles shared_;
};

}  // namespace

std::vector<fs::path> writeCellFiles(const Problem& problem, const OutputRequest& output,
                                     const PackingResult& result, const std::vector<std::int64_t>& counts) {
  return CellFiles(problem, output, result, counts)(true);
}

std::vector<fs::path> writeExports(const Problem& problem, const OutputRequest& output,
                                   const PackingResult& result, const std::vector<std::int64_t>& counts) {
  return CellFiles(problem, output, result, counts)(false);
}

}  // namespace packmesh::hemocell
