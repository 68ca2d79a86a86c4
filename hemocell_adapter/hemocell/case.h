// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file A HemoCell case: its config.xml and its C++ code, or what a running HemoCell has built of them.
#pragma once

#include <tinyxml2.h>

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hemocell_adapter/base/value.h"
#include "hemocell_adapter/hemocell/lattice.h"
#include "hemocell_adapter/settings/request.h"
#include "packMesh/mesh/triangle_mesh.h"

namespace packmesh::hemocell {

/// Call of hemocell.setInitialMinimumDistanceFromSolid("RBC", 1).
struct DistanceCall {
  std::string where;                ///< "pipeflow.cpp:91"
  std::string text;                 ///< the call, for messages
  std::optional<std::string> name;  ///< name of the cell; empty: not a literal
  std::optional<double> distance;   ///< [µm]; empty: not a literal
};

/// Call of preInlet->autoPreinletFromBoundary(Direction::Xpos) or preInletFromSlice(Direction::Xpos, slice).
struct PreInletCall {
  std::string where, text;
  std::optional<std::string> direction;  ///< "Xpos"; empty: not a literal
  std::optional<NodePlane> slice;        ///< of autoPreinletFromBoundary with a literal
};

/// Call of hemocell.setSystemPeriodicityLimit(0, 45).
struct PeriodicityCall {
  std::optional<double> axis, limit;  ///< empty: not a literal
};

/// Call of defineDynamics(lattice, box, new BounceBack...), which makes the nodes of a box solid.
struct WallCall {
  std::string where, text;
};

/// Call of hemocell.setSystemPeriodicity(1, true), unless it says false.
struct PeriodicAxis {
  std::string where, text;
  std::optional<int> axis;  ///< empty: not a literal
};

struct CaseSource {
  std::vector<std::string> files;   ///< names of the files that were read
  std::vector<std::string> unread;  ///< reasons why other files were not read
  std::vector<DistanceCall> distances;
  std::vector<PreInletCall> preInlets;
  std::vector<PeriodicityCall> periodicity;
  std::vector<WallCall> walls;
  std::vector<PeriodicAxis> periodicAxes;
};

/// Reads the C++ files of a folder, sorted by name; not those of subfolders.
CaseSource readCaseSource(const std::filesystem::path& folder);

/// Adds the calls in the text of one file: those of members (`hemocell.` or `hemocell->`) outside comments.
/// Text that is not C++ is accepted. @param file its name, for messages
void scanSource(const std::string& text, const std::string& file, CaseSource& source);

/// The file that has this XML, up to white space between tags: among the words of this program's command
/// line, or config.xml; empty if none has.
std::optional<std::filesystem::path> runningCaseFile(const tinyxml2::XMLDocument& document);

constexpr double pnMicrometresPerJoule = 1e18;

/// `<domain>`: the data that determine the lattice, and the unit of energy of membranes.
struct Domain {
  double dx = 0.0;                                ///< [µm]
  std::string dxWhere;                            ///< "config.xml:32: <dx>"
  std::optional<std::filesystem::path> geometry;  ///< STL file, relative to the working directory or absolute
  std::string geometryWhere;                      ///< "config.xml:31: <geometry>"
  int refDir = 0, refDirN = 0;                    ///< only with a geometry
  std::optional<std::array<int, 3>> boxNodes;     ///< only without a geometry; or <container> has nodes
  std::optional<int> particleEnvelope;            ///< [nodes]
  std::string particleEnvelopeWhere;              ///< "config.xml:33: <particleEnvelope>"
  std::optional<double> wallShearStress;          ///< the largest that the case expects [Pa]
  std::optional<double> thermalEnergy;  ///< `<kBT>`: forces of membranes are proportional to it [pN µm]
  std::string thermalEnergyWhere;       ///< "config.xml:34: <kBT>"
  std::optional<std::array<int, 3>> smallestBlock;  ///< of a running HemoCell: least nodes along each axis
};

/// A cell type of a running HemoCell.
struct BuiltCell {
  std::string name;
  TriangleMesh mesh;                     ///< the template, centred on its bounding box [µm]
  int minimumDistanceFromSolid = 0;      ///< as HemoCell stores it [µm]
  std::optional<double> hemocellVolume;  ///< `<Volume>` [µm³]
};

/// What a running HemoCell has built, and the program otherwise derives from files and C++ code.
struct RunningSystem {
  std::vector<BuiltCell> cells;
  std::shared_ptr<const Lattice> lattice;  ///< nodes that no block covers are solid
  std::array<bool, 3> periodic{};
  bool isPreInlet = false;  ///< the lattice is that of the pre-inlet

  /// nullptr if there is none of this name.
  const BuiltCell* cell(const std::string& name) const {
    for (const BuiltCell& one : cells)
      if (one.name == name) return &one;
    return nullptr;
  }
};

/// A HemoCell case. Made by readCase() from its folder, and by the plug-in from a running HemoCell: then with
/// the running system, without C++ code and geometry, and the working directory is its folder.
struct Case {
  std::filesystem::path file, folder;  ///< config.xml, and where it is
  Domain domain;
  bool hasPreInlet = false;
  std::optional<int> preInletLength;  ///< `<preInlet><parameters><lengthN>` [nodes]
  Request packing;    ///< its contents; relative paths are made relative to the working directory
  CaseSource source;  ///< what the C++ code beside config.xml says
  std::optional<RunningSystem> running;
};

/// Reads config.xml and the C++ code beside it. Unneeded tags outside `<packing>` are ignored, as in
/// HemoCell; the others are read strictly (HemoCell reads a malformed number as 0).
/// @throws InputError with file, line, tag, value and what was expected
Case readCase(const std::filesystem::path& file);

/// Only what config.xml says about packing: its `<packing>` section and `<kBT>`, read as strictly. For a
/// running HemoCell, which has read the rest.
/// @param text the XML, each tag in the line that it has in the file; the root is `<hemocell>`, or
/// `<Checkpoint>` around it: `<packing>` is not read then, as HemoCell does not write attributes to its
/// checkpoints
/// @throws InputError with file and line
Case packingSectionOf(const std::string& text);

}  // namespace packmesh::hemocell
