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

/// Part of a file: a header, then this rank's lines.
struct Section {
  std::string head;
  std::function<std::string()> lines;
};

struct File {
  fs::path path;
  std::vector<Section> sections;
};

class CellFiles {
 public:
  CellFiles(const Scene& scene, const PackingResult& result, const std::vector<std::int64_t>& counts,
            const Communicator& ranks)
      : scene_(scene), result_(result), counts_(counts), ranks_(ranks), shared_(ranks) {}

  std::vector<fs::path> operator()(bool withPos) {
    shared_.makeFolder(scene_.outputDirectory);
    if (withPos) addPosFiles();
    for (const std::string& format : scene_.exports) addExport(format);
    for (const File& file : files_) write(file);
    shared_.commit();
    std::vector<fs::path> paths;
    for (const File& file : files_) paths.push_back(file.path);
    return paths;
  }

 private:
  void addPosFiles() {
    for (std::size_t s = 0; s < scene_.species.size(); ++s) {
      if (scene_.species[s].mostCells() == 0) continue;
      const auto lines = [this, s] {
        std::vector<PosLine> own;
        for (std::size_t i = 0; i < result_.cells.size(); ++i)
          if (result_.cells[i].species == int(s)) own.push_back(scene_.read.lineOf(result_.poses[i]));
        return formatPosLines(own);
      };
      files_.push_back(
          {scene_.outputDirectory / (scene_.species[s].name + ".pos"), {{formatPosHead(counts_[s]), lines}}});
    }
  }

  void addExport(const std::string& format) {
    for (const ExportedFile& exported : exportedFiles(format, scene_, counts_)) {
      File file{scene_.outputDirectory / exported.name, {}};
      for (const ExportedSection& section : exported.sections)
        file.sections.push_back({section.head, [this, section] { return linesOf(section); }});
      files_.push_back(std::move(file));
    }
  }

  std::string linesOf(const ExportedSection& section) const {
    std::int64_t number = firstNumber();
    std::string text;
    for (std::size_t i = 0; i < result_.cells.size(); ++i, ++number)
      if (section.species < 0 || section.species == result_.cells[i].species)
        text += section.line({result_.cells[i].species, number, result_.poses[i]});
    return text;
  }

  /// For this rank's cells, from 1 on.
  std::int64_t firstNumber() const {
    return 1 + ranks_.sumBefore({std::int64_t(result_.cells.size())}).front();
  }

  void write(const File& file) {
    shared_.begin(file.path);
    for (const Section& section : file.sections) {
      shared_.append([&] { return section.head; });
      shared_.appendParts(section.lines());
    }
    shared_.end();
  }

  const Scene& scene_;
  const PackingResult& result_;
  const std::vector<std::int64_t>& counts_;
  const Communicator& ranks_;
  std::vector<File> files_;
  SharedFiles shared_;
};

}  // namespace

std::vector<fs::path> writeCellFiles(const Scene& scene, const PackingResult& result,
                                     const std::vector<std::int64_t>& counts, const Communicator& ranks) {
  return CellFiles(scene, result, counts, ranks)(true);
}

std::vector<fs::path> writeExports(const Scene& scene, const PackingResult& result,
                                   const std::vector<std::int64_t>& counts, const Communicator& ranks) {
  return CellFiles(scene, result, counts, ranks)(false);
}

}  // namespace packmesh::hemocell
