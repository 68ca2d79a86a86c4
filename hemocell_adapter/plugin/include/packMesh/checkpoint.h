// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file Restarts that keep the cells across periodic faces. Part of packMesh/hemocell.h. C++11.
///
/// The parts of a cell at opposite faces have numbers that differ by a multiple of the number of cells.
/// HemoCell::loadCheckPoint() takes that number from the first lines of `<name>.pos`, and deletes the cells
/// whose parts it does not recognise. So loadParticles() leaves files with only these lines: in the
/// checkpoint directory, for loadCheckPoint() below, and in the working directory, for HemoCell's own, unless
/// there are files with cells.
#pragma once

#include <hemocell.h>
#include <mpi.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "packMesh/failure.h"
#include "packMesh/hemocell_system.h"
#include "packMesh/running_hemocell.h"

namespace packmesh {
namespace plugin {

inline std::vector<std::string> typeNames(hemo::HemoCell& hemocell) {
  std::vector<std::string> names;
  for (unsigned int t = 0; t < hemocell.cellfields->size(); ++t)
    names.push_back((*hemocell.cellfields)[t]->name);
  return names;
}

/// Types under names that lead HemoCell to `.pos` files of a folder, until the end of this object's life.
class NamesInFolder {
 public:
  NamesInFolder(hemo::HemoCell& hemocell, const std::string& folder)
      : hemocell_(hemocell), names_(typeNames(hemocell)) {
    for (unsigned int t = 0; t < names_.size(); ++t) (*hemocell_.cellfields)[t]->name = folder + names_[t];
  }
  ~NamesInFolder() {
    for (unsigned int t = 0; t < names_.size(); ++t) (*hemocell_.cellfields)[t]->name = names_[t];
  }
  NamesInFolder(const NamesInFolder&) = delete;
  NamesInFolder& operator=(const NamesInFolder&) = delete;

