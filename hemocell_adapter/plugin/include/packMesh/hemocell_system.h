// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file What the plug-in's two halves exchange: the half that is compiled with HemoCell's headers, in the
/// standard and with the flags of HemoCell (packMesh/hemocell.h), and the library, which knows none of them.
/// C++11, plain data: a Cell here is not that of the library, which has types of C++17.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace packmesh {

/// What to pack. Everything that is not set is as `<packing>` in config.xml says, or the program's default.
struct PackingOptions {
  double hematocrit = -1.0;            ///< of the fluid nodes, by the volume of the meshes; negative: not set
  std::map<std::string, long> counts;  ///< by name of the cell type
  std::map<std::string, double> ratios;  ///< cells of a type per red cell
  long seed = -1;
  double clearance = -1.0;      ///< least gap between membranes [µm]
  double wallClearance = -1.0;  ///< least gap to the wall [µm]
  std::string method;           ///< "relaxation" or "cat"
  std::string stateFile;  ///< to write the packing to, for loadParticles(hemocell, stateFile) and the program
  std::string posFolder;  ///< to write .pos files to, too
  bool periodic = true;   ///< cells cross the periodic faces of the system; false: none does
  std::int64_t mostNodesOnEveryRank = -1;  ///< without effect since 1.1.0, gone in 2.0.0
  std::vector<std::string> more;           ///< any further options of the program: {"--max-time", "3600"}
};

namespace plugin {

/// Named by a hash of what follows and precedes (tests/rules/check_layout.py): a case that was compiled with
/// other headers than those of the library that it finds does not start, instead of being misread.
__attribute__((visibility("default"))) extern const int interface_ba88018d;

/// A cell type of HemoCell.
struct CellType {
  std::string name;
  std::vector<std::array<double, 3>> vertices;  ///< of the template, around any point [nodes]
  std::vector<std::array<int, 3>> triangles;
  int minimumDistanceFromSolid = 0;  ///< [µm]
  double volume = 0.0;               ///< `<Volume>` [µm³]; 0: none
};

/// A block of the lattice that this rank has, without its envelope.
struct Block {
  std::array<std::int64_t, 3> first, last;  ///< its nodes, both included
  std::vector<unsigned char> fluid;         ///< 1 or 0 for each node, the last axis fastest
};

/// A running HemoCell, as one rank knows it.
struct System {
  const void* ranks = nullptr;              ///< pointer to the MPI_Comm of the ranks that have the cells
  double dx = 0.0;                          ///< [µm]
  std::array<std::int64_t, 3> first, last;  ///< nodes of the whole lattice, both included
  std::array<bool, 3> periodic;
  bool isPreInlet = false;
  int particleEnvelope = 0;  ///< [nodes]
  std::string config;        ///< config.xml, each tag in the line that it has in the file
  std::vector<CellType> types;
  std::vector<Block> blocks;
};

/// A cell in one of its images.
struct Cell {
  int type;
  std::int64_t id;
  /// Of a cell that is deformed, or of a running simulation, in one piece [nodes]; empty: it is the template,
  /// moved as below.
  std::vector<std::array<double, 3>> vertices;
  std::array<double, 9> linear;       ///< applied to the template centred on its bounding box; by rows
  std::array<double, 3> translation;  ///< [nodes]
};

struct Filling {
  int exitCode = 0;                  ///< that of the program; 0: all went well
  std::string message;               ///< why not
  std::vector<std::int64_t> counts;  ///< cells of each type, on all ranks
  std::vector<Cell> cells;           ///< that have vertices in blocks of this rank
};

/// What this rank has of one image of a cell of a running simulation.
struct CellPart {
  int type;
  std::int64_t id;               ///< of the cell
  std::int64_t image;            ///< HemoCell's number of the cell is id + image · (number of cells)
  std::int64_t vertices;         ///< in blocks of this rank
  std::array<double, 3> lo, hi;  ///< bounding box of these vertices [nodes]
};

/// A running HemoCell whose cells are watched, as one rank knows it.
struct Watch {
  const void* ranks = nullptr;  ///< pointer to the MPI_Comm of the ranks that have the cells
  std::int64_t iteration = 0;
  double dx = 0.0;                    ///< [µm]
  std::array<std::int64_t, 3> nodes;  ///< of the whole lattice
  std::array<bool, 3> periodic;
  std::array<std::int64_t, 3> imageSteps;  ///< what one period along an axis adds to CellPart::image
  std::array<bool, 3> divided;             ///< a block of this rank is shorter than the lattice
  int particleEnvelope = 0;                ///< [nodes]
  double margin = 1.0;                     ///< [nodes]
  std::vector<CellType> types;
};

/// A cell that is nearly as long as the envelope.
struct LongCell {
  int type;
  int axis;
  std::int64_t id;
  double nodes;  ///< extent along the axis
};

/// Found by watch(), the same on all ranks.
struct Watched {
  std::vector<std::int64_t> counts;  ///< cells of each type that have all vertices
  std::int64_t incomplete = 0;       ///< cells that lack vertices: HemoCell deletes them
  double longest = 0.0;              ///< longest extent along an axis [nodes]
  std::vector<LongCell> tooLong;     ///< by decreasing extent
  std::string message;               ///< about the longest of these, with the remedy; empty if there is none
};

/// Packs the cells that the request and `<packing>` ask for. All ranks of `system.ranks` call. Throws
/// nothing.
__attribute__((visibility("default"))) Filling fill(const System& system, const PackingOptions& options);

/// The cells of a state file. All ranks of `system.ranks` call. Throws nothing.
/// @param leavesOut cells that HemoCell would delete are left out; otherwise they are an error
__attribute__((visibility("default"))) Filling load(const System& system, const std::string& stateFile,
                                                    bool leavesOut);

/// Writes cells of a running simulation to a state file. Every cell comes from one rank, which has all its
/// vertices. All ranks of `system.ranks` call. Throws
/// nothing.
/// @param rigid instead of their vertices, the rigid templates that fit best are kept
/// @return only exit code and message
__attribute__((visibility("default"))) Filling save(const System& system, const std::vector<Cell>& cells,
                                                    std::int64_t iteration, const std::string& stateFile,
                                                    bool rigid);

/// Finds cells whose extent along an axis comes within `margin` of the envelope, where blocks or periodic
/// faces divide the lattice: HemoCell deletes a cell that is longer. All ranks of `watch.ranks` call.
__attribute__((visibility("default"))) Watched watch(const Watch& watch, const std::vector<CellPart>& parts);

/// Writes `<name>.pos` with the number of cells only, to the folder of the checkpoint and to the working
/// directory. Files with cells stay; if they announce other numbers, and some axis is periodic, a warning
/// says what that means. Files that cannot be written are a warning. One rank calls. Throws nothing.
__attribute__((visibility("default"))) void writeCounts(const std::vector<std::string>& names,
                                                        const std::vector<std::int64_t>& counts,
                                                        const std::string& checkpointFolder, bool periodic);

}  // namespace plugin
}  // namespace packmesh