 private:
  hemo::HemoCell& hemocell_;
  std::vector<std::string> names_;
};

}  // namespace plugin

/// Cells in a running HemoCell.
struct LoadedParticles {
  std::vector<std::int64_t> counts;  ///< cells of each type, in HemoCell's order, on all ranks
  std::int64_t cells = 0;            ///< of all types
};

namespace plugin {

/// The vertices of each type that HemoCell now has, on all ranks.
inline std::vector<std::int64_t> verticesOf(hemo::HemoCell& hemocell) {
  auto& particles = *hemocell.cellfields->immersedParticles;
  std::vector<std::int64_t> vertices(hemocell.cellfields->size(), 0);
  for (const plb::plint id : particles.getLocalInfo().getBlocks()) {
    hemo::HemoCellParticleField& block = particles.getComponent(id);
    for (const hemo::HemoCellParticle& particle : block.particles)
      if (block.isContainedABS(particle.sv.position, block.localDomain)) ++vertices[particle.sv.celltype];
  }
  MPI_Allreduce(MPI_IN_PLACE, vertices.data(), static_cast<int>(vertices.size()), MPI_INT64_T, MPI_SUM,
                MPI_COMM_WORLD);
  return vertices;
}

/// Stops unless HemoCell has every vertex of every cell.
inline void requireComplete(hemo::HemoCell& hemocell, const std::vector<std::int64_t>& counts) {
  const std::vector<std::int64_t> vertices = verticesOf(hemocell);
  std::string missing, doubled;
  for (std::size_t t = 0; t < counts.size(); ++t) {
    hemo::HemoCellField& field = *(*hemocell.cellfields)[static_cast<unsigned int>(t)];
    const std::int64_t lost = counts[t] * field.numVertex - vertices[t];
    if (lost < 0) doubled += (doubled.empty() ? "" : ", ") + std::to_string(-lost) + " of " + field.name;
    if (lost <= 0) continue;
    missing += (missing.empty() ? "" : ", ") +
               std::to_string((lost + field.numVertex - 1) / field.numVertex) + " of " +
               std::to_string(counts[t]) + " " + field.name;
  }
  const std::string when =
      hemocell.iter == 0 ? "" : "before the end of iteration " + std::to_string(hemocell.iter) + " ";
  if (missing.empty() && !doubled.empty())
    stop(70, "HemoCell has more vertices " + when + "than were packed: " + doubled +
                 ". Do atomic blocks disagree on where a vertex is?");
  if (missing.empty()) return;
  stop(70,
       "HemoCell deleted cells " + when + "that were packed: " + missing +
           ". Is <particleEnvelope> longer than the cells, and no atomic block smaller than it? Was there a "
           "warning of periodic faces between ranks? Was a vertex on a wall node, or did it move there?");
}

/// Leaves the numbers of cells for restarts.
inline void recordCounts(hemo::HemoCell& hemocell, const std::vector<std::int64_t>& counts) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  auto& particles = *hemocell.cellfields->immersedParticles;
  bool periodic = false;
  for (int axis = 0; axis < 3; ++axis) periodic = periodic || particles.periodicity().get(axis);
  if (rank == 0) writeCounts(typeNames(hemocell), counts, hemo::global.checkpointDirectory, periodic);
}

/// Where HemoCell is going to find the checkpoint: with a checkpointed config.xml, it knows only later.
inline std::string checkpointFolder(hemo::HemoCell& hemocell) {
  if (!hemocell.cfg->checkpointed) return hemo::global.checkpointDirectory;
  const auto* root = (*hemocell.cfg)["domain"].getOrig()->GetDocument()->FirstChildElement("Checkpoint");
  const auto textOf = [](const tinyxml2::XMLElement* parent, const char* name, const std::string& otherwise) {
    const auto* element = parent ? parent->FirstChildElement(name) : nullptr;
    std::string text = element && element->GetText() ? element->GetText() : otherwise, word;
    std::istringstream(text) >> word;
    return word;
  };
  const auto* parameters = root->FirstChildElement("hemocell")->FirstChildElement("parameters");
  std::string output = textOf(root->FirstChildElement("General"), "OutDirectory", ".");
  if (output.back() != '/') output += '/';
  return output + textOf(parameters, "checkpointDirectory", "checkpoint") + "/";
}

/// The folder whose `.pos` files have the numbers of cells: that of the checkpoint, or else the working
/// directory. Stops if neither has them. All ranks call.
inline std::string folderOfCounts(hemo::HemoCell& hemocell) {
  const std::string folder = checkpointFolder(hemocell);
  const std::vector<std::string> names = typeNames(hemocell);
  int rank = 0, choice = 0;  // 0: none; 1: of the checkpoint; 2: the working directory
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const auto complete = [&](const std::string& in) {
    for (const std::string& name : names) {
      std::ifstream file(in + name + ".pos");
      long count = -1;
      if (!(file >> count) || count < 0) return false;
    }
    return true;
  };
  if (rank == 0) choice = complete(folder) ? 1 : complete("") ? 2 : 0;
  MPI_Bcast(&choice, 1, MPI_INT, 0, MPI_COMM_WORLD);
  if (choice == 0) {
    std::string files;
    for (const std::string& name : names) files += (files.empty() ? "" : ", ") + name + ".pos";
    stop(2,
         "The number of cells of the checkpoint is unknown, and HemoCell would delete the cells across "
         "periodic "
         "faces: neither " +
             folder + " nor the working directory has " + files +
             ". Write these files: one line each, the number of cells of this type at the start of the first "
             "run.");
  }
  return choice == 1 ? folder : "";
}

}  // namespace plugin

/// hemocell.loadCheckPoint(), which keeps the cells across periodic faces. Stops, before HemoCell deletes
/// any, if the number of cells is not known. Collective.
/// @return the cells of the checkpoint
inline LoadedParticles loadCheckPoint(hemo::HemoCell& hemocell) {
  const std::string folder = plugin::folderOfCounts(hemocell);
  {
    const plugin::NamesInFolder names(hemocell, folder);
    hemocell.loadCheckPoint();
  }
  LoadedParticles loaded;
  const std::vector<std::int64_t> vertices = plugin::verticesOf(hemocell);
  for (unsigned int t = 0; t < vertices.size(); ++t) {
    loaded.counts.push_back(vertices[t] / (*hemocell.cellfields)[t]->numVertex);
    loaded.cells += loaded.counts.back();
  }
  return loaded;
}

/// Sets HemoCell's number of cells, where it has counted `.pos` files again (in setSystemPeriodicity()).
/// @param cells what loadParticles() returned
inline void restoreNumberOfCells(hemo::HemoCell& hemocell, std::int64_t cells) {
  hemocell.cellfields->number_of_cells = static_cast<int>(cells);
}

}  // namespace packmesh
